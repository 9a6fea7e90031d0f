import { Group, Matrix4, Mesh, MeshBasicMaterial, Plane, Quaternion, Vector3 } from "three";
import type { Pose } from "../world/pose";
import { type Shift, shifted } from "./editing";
import type { Hit, Viewer } from "./viewer";

const RAD_PER_PX = 0.01;

/** A drag that carries a body along the ground, or turns it: its shadow shows where it would be. */
export class Carry {
  /** Where the body goes when the drag ends. */
  pose: Pose;
  private readonly plane: Plane;
  private readonly ghost = new Group();
  private readonly material: MeshBasicMaterial;

  constructor(
    private readonly viewer: Viewer,
    readonly hit: Hit,
    private readonly start: Pose,
    private readonly turns: boolean,
    private readonly from_px: number,
  ) {
    this.pose = start;
    this.plane = new Plane(new Vector3(0, 0, 1), -hit.point.z);
    this.material = new MeshBasicMaterial({
      color: viewer.color("--accent"),
      transparent: true,
      opacity: 0.5,
      depthWrite: false,
    });
    const toBody = matrixOf(start).invert();
    for (const mesh of viewer.bodies.of(hit.body)) {
      const copy = new Mesh(mesh.geometry, this.material);
      copy.matrixAutoUpdate = false;
      copy.matrix.multiplyMatrices(toBody, mesh.matrixWorld);
      this.ghost.add(copy);
    }
    this.ghost.matrixAutoUpdate = false;
    this.show();
    viewer.scene.add(this.ghost);
  }

  /** Follows the pointer. */
  move(x: number, y: number): void {
    this.pose = shifted(this.start, this.shiftTo(x, y));
    this.show();
  }

  end(): void {
    this.ghost.removeFromParent();
    this.material.dispose();
    this.viewer.invalidate();
  }

  private shiftTo(x: number, y: number): Shift {
    if (this.turns) return { x: 0, y: 0, yaw: (x - this.from_px) * RAD_PER_PX };
    const end = this.viewer.ray(x, y).ray.intersectPlane(this.plane, new Vector3());
    if (!end) return { x: 0, y: 0, yaw: 0 };
    const { point } = this.hit;
    return { x: end.x - point.x, y: end.y - point.y, yaw: 0 };
  }

  private show(): void {
    this.ghost.matrix.copy(matrixOf(this.pose));
    this.ghost.matrixWorldNeedsUpdate = true;
    this.viewer.invalidate();
  }
}

const matrixOf = ({ position, orientation }: Pose): Matrix4 =>
  new Matrix4().compose(new Vector3(...position), new Quaternion(...orientation), new Vector3(1, 1, 1));
