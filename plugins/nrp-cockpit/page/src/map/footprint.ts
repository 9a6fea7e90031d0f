import type { Vector } from "../state/types";
import type { Entity, Shape } from "../world/entities";
import { GLB_TYPE, texturedMesh } from "../world/glb";
import type { Rgba } from "../world/messages";
import { compose, type Pose, transform } from "../world/pose";
import { boxOfStl } from "./stl";

export type Point = readonly [number, number];

/** What a shape covers, seen from above. */
export interface Footprint {
  body: string;
  /** A convex polygon, counter-clockwise; m in the world. */
  outline: readonly Point[];
  bottom_m: number;
  top_m: number;
  color: Rgba;
}

/** What an entity's shapes cover, with its frame at `frame` in the world. */
export function footprintsOf(entity: Entity, frame: Pose): Footprint[] {
  return entity.shapes.flatMap((shape) => {
    const pose = compose(frame, shape.pose);
    const points = cornersOf(shape).map((corner) => transform(pose, corner));
    if (points.length === 0) return [];
    const heights = points.map(([, , z]) => z);
    return {
      body: entity.body,
      outline: convexHull(points.map(([x, y]) => [x, y])),
      bottom_m: Math.min(...heights),
      top_m: Math.max(...heights),
      color: shape.color,
    };
  });
}

/** How far something reaches along the axes of the world, m. */
export type Extent = Record<"x" | "y" | "z", readonly [number, number]>;

/** How far some entities reach together; null if they have no shapes. */
export function extentOf(entities: readonly Entity[], poseOf: (frame: string) => Pose): Extent | null {
  const all = entities.flatMap((entity) => footprintsOf(entity, poseOf(entity.frame)));
  if (all.length === 0) return null;
  const range = (values: readonly number[]) => [Math.min(...values), Math.max(...values)] as const;
  const points = all.flatMap(({ outline }) => outline);
  return {
    x: range(points.map(([x]) => x)),
    y: range(points.map(([, y]) => y)),
    z: range(all.flatMap(({ bottom_m, top_m }) => [bottom_m, top_m])),
  };
}

const signs = [-1, 1] as const;
const ROUND = 16;

/** Points of a shape in its own axes whose hull is the hull of the shape, or nearly so if it is round. */
function cornersOf({ kind, size, mesh }: Shape): Vector[] {
  if (kind === "cylinder")
    return circle().flatMap(([x, y]) => signs.map((z): Vector => scaled([x, y, z], size)));
  if (kind === "sphere") return ball().map((point) => scaled(point, size));
  if (kind === "cube") return cube().map((corner) => scaled(corner, size));
  const box = mesh && (mesh.type === GLB_TYPE ? texturedMesh(mesh.data) : cachedBox(mesh.data));
  if (!box) return [];
  return cube().map(
    ([x, y, z]): Vector => [
      (x < 0 ? box.min[0] : box.max[0]) * size[0],
      (y < 0 ? box.min[1] : box.max[1]) * size[1],
      (z < 0 ? box.min[2] : box.max[2]) * size[2],
    ],
  );
}

const scaled = ([x, y, z]: Vector, [a, b, c]: readonly [number, number, number]): Vector => [
  (x * a) / 2,
  (y * b) / 2,
  (z * c) / 2,
];

const cube = (): Vector[] => signs.flatMap((x) => signs.flatMap((y) => signs.map((z): Vector => [x, y, z])));

const circle = (radius = 1): Point[] =>
  Array.from({ length: ROUND }, (_, i) => {
    const angle = (2 * Math.PI * i) / ROUND;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });

/** Circles of latitude and the poles. */
const ball = (): Vector[] => [
  [0, 0, -1],
  ...[-0.7, 0, 0.7].flatMap((z) => circle(Math.sqrt(1 - z * z)).map(([x, y]): Vector => [x, y, z])),
  [0, 0, 1],
];

const boxes = new WeakMap<Uint8Array, ReturnType<typeof boxOfStl>>();

function cachedBox(data: Uint8Array): ReturnType<typeof boxOfStl> {
  let box = boxes.get(data);
  if (box === undefined) {
    box = boxOfStl(data);
    boxes.set(data, box);
  }
  return box;
}

/** The corners of the smallest convex polygon around points, counter-clockwise (Andrew's monotone chain). */
export function convexHull(points: readonly Point[]): Point[] {
  const sorted = [...points].sort(([ax, ay], [bx, by]) => ax - bx || ay - by);
  const half = (ordered: readonly Point[]) => {
    const chain: Point[] = [];
    for (const point of ordered) {
      while (chain.length > 1 && turn(chain.at(-2) as Point, chain.at(-1) as Point, point) <= 0) chain.pop();
      chain.push(point);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.toReversed())];
}

/** Positive where the way from a over b to c turns left. */
const turn = ([ax, ay]: Point, [bx, by]: Point, [cx, cy]: Point): number =>
  (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);

/** Whether a point lies in a convex polygon that goes counter-clockwise. */
export const contains = (outline: readonly Point[], point: Point): boolean =>
  outline.length > 2 &&
  outline.every((corner, at) => turn(corner, outline[(at + 1) % outline.length] as Point, point) >= 0);
