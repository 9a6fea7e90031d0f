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
