import type { ModelPrimitive, Primitive, Rgba, SceneEntity, SceneUpdate } from "./messages";
import { type Pose, poseOf } from "./pose";

export type Kind = "cube" | "sphere" | "cylinder" | "mesh";

/** One shape of an entity; `size` are full lengths, those of a mesh are factors. */
export interface Shape {
  kind: Kind;
  pose: Pose;
  size: readonly [number, number, number];
  color: Rgba;
  /** The file of a mesh, and its media type. */
  mesh: { data: Uint8Array; type: string } | null;
}

/** What is seen of one visual. */
export interface Entity {
  id: string;
  /** The model that it belongs to. */
  body: string;
  /** The frame that it moves with; `world`: it stays. */
  frame: string;
  shapes: readonly Shape[];
}

export const WORLD_FRAME = "world";
const DELETE_ALL = 1;

/** The model of a visual's or link's path, `model/link/visual`. */
export const bodyOf = (path: string): string => {
  const end = path.indexOf("/");
  return end < 0 ? path : path.slice(0, end);
};

/** The entities of a scene by their ids, after all updates so far. */
export type Entities = ReadonlyMap<string, Entity>;

/** The entities after an update. Those that it does not name stay the same objects. */
export function updated(entities: Entities, { deletions, entities: added }: SceneUpdate): Entities {
  const next = new Map(deletions.some(({ type }) => type === DELETE_ALL) ? [] : entities);
  for (const { id } of deletions) next.delete(id);
  for (const entity of added) next.set(entity.id, read(entity));
  return next;
}

const read = (entity: SceneEntity): Entity => ({
  id: entity.id,
  body: bodyOf(entity.id),
  frame: entity.frame_id || WORLD_FRAME,
  shapes: [
    ...entity.cubes.map((one) => simple("cube", one)),
    ...entity.spheres.map((one) => simple("sphere", one)),
    ...entity.cylinders.map((one) => simple("cylinder", one)),
    ...entity.models.map(mesh),
  ],
});

const simple = (kind: Kind, { pose, size, color }: Primitive): Shape => ({
  kind,
  pose: poseOf(pose),
  size: [size.x, size.y, size.z],
  color,
  mesh: null,
});

const mesh = ({ pose, scale, color, data, media_type }: ModelPrimitive): Shape => ({
  kind: "mesh",
  pose: poseOf(pose),
  size: [scale.x, scale.y, scale.z],
  color,
  mesh: { data, type: media_type },
});
