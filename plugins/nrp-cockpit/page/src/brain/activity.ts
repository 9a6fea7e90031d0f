import type { Spans } from "../plots/spans";
import type { TimeRing } from "../plots/timeRing";
import type { Grouping } from "../state/grouping";

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
  for (let neuron = 0; neuron < size; neuron++)
    if (light[neuron] !== 0) light[neuron] = 1 - Math.exp(-(light[neuron] as number) / HALF); // most are dark
  return light;
}

/** The mean brightness of the cells of each box of a population. */
export function boxBrightness(spikes: TimeRing, { partOf, sizes }: Grouping, now_s: number): Float64Array {
  const light = brightnessOf(spikes, partOf.length, now_s);
  const means = new Float64Array(sizes.length);
  for (let neuron = 0; neuron < light.length; neuron++) {
    const part = partOf[neuron] as number;
    if (light[neuron] !== 0) means[part] = (means[part] as number) + (light[neuron] as number);
  }
  return means.map((sum, part) => sum / (sizes[part] ?? 1));
}

const RATE_OVER_S = 1;

/** At the begin of a run, the few spikes until then are related to this time. */
const RATE_AT_LEAST_S = 0.2;

/** The begin of the last second, or of the run if that is later, and how long of it was heard; null: too little, as before the first step. */
function heardLately(heard: Spans, now_s: number): { from_s: number; over_s: number } | null {
  const from_s = Math.max(0, now_s - RATE_OVER_S);
  const heard_s = heard.within(from_s, now_s).reduce((sum, [begin_s, end_s]) => sum + end_s - begin_s, 0);
  if (now_s <= 0 || !heard.has(now_s) || heard_s < Math.min(now_s, RATE_AT_LEAST_S) - 1e-9) return null;
  return { from_s, over_s: Math.max(heard_s, RATE_AT_LEAST_S) };
}

/**
 * How often each neuron fired in the last second, or since the begin of the run if that is less; null where too
 * little of that time was heard.
 */
export function ratesNow(spikes: TimeRing, heard: Spans, size: number, now_s: number): Float64Array | null {
  return boxRates(spikes, heard, { sizes: new Array(size).fill(1) }, now_s);
}

/** How often a cell of each box fired on average; without a grouping of cells each is a box of its own. */
export function boxRates(
  spikes: TimeRing,
  heard: Spans,
  { partOf, sizes }: Pick<Grouping, "sizes"> & Partial<Grouping>,
  now_s: number,
): Float64Array | null {
  const lately = heardLately(heard, now_s);
  if (!lately) return null;
  const counts = new Float64Array(sizes.length);
  spikes.visit(lately.from_s, now_s + 1e-9, (_, neuron) => {
    const part = partOf ? (partOf[neuron] ?? 0) : neuron;
    counts[part] = (counts[part] ?? 0) + 1;
  });
  return counts.map((count, part) => count / lately.over_s / (sizes[part] ?? 1));
}

type Ranges = readonly (readonly [from: number, to: number])[];

/** The number of cells in ranges of a population. */
export const cellsIn = (ranges: Ranges): number => ranges.reduce((sum, [from, to]) => sum + to - from, 0);

/** How often a cell in ranges of a population fired on average. */
export function rangesRate(spikes: TimeRing, heard: Spans, ranges: Ranges, now_s: number): number | null {
  const lately = heardLately(heard, now_s);
  if (!lately) return null;
  let count = 0;
  spikes.visit(lately.from_s, now_s + 1e-9, (_, neuron) => {
    if (ranges.some(([from, to]) => neuron >= from && neuron < to)) count++;
  });
  return count / lately.over_s / cellsIn(ranges);
}

const numberText = (rate_hz: number) =>
  rate_hz < 10 ? rate_hz.toFixed(rate_hz === 0 ? 0 : 1) : String(Math.round(rate_hz));

/** A rate in the graph of a brain. */
export const rateText = (rate_hz: number | null): string =>
  `${rate_hz === null ? "–" : numberText(rate_hz)} Hz`;
