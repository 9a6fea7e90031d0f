/** The membrane potentials of some cells at a time. */
export interface Sample {
  t_s: number;
  v_mv: number[];
}

const LAST_S = 4;

/** The samples of the last seconds with one more; those of a time that was undone are gone. */
export function extended(samples: readonly Sample[], next: Sample): readonly Sample[] {
  if (samples.at(-1)?.t_s === next.t_s) return samples;
  return [...samples.filter(({ t_s }) => t_s < next.t_s && t_s > next.t_s - LAST_S), next];
}

/** The bars of a histogram in a box of width and height 1: where each begins, its width and its height. */
export function barsOf(counts: readonly number[]): { x: number; width: number; height: number }[] {
  const most = Math.max(...counts, 1);
  return counts.map((count, index) => ({
    x: index / counts.length,
    width: 1 / counts.length,
    height: count / most,
  }));
}
