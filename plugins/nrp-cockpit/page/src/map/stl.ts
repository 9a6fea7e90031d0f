import type { Vector } from "../state/types";

const HEAD_BYTES = 84;
const TRIANGLE_BYTES = 50;

/** The box around the triangles of a binary STL file; null if the file is none, or empty. */
export function boxOfStl(data: Uint8Array): { min: Vector; max: Vector } | null {
  if (data.byteLength < HEAD_BYTES) return null;
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const triangles = view.getUint32(80, true);
  if (triangles === 0 || data.byteLength !== HEAD_BYTES + TRIANGLE_BYTES * triangles) return null;
  const min: Vector = [Infinity, Infinity, Infinity];
  const max: Vector = [-Infinity, -Infinity, -Infinity];
  for (let triangle = 0; triangle < triangles; triangle++) {
    const corners = HEAD_BYTES + TRIANGLE_BYTES * triangle + 12; // behind the normal
    for (let number = 0; number < 9; number++) {
      const axis = (number % 3) as 0 | 1 | 2;
      const value = view.getFloat32(corners + 4 * number, true);
      min[axis] = Math.min(min[axis], value);
      max[axis] = Math.max(max[axis], value);
    }
  }
  return { min, max };
}
