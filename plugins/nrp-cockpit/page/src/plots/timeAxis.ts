/** The smallest step of 1, 2 or 5 times a power of ten that is at least this. */
export function niceStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5].find((factor) => factor * power >= least * (1 - 1e-9)) ?? 10);
}

/** Round numbers between two ends, at most `most` of them, but two or more: one alone has no scale. */
export function ticksBetween(from: number, to: number, most: number): number[] {
  if (!(to > from) || most < 1) return [];
  let step = niceStep((to - from) / most);
  let [first, last] = ends(from, to, step);
  for (let finer = 0; last <= first && finer < FINER; finer++) {
    step = niceStep(step * 0.4);
    [first, last] = ends(from, to, step);
  }
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, at) => (first + at) * step);
}

/** How often a step is made finer for a second tick; twice is enough where numbers have the digits for it. */
const FINER = 4;

const ends = (from: number, to: number, step: number) =>
  [Math.ceil(from / step - 1e-9), Math.floor(to / step + 1e-9)] as const;

/** A number of an axis with the digits that its step needs. */
export function tickText(value: number, step: number): string {
  const last = Math.floor(Math.log10(step) + 1e-9);
  if (last >= -4 && Math.abs(value) < 1e6) return value.toFixed(Math.max(0, -last));
  const tick = Math.round(value / step) * step || 0;
  const first = tick === 0 ? last : Math.floor(Math.log10(Math.abs(tick)) + 1e-9);
  return tick.toExponential(Math.min(Math.max(0, first - last), 20));
}

/** What is left of a value that decays is below this share of the height of its axis. */
const NEGLIGIBLE = 1e-9;

/** A value with three significant digits, for a legend; beside an axis of some height far less than that is about 0. */
export function valueText(value: number | undefined, height = 0): string {
  if (value === undefined) return "–";
  if (value !== 0 && Math.abs(value) < NEGLIGIBLE * height) return "≈ 0";
  if (!Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(2);
  return value.toFixed(Math.max(0, Math.min(4, 2 - Math.floor(Math.log10(size || 1)))));
}

/** A stretch of simulated time, and the pixels between which it is drawn. */
export interface TimeScale {
  from_s: number;
  to_s: number;
  left: number;
  right: number;
}

export const xOf = ({ from_s, to_s, left, right }: TimeScale, t_s: number): number =>
  left + ((t_s - from_s) / (to_s - from_s)) * (right - left);

export const timeAt = ({ from_s, to_s, left, right }: TimeScale, x: number): number =>
  from_s + ((x - left) / (right - left)) * (to_s - from_s);
