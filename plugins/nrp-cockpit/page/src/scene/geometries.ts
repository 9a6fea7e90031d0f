import { BoxGeometry, BufferGeometry, CylinderGeometry, SphereGeometry } from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import type { Shape } from "../world/entities";

interface Parsed {
  geometry: BufferGeometry;
  users: number;
}

/** The geometries of the scene: one for each simple kind, scaled by its meshes, and one for each mesh file. */
export class Geometries {
  private readonly simple = {
    cube: new BoxGeometry(1, 1, 1),
    sphere: new SphereGeometry(0.5, 24, 12),
    cylinder: new CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2),
  };
  private readonly parsed = new Map<string, Parsed>();
  private readonly loader = new STLLoader();

  /** The geometry of a shape; give it back when the shape goes. */
  take(shape: Shape): BufferGeometry {
    if (shape.kind !== "mesh") return this.simple[shape.kind];
    const key = keyOf(shape);
    let entry = this.parsed.get(key);
    if (!entry) {
      entry = { geometry: this.parse(shape), users: 0 };
      this.parsed.set(key, entry);
    }
    entry.users++;
    return entry.geometry;
  }

  giveBack(shape: Shape): void {
    const key = shape.kind === "mesh" ? keyOf(shape) : "";
    const entry = this.parsed.get(key);
    if (!entry || --entry.users > 0) return;
    entry.geometry.dispose();
    this.parsed.delete(key);
  }

  dispose(): void {
    for (const geometry of Object.values(this.simple)) geometry.dispose();
    for (const { geometry } of this.parsed.values()) geometry.dispose();
    this.parsed.clear();
  }

  /** The platform writes every mesh as STL; a file that is not one is left out of the scene. */
  private parse({ mesh }: Shape): BufferGeometry {
    if (mesh?.type !== "model/stl") return new BufferGeometry();
    const geometry = this.loader.parse(mesh.data.slice().buffer);
    geometry.computeVertexNormals(); // files may leave their normals 0
    return geometry;
  }
}

const keys = new WeakMap<Uint8Array, string>();

/** Names a file by its length and a hash (FNV-1a), so that a body that only changes colour is not parsed again. */
function keyOf({ mesh }: Shape): string {
  if (!mesh) return "";
  let key = keys.get(mesh.data);
  if (key === undefined) {
    let hash = 0x811c9dc5;
    for (const byte of mesh.data) hash = Math.imul(hash ^ byte, 0x01000193);
    key = `${mesh.data.length}:${hash}`;
    keys.set(mesh.data, key);
  }
  return key;
}
