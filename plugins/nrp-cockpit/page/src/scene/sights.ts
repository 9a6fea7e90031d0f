import {
  BufferAttribute,
  BufferGeometry,
  type Color,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
} from "three";
import type { Mount } from "../state/types";
import { compose, type Pose } from "../world/pose";
import type { Layer } from "./choices";
import { frustumLines, type LaserScan, writeRays } from "./sightLines";

const MOST_RAYS = 2048;

/** Where the sensors look: the frustums of cameras, and the rays of laser scanners. */
export class Sights {
  readonly root = new Group();
  private readonly frustum = new LineBasicMaterial({ transparent: true, opacity: 0.9 });
  private readonly ray = new LineBasicMaterial({ transparent: true, opacity: 0.35, depthWrite: false });
  private readonly lines = new Map<Mount, LineSegments>();

  /** Shows these sensors, and no others. */
  mount(mounts: readonly Mount[]): void {
    this.clear();
    for (const mount of mounts) {
      const geometry = new BufferGeometry();
      const points = mount.view
        ? frustumLines(mount.view.fov_rad, mount.view.aspect)
        : new Float32Array(6 * MOST_RAYS);
      geometry.setAttribute("position", new BufferAttribute(points, 3).setUsage(DynamicDrawUsage));
      if (!mount.view) geometry.setDrawRange(0, 0);
      const lines = new LineSegments(geometry, mount.view ? this.frustum : this.ray);
      lines.frustumCulled = false;
      this.lines.set(mount, lines);
      this.root.add(lines);
    }
  }

  move(poseOf: (frame: string) => Pose): void {
    for (const [{ frame, position, orientation }, lines] of this.lines) {
      const pose = compose(poseOf(frame), { position, orientation });
      lines.position.set(...pose.position);
      lines.quaternion.set(...pose.orientation);
    }
  }

  scan(mount: Mount, scan: LaserScan): void {
    const geometry = this.lines.get(mount)?.geometry;
    const points = geometry?.getAttribute("position");
    if (!geometry || !points) return;
    geometry.setDrawRange(0, writeRays(scan, points.array as Float32Array));
    points.needsUpdate = true;
  }

  show(layers: ReadonlySet<Layer>): void {
    for (const [{ view }, lines] of this.lines) lines.visible = layers.has(view ? "frustum" : "rays");
  }

  style(frustum: Color, ray: Color): void {
    this.frustum.color.copy(frustum);
    this.ray.color.copy(ray);
  }

  dispose(): void {
    this.clear();
    this.frustum.dispose();
    this.ray.dispose();
  }

  private clear(): void {
    for (const lines of this.lines.values()) {
      lines.removeFromParent();
      lines.geometry.dispose();
    }
    this.lines.clear();
  }
}
