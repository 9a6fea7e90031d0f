import {
  Box3,
  BoxGeometry,
  Group,
  type Material,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  Vector3,
} from "three";
import type { Entities, Entity, Shape } from "../world/entities";
import { WORLD_FRAME } from "../world/entities";
import type { Pose } from "../world/pose";
import { Geometries } from "./geometries";
import { Materials } from "./materials";

/** The mesh of one shape, and what it is a part of. */
export class ShapeMesh extends Mesh {
  constructor(
    readonly entity: Entity,
    readonly shape: Shape,
    geometries: Geometries,
    materials: Materials,
  ) {
    super(geometries.take(shape), materials.of(shape));
    place(this, shape.pose);
    this.scale.set(...shape.size);
    this.updateMatrix();
    this.matrixAutoUpdate = false;
    this.castShadow = this.receiveShadow = shape.color.a >= 1;
  }
}

/** Shapes wider than this (m) stand for endless ground; they do not count for the size of a room. */
const ENDLESS_M = 50;
/** What is lower than this part of its width is ground. */
const FLAT = 0.05;

/** The entities of the world as meshes: a group for each frame, which moves, with the meshes of its entities. */
export class Bodies {
  readonly root = new Group();
  /** A body as most are, to compile what draws them before the first is there. */
  readonly typical = new Mesh(new BoxGeometry(), new MeshLambertMaterial());
  private readonly groups = new Map<string, Group>();
  private readonly meshes = new Map<string, ShapeMesh[]>();
  private readonly geometries = new Geometries();
  private readonly materials: Materials;

  /** `onImage` is called when an image on a body can be seen. */
  constructor(onImage?: () => void) {
    this.materials = new Materials(onImage);
    this.typical.castShadow = this.typical.receiveShadow = true;
  }

  /** Shows these entities; those that are the same objects as before stay as they are. */
  show(entities: Entities): void {
    for (const [id, meshes] of this.meshes)
      if (meshes[0]?.entity !== entities.get(id) || meshes.length === 0) this.remove(id, meshes);
    for (const entity of entities.values()) if (!this.meshes.has(entity.id)) this.add(entity);
    this.materials.keepOnly(new Set([...this.all()].map(({ material }) => material as Material)));
  }

  /** Sets the poses of moving bodies; `awaited` ones are hidden, because their pieces would all lie at the origin. */
  move(poseOf: (frame: string) => Pose, awaited = false): void {
    for (const [frame, group] of this.groups) {
      if (frame === WORLD_FRAME) continue;
      group.visible = !awaited;
      place(group, poseOf(frame));
      group.updateMatrix();
      group.matrixWorldNeedsUpdate = true;
    }
  }

  *all(): Generator<ShapeMesh> {
    for (const meshes of this.meshes.values()) yield* meshes;
  }

  *of(body: string): Generator<ShapeMesh> {
    for (const mesh of this.all()) if (mesh.entity.body === body) yield mesh;
  }

  /** The box around some meshes, in the world; empty if there are none. */
  boxOf(meshes: Iterable<Object3D>): Box3 {
    const box = new Box3();
    for (const mesh of meshes) box.expandByObject(mesh);
    return box;
  }

  /** The box around all but endless ground. */
  room(): Box3 {
    const limited = [...this.all()].filter((mesh) => {
      const size = this.boxOf([mesh]).getSize(new Vector3());
      return Math.max(size.x, size.y) < ENDLESS_M;
    });
    return this.boxOf(limited);
  }

  /** The box around all but the ground, if there is anything else. */
  standing(): Box3 {
    const things = [...this.all()].filter((mesh) => {
      const { x, y, z } = this.boxOf([mesh]).getSize(new Vector3());
      return Math.max(x, y) < ENDLESS_M && z > FLAT * Math.max(x, y);
    });
    return things.length > 0 ? this.boxOf(things) : this.room();
  }

  dispose(): void {
    this.geometries.dispose();
    this.materials.dispose();
    this.typical.geometry.dispose();
    this.typical.material.dispose();
  }

  private add(entity: Entity): void {
    const group = this.groupOf(entity.frame);
    const meshes = entity.shapes.map(
      (shape) => new ShapeMesh(entity, shape, this.geometries, this.materials),
    );
    for (const mesh of meshes) group.add(mesh);
    this.meshes.set(entity.id, meshes);
  }

  private remove(id: string, meshes: ShapeMesh[]): void {
    for (const mesh of meshes) {
      mesh.removeFromParent();
      this.geometries.giveBack(mesh.shape);
    }
    this.meshes.delete(id);
  }

  private groupOf(frame: string): Group {
    let group = this.groups.get(frame);
    if (!group) {
      group = new Group();
      group.matrixAutoUpdate = false;
      this.groups.set(frame, group);
      this.root.add(group);
    }
    return group;
  }
}

function place(object: Object3D, { position, orientation }: Pose): void {
  object.position.set(...position);
  object.quaternion.set(...orientation);
}
