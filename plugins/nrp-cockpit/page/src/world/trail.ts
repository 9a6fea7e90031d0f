/** The path of one body from above, oldest first. */
export interface Trail {
  x: number[];
  y: number[];
  z: number[];
  t_s: number[];
}

/** A point nearer than this (m) to the last one is left out. */
const NEAREST_M = 0.0002;
/** A longer trail loses every second point. */
export const LONGEST = 4000;

export const newTrail = (): Trail => ({ x: [], y: [], z: [], t_s: [] });

/** Adds a place to a trail. Points that lie in the future, after a reset or a step back, are removed first. */
export function extend(trail: Trail, t_s: number, [x, y, z]: readonly [number, number, number]): void {
  let length = trail.t_s.length;
  while (length > 0 && (trail.t_s[length - 1] ?? 0) > t_s) length--;
  cut(trail, length);
  const last = length - 1;
  const way = Math.hypot(x - (trail.x[last] ?? Infinity), y - (trail.y[last] ?? Infinity));
  if (way < NEAREST_M) return;
  trail.x.push(x);
  trail.y.push(y);
  trail.z.push(z);
  trail.t_s.push(t_s);
  if (trail.t_s.length >= LONGEST) thin(trail);
}

function cut(trail: Trail, length: number): void {
  if (trail.t_s.length === length) return;
  for (const values of [trail.x, trail.y, trail.z, trail.t_s]) values.length = length;
}

/** Leaves out every second point of a trail that became too long. */
function thin(trail: Trail): void {
  const half = (values: number[]) => values.filter((_, at) => at % 2 === 0);
  trail.x = half(trail.x);
  trail.y = half(trail.y);
  trail.z = half(trail.z);
  trail.t_s = half(trail.t_s);
}
