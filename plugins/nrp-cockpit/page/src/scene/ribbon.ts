import type { Trail } from "../world/trail";

const HALF_WIDTH_M = 0.02;
/** Above the robot's own origin, so that the ground does not hide it. */
const LIFT_M = 0.012;

/**
 * Writes a trail as a band along the ground: two corners for each point, left and right of the path.
 * Returns the number of points written; `corners` holds 6 numbers for each. The width shrinks with the `unit`.
 */
export function writeRibbon({ x, y, z }: Trail, corners: Float32Array, unit = 1): number {
  const count = Math.min(x.length, Math.floor(corners.length / 6));
  for (let i = 0; i < count; i++) {
    const before = Math.max(0, i - 1);
    const after = Math.min(count - 1, i + 1);
    const dx = at(x, after) - at(x, before);
    const dy = at(y, after) - at(y, before);
    const scale = (unit * HALF_WIDTH_M) / (Math.hypot(dx, dy) || 1);
    const height = at(z, i) + unit * LIFT_M;
    corners.set([at(x, i) - dy * scale, at(y, i) + dx * scale, height], 6 * i);
    corners.set([at(x, i) + dy * scale, at(y, i) - dx * scale, height], 6 * i + 3);
  }
  return count;
}

const at = (values: readonly number[], index: number) => values[index] ?? 0;

/** The triangles between the corners of `points` points. */
export function ribbonTriangles(points: number): Uint32Array {
  const indices = new Uint32Array(6 * Math.max(0, points - 1));
  for (let i = 0; i + 1 < points; i++) {
    const a = 2 * i;
    indices.set([a, a + 1, a + 2, a + 1, a + 3, a + 2], 6 * i);
  }
  return indices;
}
