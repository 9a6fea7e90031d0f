import { expect, test } from "vitest";
import { type Here, reach, reachByKey } from "./reach";

const live: Here = {
  source: "live",
  state: "paused",
  t_s: 9.12,
  timestep_s: 0.02,
  snapshots: [
    { id: "a", t_s: 0 },
    { id: "b", t_s: 8 },
  ],
  blocked: undefined,
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

test("an earlier time without a snapshot is refused with the reason", () => {
  expect(reach(3, live)).toMatchObject({
    act: "none",
    says: "A run goes back only to a snapshot: click one.",
  });
  expect(reach(3, { ...live, snapshots: [] }).says).toContain("there is none");
});

test("a run that is over does not go on", () => {
  expect(reach(20, { ...live, state: "finished" })).toMatchObject({ act: "none" });
});

test("a viewer who may not steer is told so", () => {
  const blocked = "You may watch this run, not steer it.";
  expect(reach(20, { ...live, blocked })).toMatchObject({ act: "none", says: blocked });
});

test("the arrows move a recording by a tenth of a second, and not before its start", () => {
  expect(reachByKey("ArrowRight", recording, 40)?.t_s).toBeCloseTo(9.22);
  expect(reachByKey("PageDown", recording, 40)?.t_s).toBeCloseTo(8.12);
  expect(reachByKey("ArrowLeft", { ...recording, t_s: 0.04 }, 40)?.t_s).toBe(0);
  expect(reachByKey("End", recording, 40)?.t_s).toBe(40);
});

test("back in a live run is the snapshot before", () => {
  expect(reachByKey("ArrowLeft", live, 40)).toMatchObject({ act: "restore", id: "b" });
  expect(reachByKey("Home", live, 40)).toMatchObject({ act: "restore", id: "a" });
  expect(reachByKey("ArrowLeft", { ...live, t_s: 8 }, 40)).toMatchObject({ act: "restore", id: "a" });
  expect(reachByKey("ArrowLeft", { ...live, snapshots: [] }, 40)).toMatchObject({ act: "none" });
});

test("other keys are left alone", () => {
  expect(reachByKey("x", live, 40)).toBeNull();
});
