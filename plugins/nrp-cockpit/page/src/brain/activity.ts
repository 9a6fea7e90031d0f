import type { Spans } from "../plots/spans";
import type { TimeRing } from "../plots/timeRing";

const DECAY_S = 0.1;
/** After this time a spike adds less than a hundredth. */
const SEEN_S = 5 * DECAY_S;
/** So many spikes at once make a neuron shine with 63 %. */
const HALF = 3;

/** How brightly each neuron shines, from 0 to 1: every spike adds light that decays in simulated time. */
export function brightnessOf(spikes: TimeRing, size: number, now_s: number): Float64Array {
  const light = new Float64Array(size);
  spikes.visit(now_s - SEEN_S, now_s + 1e-9, (t_s, neuron) => {
    light[neuron] = (light[neuron] ?? 0) + Math.exp((t_s - now_s) / DECAY_S);
  });
  return light.map((sum) => 1 - Math.exp(-sum / HALF));
}

/** The mean brightness of a whole population. */
export const meanOf = (light: Float64Array): number =>
  light.reduce((sum, one) => sum + one, 0) / Math.max(1, light.length);

const RATE_OVER_S = 1;

/** At the begin of a run, the few spikes until then are related to this time. */
const RATE_AT_LEAST_S = 0.2;

/**
 * How often each neuron fired in the last second, or since the begin of the run if that is less; null where too
 * little of that time was heard.
 */
export function ratesNow(spikes: TimeRing, heard: Spans, size: number, now_s: number): Float64Array | null {
  const from_s = Math.max(0, now_s - RATE_OVER_S);
  const heard_s = heard.within(from_s, now_s).reduce((sum, [begin_s, end_s]) => sum + end_s - begin_s, 0);
  if (!heard.has(now_s) || heard_s < Math.min(now_s, RATE_AT_LEAST_S) - 1e-9) return null;
  const over_s = Math.max(heard_s, RATE_AT_LEAST_S);
  const counts = new Float64Array(size);
  spikes.visit(from_s, now_s + 1e-9, (_, neuron) => {
    counts[neuron] = (counts[neuron] ?? 0) + 1;
  });
  return counts.map((count) => count / over_s);
}
