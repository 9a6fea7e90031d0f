import { useRun } from "../state/run";
import { onPast, wire } from "../wire";
import { type Entities, updated, WORLD_FRAME } from "./entities";
import type { LinePrimitive, ModelStates, MusclePaths, SceneUpdate, Transforms } from "./messages";
import { IDENTITY, type Pose, poseFrom, poseOf } from "./pose";
import { extend, newTrail, type Trail } from "./trail";

/** What changed: the shapes of the scene, or only where things are. */
export type Change = "scene" | "poses";
const MODEL_STATES = "/gazebo/model_states";
const TRANSFORMS = "/tf";

type Listener = (change: Change) => void;

/**
 * What the run last said about its world: read once for all panels that draw it, and kept outside React because it
 * changes 25 times a second. It subscribes to its topics while at least one panel follows it.
 */
class World {
  entities: Entities = new Map();
  /** The poses of the moving frames in the world. */
  readonly frames = new Map<string, Pose>();
  /** The poses of the models in the world. */
  readonly models = new Map<string, Pose>();
  /** The muscles at their places, in the colours of their activations. */
  muscles: readonly LinePrimitive[] = [];
  /** The paths of the robots. */
  readonly trails = new Map<string, Trail>();

  private readonly listeners = new Set<Listener>();
  private stops: (() => void)[] = [];
  /** True until the whole scene comes that a new subscription begins with. */
  private stale = true;

  follow(listener: Listener): () => void {
    this.listeners.add(listener);
    if (this.listeners.size === 1) this.start();
    return () => {
      this.listeners.delete(listener);
      if (this.listeners.size > 0) return;
      for (const stop of this.stops) stop();
    };
  }

  /** Whether the poses of moving bodies are not known yet, but will be: a recording may have no transforms. */
  get awaited(): boolean {
    return this.frames.size === 0 && wire.offered().some(({ topic }) => topic === TRANSFORMS);
  }

  /** The pose of a frame in the world; one that never moved is at the origin. */
  frame(name: string): Pose {
    return name === WORLD_FRAME ? IDENTITY : (this.frames.get(name) ?? IDENTITY);
  }

  /** Whether the pose of a frame is known. */
  knows(name: string): boolean {
    return name === WORLD_FRAME || this.frames.has(name);
  }

  private start(): void {
    this.stale = true;
    this.stops = [
      wire.onLink(({ state }) => {
        this.stale ||= state !== "open";
      }),
      wire.subscribe<SceneUpdate>("/scene", (update) => this.readScene(update)),
      wire.subscribe<Transforms>(TRANSFORMS, (message) => this.readFrames(message), "latest"),
      wire.subscribe<MusclePaths>("/scene/muscles", (message) => this.readMuscles(message), "latest"),
      wire.subscribe<ModelStates>(MODEL_STATES, (message, t_s) => this.readModels(message, t_s)),
      onPast(({ topic, new: isNew }) => topic === MODEL_STATES && isNew && this.trails.clear()),
    ];
  }

  private readScene(update: SceneUpdate): void {
    this.entities = updated(this.stale ? new Map() : this.entities, update);
    this.stale = false;
    this.tell("scene");
  }

  private readFrames({ transforms }: Transforms): void {
    for (const { child_frame_id, transform } of transforms)
      this.frames.set(child_frame_id, poseFrom(transform.translation, transform.rotation));
    this.tell("poses");
  }

  private readMuscles({ entities }: MusclePaths): void {
    this.muscles = entities.flatMap(({ lines }) => lines);
    this.tell("poses");
  }

  private readModels({ name, pose }: ModelStates, t_s: number): void {
    this.models.clear();
    name.forEach((one, at) => {
      const message = pose[at];
      if (message) this.models.set(one, poseOf(message));
    });
    for (const robot of useRun.getState().experiment?.robots ?? []) this.lengthen(robot, t_s);
    this.tell("poses");
  }

  private lengthen(robot: string, t_s: number): void {
    const pose = this.models.get(robot);
    if (!pose) return;
    const trail = this.trails.get(robot) ?? newTrail();
    this.trails.set(robot, trail);
    extend(trail, t_s, pose.position);
  }

  private tell(change: Change): void {
    for (const listener of [...this.listeners]) listener(change);
  }
}

export const world = new World();
