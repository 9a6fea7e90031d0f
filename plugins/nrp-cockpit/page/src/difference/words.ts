import type { Comparison, Pair } from "./comparison";

const KINDS = { trajectory: "The robot's path", spikes: "The number of spikes" } as const;

/** One sentence: whether the runs differ, in what first, and how far the robots are apart. */
export function verdictOf({ first, distance_m, since_s }: Comparison): string {
  const [earliest] = first;
  if (!earliest)
    return `Identical since ${since_s.toFixed(2)} s, to the last bit of each position and spike count.`;
  const began = `${KINDS[earliest.what]} differs first, at ${earliest.t_s.toFixed(2)} s.`;
  return `${began} The robots are ${distanceOf(distance_m)} apart.`;
}

/** A distance with a unit that keeps it readable. */
export function distanceOf(distance_m: number): string {
  if (distance_m === 0) return "0 m";
  if (distance_m < 1e-6) return `${(distance_m * 1e9).toPrecision(2)} nm`;
  if (distance_m < 1e-3) return `${(distance_m * 1e6).toPrecision(3)} µm`;
  return distance_m < 1 ? `${(distance_m * 1e3).toPrecision(3)} mm` : `${distance_m.toFixed(2)} m`;
}

export const timeOf = (t_s: number | null): string => (t_s === null ? "not yet" : `${t_s.toFixed(2)} s`);

export const passedOf = (passed: boolean | null): string =>
  passed === null ? "undecided" : passed ? "passed" : "failed";

/** Whether a row is worth a second look. */
export const differs = <T>({ one, other }: Pair<T>): boolean => one !== other;
