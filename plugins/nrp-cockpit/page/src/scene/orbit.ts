import type { Vector } from "../state/types";

/** From where the scene is seen: around a target, z up; angles in rad, the azimuth from x towards y. */
export interface Orbit {
  target: Readonly<Vector>;
  azimuth: number;
  elevation: number;
  distance_m: number;
}

/** The vertical field of view of the camera. */
export const FOV_RAD = (40 * Math.PI) / 180;
/** Straight down would leave the direction of "up" undefined. */
export const STEEPEST = Math.PI / 2 - 1e-4;
const LOWEST = -0.2;
const NEAREST_M = 0.002;
const FARTHEST_M = 500;

export const START: Orbit = { target: [0, 0, 0], azimuth: -2.2, elevation: 0.6, distance_m: 10 };

const clamp = (value: number, low: number, high: number) => Math.min(Math.max(value, low), high);

/** The direction from the target to the eye. */
export function outward({ azimuth, elevation }: Orbit): Vector {
  const flat = Math.cos(elevation);
  return [flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation)];
}

/** The axes of the image in the world: to its right and to its top. */
export function imageAxes({ azimuth, elevation }: Orbit): { right: Vector; up: Vector } {
  const steep = Math.sin(elevation);
  return {
    right: [-Math.sin(azimuth), Math.cos(azimuth), 0],
    up: [-steep * Math.cos(azimuth), -steep * Math.sin(azimuth), Math.cos(elevation)],
  };
}

/** The distance in front of which nothing is drawn, for a view of a room as for one of an insect. */
export const nearOf = ({ distance_m }: Orbit): number => Math.min(0.05, distance_m / 200);

export function eyeOf(view: Orbit): Vector {
  const [x, y, z] = outward(view);
  const [tx, ty, tz] = view.target;
  return [tx + view.distance_m * x, ty + view.distance_m * y, tz + view.distance_m * z];
}

export const orbited = (view: Orbit, azimuth: number, elevation: number): Orbit => ({
  ...view,
  azimuth: view.azimuth + azimuth,
  elevation: clamp(view.elevation + elevation, LOWEST, STEEPEST),
});

/** The view moved sideways by parts of the height of the image. */
export function panned(view: Orbit, toRight: number, toTop: number): Orbit {
  const { right, up } = imageAxes(view);
  const height_m = 2 * view.distance_m * Math.tan(FOV_RAD / 2);
  const moved = (axis: 0 | 1 | 2) =>
    view.target[axis] + height_m * (toRight * right[axis] + toTop * up[axis]);
  return { ...view, target: [moved(0), moved(1), moved(2)] };
}

/** The view at `factor` times the distance; the point `at` stays where it is in the image. */
export function zoomed(view: Orbit, factor: number, at: Readonly<Vector> = view.target): Orbit {
  const distance_m = clamp(view.distance_m * factor, NEAREST_M, FARTHEST_M);
  const real = distance_m / view.distance_m;
  const nearer = (axis: 0 | 1 | 2) => at[axis] + (view.target[axis] - at[axis]) * real;
  return { ...view, distance_m, target: [nearer(0), nearer(1), nearer(2)] };
}

/** The view from the same direction of all of a ball; `aspect` is the image's width over its height. */
export function fitted(view: Orbit, centre: Readonly<Vector>, radius_m: number, aspect: number): Orbit {
  const half = Math.atan(Math.tan(FOV_RAD / 2) * Math.min(1, aspect));
  const distance_m = clamp(radius_m / Math.sin(half), NEAREST_M, FARTHEST_M);
  return { ...view, target: centre, distance_m };
}

/** The least and the largest initial distance of the camera, in sizes of the robot. */
const BEGIN_SIZES = [5, 10] as const;

/** The initial distance of the camera from a robot: as close as shows everything around it, within limits. */
export const beginsAt = (size_m: number, all_m: number): number =>
  clamp(all_m, BEGIN_SIZES[0] * size_m, BEGIN_SIZES[1] * size_m);

/** North is up, as on a map. */
export const fromAbove = (view: Orbit): Orbit => ({ ...view, azimuth: -Math.PI / 2, elevation: STEEPEST });

/** Where the ends of the world's axes x, y and z are in the image, to the right and to the top. */
export function axesInImage(view: Orbit): readonly (readonly [number, number])[] {
  const { right, up } = imageAxes(view);
  return [
    [right[0], up[0]],
    [right[1], up[1]],
    [right[2], up[2]],
  ];
}
