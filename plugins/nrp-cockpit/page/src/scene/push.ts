import { ArrowHelper, Plane, Vector3 } from "three";
import type { Vector } from "../state/types";
import { scale } from "../world/scale";
import type { Hit, Viewer } from "./viewer";

/** The force of a drag in a room, for each metre that the pointer is away from where it took the body. */
const N_PER_M = 100;
/** Smaller bodies are lighter by the third power of their size, but dragged over smaller distances. */
const perMetre_n = () => N_PER_M * scale.unit ** 2;

/** A force in words; a fly needs micronewtons. */
export function newtons(force_n: number): string {
  if (force_n >= 1 || force_n === 0) return `${force_n.toFixed(0)} N`;
  return force_n >= 1e-3 ? `${(1e3 * force_n).toFixed(0)} mN` : `${(1e6 * force_n).toFixed(1)} µN`;
}

/** How long the force of a drag lasts, in simulated time. */
export const PUSH_S = 0.2;

/** A drag that pushes a body along the ground: an arrow from where it was taken to the pointer. */
export class PushDrag {
  /** What the body is pushed with when the drag ends. */
  force_n: Vector = [0, 0, 0];
  private readonly plane: Plane;
  private readonly arrow: ArrowHelper;

  constructor(
    private readonly viewer: Viewer,
    readonly hit: Hit,
  ) {
    this.plane = new Plane(new Vector3(0, 0, 1), -hit.point.z);
    this.arrow = new ArrowHelper(
      new Vector3(1, 0, 0),
      hit.point,
      0.01 * scale.unit,
      viewer.color("--d-vermillion"),
    );
    this.arrow.visible = false;
    viewer.scene.add(this.arrow);
  }

  /** Follows the pointer; returns the force's amount. */
  move(x: number, y: number): number {
    const end = this.viewer.ray(x, y).ray.intersectPlane(this.plane, new Vector3());
    if (!end) return Math.hypot(...this.force_n);
    const way = end.sub(this.hit.point);
    const length = way.length();
    this.force_n = [way.x * perMetre_n(), way.y * perMetre_n(), 0];
    this.arrow.visible = length > 0;
    if (length > 0) {
      const head = Math.min(0.3, 0.4 * length);
      this.arrow.setDirection(way.normalize());
      this.arrow.setLength(length, head, 0.6 * head);
    }
    this.viewer.invalidate();
    return length * perMetre_n();
  }

  end(): void {
    this.arrow.removeFromParent();
    this.arrow.dispose();
    this.viewer.invalidate();
  }
}
