import { describe, expect, it } from "vitest";
import { compose, fromRollPitchYaw, type Pose, poseOf, rollPitchYaw, rotate, transform, yawOf } from "./pose";

const turned = (yaw: number, x: number, y: number): Pose => ({
  position: [x, y, 0],
  orientation: fromRollPitchYaw(0, 0, yaw),
});

const close = (actual: readonly number[], expected: readonly number[]) => {
  expect(actual).toHaveLength(expected.length);
  actual.forEach((value, at) => {
    expect(value).toBeCloseTo(expected[at] ?? Number.NaN, 9);
  });
};

describe("poses", () => {
  it("place a point of a turned frame in the outer frame", () => {
    close(transform(turned(Math.PI / 2, 3, 4), [1, 0, 0]), [3, 5, 0]);
  });

  it("compose as their points do", () => {
    const outer: Pose = { position: [1, -2, 0.5], orientation: fromRollPitchYaw(0.3, -0.8, 2.1) };
    const inner: Pose = { position: [0.2, 0.7, -1], orientation: fromRollPitchYaw(-1.2, 0.4, 0.9) };
    const point = [0.3, -0.6, 0.9] as const;
    close(transform(compose(outer, inner), [...point]), transform(outer, transform(inner, [...point])));
  });

  it("turn x to y with a quarter turn about z", () => {
    close(rotate(fromRollPitchYaw(0, 0, Math.PI / 2), [1, 0, 0]), [0, 1, 0]);
  });

  it("give back the angles that they were made of", () => {
    close(rollPitchYaw(fromRollPitchYaw(0.4, -1.1, 2.9)), [0.4, -1.1, 2.9]);
    expect(yawOf(fromRollPitchYaw(0, 0, -3))).toBeCloseTo(-3);
  });

  it("read a quaternion of length 0 as no rotation", () => {
    const message = { position: { x: 1, y: 2, z: 3 }, orientation: { x: 0, y: 0, z: 0, w: 0 } };
    expect(poseOf(message)).toEqual({ position: [1, 2, 3], orientation: [0, 0, 0, 1] });
  });
});
