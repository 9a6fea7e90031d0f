import { type TimeScale, xOf } from "./timeAxis";
import type { TimeRing } from "./timeRing";

/** The values of a series in a window: at the most four for each pixel, so a fast series costs no more than a slow one. */
export interface Curve {
  /** Places in pixels, and the values there, as a line that runs through all of them. */
  xs: number[];
  values: number[];
  lowest: number;
  highest: number;
}

/**
 * The line of a series that holds each value until the next one: what is sent at changes only is level in between.
 * The last value lasts until `now_s`. Of many values in one pixel remain the first, the lowest, the highest and the
 * last.
 */
export function curveOf(series: TimeRing, scale: TimeScale, now_s: number): Curve {
  const curve: Curve = {
    xs: [],
    values: [],
    lowest: Number.POSITIVE_INFINITY,
    highest: Number.NEGATIVE_INFINITY,
  };
  const first = Math.max(0, series.indexAt(scale.from_s) - 1);
  const end = series.indexAt(scale.to_s);
  for (let index = first; index < end; ) index = addPixel(curve, series, scale, index, end);
  const last = curve.values.at(-1);
  const until = Math.min(now_s, scale.to_s);
  if (last !== undefined && until > scale.from_s) add(curve, xOf(scale, until), last);
  return curve;
}

/** Adds the values that lie in the same pixel as the one at `index`, and returns the index behind them. */
function addPixel(curve: Curve, series: TimeRing, scale: TimeScale, index: number, end: number): number {
  const x = Math.max(scale.left, xOf(scale, series.timeAt(index)));
  const held = curve.values.at(-1);
  if (held !== undefined) add(curve, x, held);
  const value = series.valueAt(index);
  let [lowest, highest, last] = [value, value, value];
  let next = index + 1;
  while (next < end && xOf(scale, series.timeAt(next)) < x + 1) {
    last = series.valueAt(next++);
    lowest = Math.min(lowest, last);
    highest = Math.max(highest, last);
  }
  const through = next === index + 1 ? [value] : [value, lowest, highest, last];
  for (const each of through) add(curve, x, each);
  return next;
}

function add(curve: Curve, x: number, value: number): void {
  curve.xs.push(x);
  curve.values.push(value);
  if (!Number.isFinite(value)) return;
  curve.lowest = Math.min(curve.lowest, value);
  curve.highest = Math.max(curve.highest, value);
}

/** The value that holds at a time; undefined before the first. */
export function valueAt(series: TimeRing, t_s: number): number | undefined {
  const index = series.indexAt(t_s + 1e-9) - 1;
  return index < 0 ? undefined : series.valueAt(index);
}
