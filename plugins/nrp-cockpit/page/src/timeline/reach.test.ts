import { expect, test } from "vitest";
import { type Here, reach, reachByKey } from "./reach";

const live: Here = {
  source: "live",
  state: "paused",
  t_s: 9.12,
  timestep_s: 0.02,
  snapshots: [
    { id: "a", t_s: 0, left: false },
    { id: "b", t_s: 8, left: false },
  ],
  blocked: undefined,
  noWayBack: undefined,
};
const recording: Here = { ...live, source: "recording", snapshots: [] };

test("a recording goes to any time", () => {
  expect(reach(3, recording)).toMatchObject({ act: "seek", t_s: 3 });
  expect(reach(30, recording)).toMatchObject({ act: "seek", t_s: 30 });
});

test("a live run goes on to a later time, at a whole step", () => {
  expect(reach(12.3456, live)).toEqual({ act: "run", t_s: 12.34, says: "Run to 12.34 s" });
});

test("a live run restores the snapshot of that time", () => {
  expect(reach(8.004, live)).toMatchObject({ act: "restore", id: "b" });
});

test("a live run goes back to an earlier time", () => {
  expect(reach(3, live)).toMatchObject({ act: "back", t_s: 3 });
});

test("a run that cannot be saved refuses an earlier time with the reason", () => {
  const noWayBack = "the brain 'nest' cannot save its state";
  expect(reach(3, { ...live, snapshots: [], noWayBack })).toEqual({
    act: "none",
    t_s: 3,
    says: "The run cannot go back: the brain 'nest' cannot save its state.",
  });
});

test("a run that is over does not go on", () => {
  expect(reach(20, { ...live, state: "finished" })).toMatchObject({ act: "none" });
});

test("a viewer who cannot control the run reads why", () => {
  const blocked = "You can watch this run, but not control it.";
  expect(reach(20, { ...live, blocked })).toMatchObject({ act: "none", says: blocked });
});

test("the arrows move a recording by a tenth of a second, and not before its start", () => {
  expect(reachByKey("ArrowRight", recording, 40)?.t_s).toBeCloseTo(9.22);
  expect(reachByKey("PageDown", recording, 40)?.t_s).toBeCloseTo(8.12);
  expect(reachByKey("ArrowLeft", { ...recording, t_s: 0.04 }, 40)?.t_s).toBe(0);
  expect(reachByKey("End", recording, 40)?.t_s).toBe(40);
});

test("the arrows move a live run too, by at least a step", () => {
  expect(reachByKey("ArrowRight", live, 40)).toMatchObject({ act: "run", t_s: 9.22 });
  expect(reachByKey("ArrowLeft", live, 40)).toMatchObject({ act: "back", t_s: 9.02 });
  expect(reachByKey("Home", live, 40)).toMatchObject({ act: "restore", id: "a" });
  expect(reachByKey("ArrowRight", { ...live, timestep_s: 0.5, t_s: 9 }, 40)).toMatchObject({ t_s: 9.5 });
});

test("other keys are left alone", () => {
  expect(reachByKey("x", live, 40)).toBeNull();
});
