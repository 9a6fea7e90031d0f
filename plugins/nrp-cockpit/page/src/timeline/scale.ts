import type { TimelineData } from "../state/types";

/** A stretch of simulated time. */
export interface Span {
  from_s: number;
  to_s: number;
}

/** The smallest number of the series 1, 2, 5, 10, 20, ... that is at least `value`. */
export function niceAbove(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const step = [1, 2, 5, 10].find((one) => one * power >= value * (1 - 1e-9)) ?? 10;
  return step * power;
}

/** All that can be shown: the run's duration, or, of an open end, somewhat more than what is known. */
export function wholeSpan(data: TimelineData, t_s: number): Span {
  if (data.duration_s !== null) return { from_s: 0, to_s: Math.max(data.duration_s, t_s) };
  const known = [
    t_s,
    ...data.events.map((event) => event.t_s ?? 0),
    ...data.snapshots.map((snapshot) => snapshot.t_s),
    ...data.failures.map((failure) => failure.t_s),
  ];
  return { from_s: 0, to_s: niceAbove(Math.max(1, ...known) * 1.1) };
}

const length = ({ from_s, to_s }: Span) => to_s - from_s;

/** The span of the same length nearest to the given one that lies inside the whole. */
function inside(span: Span, whole: Span): Span {
  const room = Math.min(length(span), length(whole));
  const from_s = Math.min(Math.max(span.from_s, whole.from_s), whole.to_s - room);
  return { from_s, to_s: from_s + room };
}

const SHORTEST_S = 0.5;

/** The span `factor` times as long, in which `at_s` keeps its place. */
export function zoomed(span: Span, whole: Span, factor: number, at_s: number): Span {
  const wanted = Math.min(Math.max(length(span) * factor, SHORTEST_S), length(whole));
  const from_s = at_s - ((at_s - span.from_s) / length(span)) * wanted;
  return inside({ from_s, to_s: from_s + wanted }, whole);
}

/** The span moved so that it shows `t_s`; one that shows it stays. */
export function showing(span: Span, whole: Span, t_s: number): Span {
  if (t_s >= span.from_s && t_s <= span.to_s) return inside(span, whole);
  const from_s = t_s - length(span) / 4;
  return inside({ from_s, to_s: from_s + length(span) }, whole);
}

/** How far along the span a time is, in percent. */
export const percent = (span: Span, t_s: number): number => ((t_s - span.from_s) / length(span)) * 100;

/** The time at a share (0 to 1) of the span. */
export const timeAt = (span: Span, share: number): number =>
  span.from_s + Math.min(Math.max(share, 0), 1) * length(span);

/** Round times for the ruler, at most `most` of them. */
export function ticks(span: Span, most: number): number[] {
  const step = niceAbove(length(span) / Math.max(most, 1));
  const first = Math.ceil(span.from_s / step - 1e-9);
  const last = Math.floor(span.to_s / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, at) => Number(((first + at) * step).toPrecision(12)));
}
