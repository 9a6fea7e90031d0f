import { type Box3, Vector3 } from "three";
import { GLB_TYPE } from "../world/glb";
import type { ShapeMesh } from "./bodies";

/** A box is a wall if it is at least this many times as long, in two directions, as it is thick... */
const FLATNESS = 8;
/** ...and at least this part of the room's size. */
const PART_OF_ROOM = 0.4;
/** A target nearer to a wall than this (m) lies on it: it is a floor. */
const ON_IT_M = 0.3;

const centre = new Vector3();
const normal = new Vector3();

/** Hides the walls and the ceiling between the eye and the target, so that one looks into a room as into a doll's house. */
export function openWalls(walls: Iterable<ShapeMesh>, eye: Vector3, target: Vector3): void {
  for (const wall of walls) {
    boxOf(wall).getCenter(centre).applyMatrix4(wall.matrixWorld);
    normal.setFromMatrixColumn(wall.matrixWorld, thinAxis(wall)).normalize();
    wall.visible = !parts(eye.clone().sub(centre).dot(normal), target.clone().sub(centre).dot(normal));
  }
}

/** Whether a wall is between the eye and the target, by their distances from it along its normal (m). */
export const parts = (eye_m: number, target_m: number): boolean =>
  eye_m * target_m < 0 && Math.abs(target_m) > ON_IT_M;

/** Whether a shape is a wall, floor or ceiling of a room of this size. */
export function isWall(mesh: ShapeMesh, room_m: number): boolean {
  if (mesh.shape.kind !== "cube" && mesh.shape.mesh?.type !== GLB_TYPE) return false;
  const [thin = 0, middle = 0, long = 0] = sizeOf(mesh).sort((a, b) => a - b);
  return middle > FLATNESS * thin && long > PART_OF_ROOM * room_m;
}

function thinAxis(mesh: ShapeMesh): number {
  const size = sizeOf(mesh);
  return size.indexOf(Math.min(...size));
}

/** The box around a shape before it is scaled and placed. */
function boxOf({ geometry }: ShapeMesh): Box3 {
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  return geometry.boundingBox as Box3;
}

function sizeOf(mesh: ShapeMesh): number[] {
  const { x, y, z } = boxOf(mesh).getSize(new Vector3());
  return [x, y, z].map((length, at) => Math.abs(length * (mesh.shape.size[at] ?? 1)));
}
