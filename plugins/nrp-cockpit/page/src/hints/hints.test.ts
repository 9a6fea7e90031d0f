import { expect, test } from "vitest";
import { followed, hints, nextHint, type Seen } from "./hints";

const screen = {
  name: "right_vr_screen",
  static: true,
  pose: null,
  topics: [],
  colorable: "/screens/right/color",
  colored_part: "right_vr_screen/body/screen_glass",
};
const start: Seen = {
  experiment: { bodies: [{ ...screen, name: "sofa", colorable: "/sofa/body/seat/color" }, screen] },
  status: { state: "paused" },
  selected: undefined,
  view: "cockpit",
};
const none: ReadonlySet<string> = new Set();

test("a visit begins with Play", () => {
  expect(nextHint(none)?.hint.text(start)).toBe("Press Play (Space)");
  expect(followed(none, start)).toBe(none);
});

test("a hint that was followed is not shown again, whatever is done later", () => {
  const played = followed(none, { ...start, status: { state: "running" } });
  expect(nextHint(followed(played, start))?.number).toBe(2);
});

test("the second hint names a body whose colour the experiment uses, if there is one", () => {
  const played = new Set(["play"]);
  expect(nextHint(played)?.hint.text(start)).toContain("right_vr_screen");
  expect(nextHint(played)?.hint.text({ ...start, experiment: { bodies: [] } })).toBe(
    "Click a body in the scene",
  );
});

test("hints may be followed in any order, and then there are none", () => {
  const done = followed(none, { ...start, selected: "body", view: "functions" });
  expect(nextHint(done)?.number).toBe(1);
  expect(nextHint(new Set(hints.map(({ id }) => id)))).toBeNull();
});
