import { niceStep } from "./timeAxis";
import type { TimeRing } from "./timeRing";

/** Spikes per second and neuron, in bins of equal width that stand still while the window moves over them. */
export interface Histogram {
  /** The number of the first bin; it begins at `first * bin_s`. */
  first: number;
  bin_s: number;
  rates_hz: Float64Array;
}

/** The bins for a window of this length: round, about a hundred of them, and none below a millisecond. */
export const binFor = (length_s: number): number => niceStep(Math.max(length_s / 120, 1e-3));

/** Counts the spikes between two times; a bin at either end is counted whole. */
export function histogramOf(
  spikes: TimeRing,
  cells: number,
  from_s: number,
  to_s: number,
  bin_s: number,
): Histogram {
  const first = Math.floor(from_s / bin_s);
  const rates_hz = new Float64Array(Math.max(1, Math.ceil(to_s / bin_s) - first));
  const one_hz = 1 / (bin_s * Math.max(1, cells));
  spikes.visit(first * bin_s, (first + rates_hz.length) * bin_s, (t_s) => {
    const bin = Math.min(Math.max(Math.floor(t_s / bin_s) - first, 0), rates_hz.length - 1);
    rates_hz[bin] = (rates_hz[bin] ?? 0) + one_hz;
  });
  return { first, bin_s, rates_hz };
}
