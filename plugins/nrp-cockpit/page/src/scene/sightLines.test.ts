import { expect, it } from "vitest";
import { frustumLines, writeRays } from "./sightLines";

it("a camera with a right angle of view sees as far to the left as ahead", () => {
  const lines = frustumLines(Math.PI / 2, 2);
  expect(lines).toHaveLength(4 * 2 * 2 * 3);
  const points = Array.from({ length: 16 }, (_, at) => [...lines.subarray(3 * at, 3 * at + 3)]);
  const far = points.filter(([x]) => x === 1);
  expect(far).toHaveLength(12);
  for (const [, y = 0, z = 0] of far) {
    expect(Math.abs(y)).toBeCloseTo(1);
    expect(Math.abs(z)).toBeCloseTo(0.5);
  }
});

it("only rays that hit something are drawn, each where it points", () => {
  const ranges = new Float32Array([2, Infinity, 0.01, 3]);
  const scan = { angle_min: 0, angle_increment: Math.PI / 2, range_min: 0.1, range_max: 10, ranges };
  const lines = new Float32Array(24);
  expect(writeRays(scan, lines)).toBe(4);
  expect([...lines.subarray(0, 6)]).toEqual([0, 0, 0, 2, 0, 0]);
  expect(lines[9]).toBeCloseTo(0);
  expect(lines[10]).toBeCloseTo(-3);
});

it("rays beyond the room in memory are left out", () => {
  const scan = {
    angle_min: 0,
    angle_increment: 1,
    range_min: 0,
    range_max: 9,
    ranges: new Float32Array(5).fill(1),
  };
  expect(writeRays(scan, new Float32Array(12))).toBe(4);
});
