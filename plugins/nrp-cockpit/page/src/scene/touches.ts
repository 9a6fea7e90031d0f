import {
  BufferAttribute,
  BufferGeometry,
  type Color,
  DynamicDrawUsage,
  Group,
  LineBasicMaterial,
  LineSegments,
  Points,
  PointsMaterial,
} from "three";
import type { Xyz } from "../world/messages";
import { scale } from "../world/scale";

/** gazebo_msgs/ContactsState, as far as it is drawn; all in the world. */
export interface Contacts {
  states: { contact_positions: Xyz[]; contact_normals: Xyz[] }[];
}

/** The topic of all contacts of a world that has them. */
export const CONTACTS = "/gazebo/contact_point_data";

const MOST = 512;
const NORMAL_M = 0.15;
const POINT_PX = 7;

/** Writes for each contact its point and the end of its normal, up to what `lines` holds; returns how many. */
export function writeTouches({ states }: Contacts, lines: Float32Array, unit = 1): number {
  const length_m = unit * NORMAL_M;
  let at = 0;
  for (const { contact_positions, contact_normals } of states)
    contact_positions.forEach(({ x, y, z }, nth) => {
      const normal = contact_normals[nth];
      if (!normal || at + 6 > lines.length) return;
      lines.set([x, y, z, x + length_m * normal.x, y + length_m * normal.y, z + length_m * normal.z], at);
      at += 6;
    });
  return at / 6;
}

/** Where bodies touch: a point at each contact, and a line along its normal. They are seen through bodies. */
export class Touches {
  readonly root = new Group();
  private readonly geometry = new BufferGeometry();
  private readonly ends = new BufferGeometry();
  private readonly line = new LineBasicMaterial({ depthTest: false, transparent: true });
  private readonly point = new PointsMaterial({
    size: POINT_PX,
    sizeAttenuation: false,
    depthTest: false,
    transparent: true,
  });

  constructor() {
    const corners = new BufferAttribute(new Float32Array(6 * MOST), 3).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute("position", corners).setDrawRange(0, 0);
    this.ends.setAttribute("position", corners).setIndex(Array.from({ length: MOST }, (_, at) => 2 * at));
    this.ends.setDrawRange(0, 0);
    for (const shown of [new LineSegments(this.geometry, this.line), new Points(this.ends, this.point)]) {
      shown.frustumCulled = false;
      shown.renderOrder = 1;
      this.root.add(shown);
    }
  }

  show(contacts: Contacts): void {
    const corners = this.geometry.getAttribute("position") as BufferAttribute;
    const count = writeTouches(contacts, corners.array as Float32Array, scale.unit);
    corners.needsUpdate = true;
    this.geometry.setDrawRange(0, 2 * count);
    this.ends.setDrawRange(0, count);
  }

  style(color: Color): void {
    this.line.color.copy(color);
    this.point.color.copy(color);
  }

  dispose(): void {
    for (const one of [this.geometry, this.ends, this.line, this.point]) one.dispose();
  }
}
