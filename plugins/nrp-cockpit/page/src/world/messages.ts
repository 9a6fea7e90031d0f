/** The messages of the run that say what the world looks like, as wire/decode.ts gives them. */

export interface Xyz {
  x: number;
  y: number;
  z: number;
}

export interface Xyzw extends Xyz {
  w: number;
}

export interface PoseMessage {
  position: Xyz;
  orientation: Xyzw;
}

export interface Rgba {
  r: number;
  g: number;
  b: number;
  a: number;
}

/** A box, an ellipsoid, or a cylinder along z; `size` are its full lengths along its axes. */
export interface Primitive {
  pose: PoseMessage;
  size: Xyz;
  color: Rgba;
}

/** A mesh with its file. */
export interface ModelPrimitive {
  pose: PoseMessage;
  scale: Xyz;
  color: Rgba;
  media_type: string;
  data: Uint8Array;
}

/** foxglove_msgs/SceneEntity: the shapes of one visual, `model/link/visual`, in the frame that it moves with. */
export interface SceneEntity {
  id: string;
  frame_id: string;
  cubes: Primitive[];
  spheres: Primitive[];
  cylinders: Primitive[];
  models: ModelPrimitive[];
}

/** foxglove_msgs/SceneUpdate: removals, then additions. A removal of type 1 removes everything. */
export interface SceneUpdate {
  deletions: { type: number; id: string }[];
  entities: SceneEntity[];
}

/** A line through points; `thickness` is its diameter. */
export interface LinePrimitive {
  points: Xyz[];
  thickness: number;
  color: Rgba;
}

/** The muscles, as lines in the world: a foxglove_msgs/SceneUpdate of which the last message counts. */
export interface MusclePaths {
  entities: { lines: LinePrimitive[] }[];
}

/** tf2_msgs/TFMessage. */
export interface Transforms {
  transforms: {
    header: { frame_id: string };
    child_frame_id: string;
    transform: { translation: Xyz; rotation: Xyzw };
  }[];
}

/** gazebo_msgs/ModelStates. */
export interface ModelStates {
  name: string[];
  pose: PoseMessage[];
}
