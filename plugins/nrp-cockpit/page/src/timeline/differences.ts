import type { Comparison } from "../difference/comparison";
import { differs, distanceOf, timeOf } from "../difference/words";

/** A stretch of time in which two runs are about as far apart. */
export interface Stretch {
  from_s: number;
  to_s: number;
  /** Of the largest distance so far, 0 to 1; 0: they are the same. */
  share: number;
  most_m: number;
}

const MOST_STRETCHES = 60;

/** How far the robots of two runs are apart, in stretches of equal length since they are compared. */
export function stretchesOf({ since_s, distances }: Comparison): Stretch[] {
  const to_s = distances.at(-1)?.[0] ?? since_s;
  if (to_s <= since_s) return [];
  const length_s = (to_s - since_s) / MOST_STRETCHES;
  const most = new Array<number>(MOST_STRETCHES).fill(0);
  for (const [t_s, distance_m] of distances) {
    const at = Math.min(Math.floor((t_s - since_s) / length_s), MOST_STRETCHES - 1);
    if (at >= 0) most[at] = Math.max(most[at] ?? 0, distance_m);
  }
  const largest = Math.max(...most);
  return joined(
    most.map((most_m, at) => ({
      from_s: since_s + at * length_s,
      to_s: since_s + (at + 1) * length_s,
      share: largest > 0 ? Math.ceil((most_m / largest) * 8) / 8 : 0,
      most_m,
    })),
  );
}

/** Neighbours with the same share become one. */
function joined(stretches: readonly Stretch[]): Stretch[] {
  const found: Stretch[] = [];
  for (const next of stretches) {
    const last = found.at(-1);
    if (last?.share === next.share) {
      last.to_s = next.to_s;
      last.most_m = Math.max(last.most_m, next.most_m);
    } else found.push({ ...next });
  }
  return found;
}

/** A moment at which two runs differ. */
export interface Difference {
  key: string;
  t_s: number;
  name: string;
  words: string;
}

const FIRST = { trajectory: "path", spikes: "spikes" } as const;
const FIRST_WORDS = { trajectory: "The robot's path", spikes: "The number of spikes" } as const;

/** Where two runs differ: the first step of each kind, and events that happen at different times; in order. */
export function differencesOf({ first, events, labels }: Comparison): Difference[] {
  const began = first.map(({ what, t_s }) => ({
    key: what,
    t_s,
    name: FIRST[what],
    words: `${FIRST_WORDS[what]} differs from ${t_s.toFixed(2)} s`,
  }));
  const apart = events.filter(differs).flatMap(({ name, one, other }) => {
    const t_s = Math.min(one ?? Number.POSITIVE_INFINITY, other ?? Number.POSITIVE_INFINITY);
    if (!Number.isFinite(t_s)) return [];
    const words = `Event ${name}: ${labels[0]} ${timeOf(one)}, ${labels[1]} ${timeOf(other)}`;
    return [{ key: `event ${name}`, t_s, name, words }];
  });
  return [...began, ...apart].sort((a, b) => a.t_s - b.t_s);
}

export const stretchWords = ({ from_s, to_s, most_m }: Stretch): string =>
  `${from_s.toFixed(2)} to ${to_s.toFixed(2)} s: ${most_m > 0 ? `at most ${distanceOf(most_m)} apart` : "the same"}`;
