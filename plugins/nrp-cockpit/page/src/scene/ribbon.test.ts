import { expect, it } from "vitest";
import { ribbonTriangles, writeRibbon } from "./ribbon";

it("a trail becomes a band whose corners are left and right of the path", () => {
  const corners = new Float32Array(18);
  const points = writeRibbon({ x: [0, 1, 2], y: [0, 0, 0], z: [0, 0, 0], t_s: [0, 1, 2] }, corners);
  expect(points).toBe(3);
  for (let point = 0; point < 3; point++) {
    const [lx = 0, ly = 0, , rx = 0, ry = 0] = corners.subarray(6 * point, 6 * point + 6);
    expect([lx, rx]).toEqual([point, point]);
    expect(ly).toBeGreaterThan(0);
    expect(ry).toBeCloseTo(-ly);
  }
});

it("a band of n points has n - 1 quadrangles of two triangles", () => {
  expect(ribbonTriangles(3)).toEqual(new Uint32Array([0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4]));
  expect(ribbonTriangles(0)).toHaveLength(0);
});
