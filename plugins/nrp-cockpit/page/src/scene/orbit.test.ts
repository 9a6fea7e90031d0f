import { describe, expect, it } from "vitest";
import {
  axesInImage,
  beginsAt,
  eyeOf,
  FOV_RAD,
  fitted,
  fromAbove,
  imageAxes,
  nearOf,
  orbited,
  panned,
  START,
  STEEPEST,
  zoomed,
} from "./orbit";

const dot = (a: readonly number[], b: readonly number[]) =>
  a.reduce((sum, value, at) => sum + value * (b[at] ?? 0), 0);

describe("the view of the scene", () => {
  it("has its eye at the distance from its target", () => {
    const [x, y, z] = eyeOf({ ...START, target: [1, 2, 3], distance_m: 7 });
    expect(Math.hypot(x - 1, y - 2, z - 3)).toBeCloseTo(7);
  });

  it("never turns over the top", () => {
    expect(orbited(START, 0, 9).elevation).toBe(STEEPEST);
  });

  it("pans across the direction of sight by parts of the image", () => {
    const { right, up } = imageAxes(START);
    const moved = panned(START, 0.5, 0).target;
    expect(dot(moved, up)).toBeCloseTo(0);
    expect(dot(moved, right)).toBeCloseTo(START.distance_m * Math.tan(FOV_RAD / 2));
  });

  it("keeps the point under the pointer in its direction while it zooms", () => {
    const point = [2, -1, 0.5] as const;
    const away = (eye: readonly number[]) => point.map((value, at) => value - (eye[at] ?? 0));
    const before = away(eyeOf(START));
    const after = away(eyeOf(zoomed(START, 0.5, [...point])));
    after.forEach((value, at) => {
      expect(value).toBeCloseTo(0.5 * (before[at] ?? 0));
    });
  });

  it("fits a room by the narrower side of the image", () => {
    const wide = fitted(START, [0, 0, 0], 5, 2).distance_m;
    const narrow = fitted(START, [0, 0, 0], 5, 0.5).distance_m;
    expect(wide).toBeCloseTo(5 / Math.sin(FOV_RAD / 2));
    expect(narrow).toBeGreaterThan(wide);
  });

  it("begins with what stands around a robot, or with the robot where there is nothing else", () => {
    expect([1, 7, 90].map((all_m) => beginsAt(1, all_m))).toEqual([5, 7, 10]);
    const height_m = 2 * beginsAt(1, 1) * Math.tan(FOV_RAD / 2);
    expect(1 / height_m).toBeGreaterThan(0.25); // of the image
  });

  it("comes as near as an insect needs, with nothing cut off before the target", () => {
    const near = zoomed(START, 1e-9);
    expect(near.distance_m).toBeLessThan(0.0025);
    expect(nearOf(near)).toBeLessThan(near.distance_m / 100);
    expect(nearOf(START)).toBe(0.05);
  });

  it("shows x to the right and y to the top from above", () => {
    const [x, y] = axesInImage(fromAbove(START));
    expect(x?.[0]).toBeCloseTo(1);
    expect(y?.[1]).toBeCloseTo(1);
  });
});
