import { describe, expect, test } from "vitest";
import { curveOf, valueAt } from "./curve";
import { TimeRing } from "./timeRing";

const SCALE = { from_s: 0, to_s: 10, left: 0, right: 100 };

const series = (...points: [number, number][]) => {
  const ring = new TimeRing(2 ** 16);
  for (const [t_s, value] of points) ring.push(t_s, value);
  return ring;
};
const pointsOf = ({ xs, values }: { xs: number[]; values: number[] }) => xs.map((x, at) => [x, values[at]]);

describe("a curve", () => {
  test("holds each value until the next, and the last until now", () => {
    const curve = curveOf(series([1, 5], [3, 7]), SCALE, 6);
    expect(pointsOf(curve)).toEqual([
      [10, 5],
      [30, 5],
      [30, 7],
      [60, 7],
    ]);
    expect([curve.lowest, curve.highest]).toEqual([5, 7]);
  });

  test("begins with the value from before the window", () => {
    expect(pointsOf(curveOf(series([1, 5]), { ...SCALE, from_s: 2, to_s: 12 }, 12))).toEqual([
      [0, 5],
      [100, 5],
    ]);
  });

  test("keeps the extremes of many values in a pixel", () => {
    const ring = new TimeRing(2 ** 16);
    for (let at = 0; at < 50_000; at++) ring.push(at / 5000, at === 25_001 ? 99 : Math.sin(at));
    const curve = curveOf(ring, SCALE, 10);
    expect(curve.highest).toBe(99);
    expect(curve.xs.length).toBeLessThan(600);
  });

  test("is empty without data", () => {
    expect(curveOf(series(), SCALE, 5).xs).toEqual([]);
  });
});

test("the value at a time is the last one before it", () => {
  const ring = series([1, 5], [3, 7]);
  expect([0.5, 1, 2.9, 3, 9].map((t_s) => valueAt(ring, t_s))).toEqual([undefined, 5, 5, 7, 7]);
});
