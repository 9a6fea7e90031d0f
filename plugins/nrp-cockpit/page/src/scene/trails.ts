import {
  BufferAttribute,
  BufferGeometry,
  type Color,
  DoubleSide,
  DynamicDrawUsage,
  Group,
  Mesh,
  MeshBasicMaterial,
} from "three";
import { scale } from "../world/scale";
import { LONGEST, type Trail } from "../world/trail";
import { ribbonTriangles, writeRibbon } from "./ribbon";

/** The paths of the robots, as bands on the ground. */
export class Trails {
  readonly root = new Group();
  private readonly material = new MeshBasicMaterial({ side: DoubleSide, transparent: true, opacity: 0.85 });
  private readonly bands = new Map<string, Mesh>();

  show(trails: ReadonlyMap<string, Trail>): void {
    if (!this.root.visible) return;
    for (const [robot, trail] of trails) {
      const { geometry } = this.bandOf(robot);
      const corners = geometry.getAttribute("position") as BufferAttribute;
      const points = writeRibbon(trail, corners.array as Float32Array, scale.unit);
      corners.needsUpdate = true;
      geometry.setDrawRange(0, 6 * Math.max(0, points - 1));
    }
  }

  style(color: Color): void {
    this.material.color.copy(color);
  }

  dispose(): void {
    for (const { geometry } of this.bands.values()) geometry.dispose();
    this.material.dispose();
  }

  private bandOf(robot: string): Mesh {
    let band = this.bands.get(robot);
    if (!band) {
      const geometry = new BufferGeometry();
      const corners = new BufferAttribute(new Float32Array(6 * LONGEST), 3).setUsage(DynamicDrawUsage);
      geometry.setAttribute("position", corners);
      geometry.setIndex(new BufferAttribute(ribbonTriangles(LONGEST), 1));
      band = new Mesh(geometry, this.material);
      band.frustumCulled = false;
      this.bands.set(robot, band);
      this.root.add(band);
    }
    return band;
  }
}
