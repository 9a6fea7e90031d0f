import { BoxGeometry, BufferAttribute, BufferGeometry, CylinderGeometry, SphereGeometry } from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import type { Shape } from "../world/entities";
import { GLB_TYPE, texturedMesh } from "../world/glb";
import { contentOf } from "./content";

type SimpleKind = Exclude<Shape["kind"], "mesh">;

const SIMPLE: Record<SimpleKind, () => BufferGeometry> = {
  cube: () => new BoxGeometry(1, 1, 1),
  sphere: () => new SphereGeometry(0.5, 24, 12),
  cylinder: () => new CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2),
};

interface Parsed {
  geometry: BufferGeometry;
  users: number;
}

/** The geometries of the scene: one for each simple kind, scaled by its meshes, and one for each mesh file. */
export class Geometries {
  private readonly simple = new Map<SimpleKind, BufferGeometry>();
  private readonly parsed = new Map<string, Parsed>();
  private readonly loader = new STLLoader();

  /** The geometry of a shape; give it back when the shape goes. */
  take(shape: Shape): BufferGeometry {
    if (shape.kind !== "mesh") return this.simpleOf(shape.kind);
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
    for (const geometry of this.simple.values()) geometry.dispose();
    this.simple.clear();
    for (const { geometry } of this.parsed.values()) geometry.dispose();
    this.parsed.clear();
  }

  private simpleOf(kind: SimpleKind): BufferGeometry {
    const known = this.simple.get(kind) ?? SIMPLE[kind]();
    this.simple.set(kind, known);
    return known;
  }

  /** The platform writes every mesh as STL, or as glTF with an image; any other file is left out of the scene. */
  private parse({ mesh }: Shape): BufferGeometry {
    if (mesh?.type === GLB_TYPE) return textured(mesh.data);
    if (mesh?.type !== "model/stl") return new BufferGeometry();
    const geometry = this.loader.parse(mesh.data.slice().buffer);
    geometry.computeVertexNormals(); // files may leave their normals 0
    return geometry;
  }
}

function textured(data: Uint8Array): BufferGeometry {
  const geometry = new BufferGeometry();
  const mesh = texturedMesh(data);
  if (!mesh) return geometry;
  geometry.setAttribute("position", new BufferAttribute(mesh.positions, 3));
  geometry.setAttribute("uv", new BufferAttribute(mesh.coordinates, 2));
  geometry.computeVertexNormals();
  return geometry;
}

/** Names the file of a mesh, so that a body that only changes colour is not parsed again. */
const keyOf = ({ mesh }: Shape): string => (mesh ? contentOf(mesh.data) : "");
