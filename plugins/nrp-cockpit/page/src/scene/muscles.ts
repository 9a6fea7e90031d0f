import {
  CylinderGeometry,
  Group,
  Mesh,
  MeshLambertMaterial,
  SphereGeometry,
  SRGBColorSpace,
  Vector3,
} from "three";
import type { LinePrimitive } from "../world/messages";

const UP = new Vector3(0, 0, 1);

/** A tube: a cylinder for each part of its line, and a ball at each point. */
interface Tube {
  material: MeshLambertMaterial;
  lines: Mesh[];
  balls: Mesh[];
}

/** The muscles as tubes along their paths, in the colours of their activations. */
export class Muscles {
  readonly root = new Group();
  private readonly cylinder = new CylinderGeometry(1, 1, 1, 12).rotateX(Math.PI / 2);
  private readonly ball = new SphereGeometry(1, 12, 8);
  private tubes: Tube[] = [];

  show(muscles: readonly LinePrimitive[]): void {
    const same = muscles.every(({ points }, at) => points.length === this.tubes[at]?.balls.length);
    if (!same || muscles.length !== this.tubes.length) this.rebuild(muscles);
    muscles.forEach((muscle, at) => {
      const tube = this.tubes[at];
      if (tube) place(tube, muscle);
    });
  }

  dispose(): void {
    this.rebuild([]);
    this.cylinder.dispose();
    this.ball.dispose();
  }

  private rebuild(muscles: readonly LinePrimitive[]): void {
    this.root.clear();
    for (const { material } of this.tubes) material.dispose();
    this.tubes = muscles.map(({ points }) => {
      const material = new MeshLambertMaterial();
      const balls = points.map(() => new Mesh(this.ball, material));
      const lines = points.slice(1).map(() => new Mesh(this.cylinder, material));
      this.root.add(...balls, ...lines);
      return { material, lines, balls };
    });
  }
}

function place({ material, lines, balls }: Tube, { points, thickness, color }: LinePrimitive): void {
  const radius = thickness / 2;
  const corners = points.map(({ x, y, z }) => new Vector3(x, y, z));
  material.color.setRGB(color.r, color.g, color.b, SRGBColorSpace);
  balls.forEach((ball, at) => {
    ball.position.copy(corners[at] as Vector3);
    ball.scale.setScalar(radius);
  });
  lines.forEach((line, at) => {
    const [start, end] = [corners[at] as Vector3, corners[at + 1] as Vector3];
    const way = end.clone().sub(start);
    line.position.copy(start).addScaledVector(way, 0.5);
    line.scale.set(radius, radius, way.length());
    line.quaternion.setFromUnitVectors(UP, way.normalize());
  });
}
