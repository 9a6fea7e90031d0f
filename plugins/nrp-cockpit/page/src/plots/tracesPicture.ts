import { useRun } from "../state/run";
import { clock } from "./clock";
import { type Curve, curveOf } from "./curve";
import type { Shown } from "./groups";
import { type TimeScale, ticksBetween, tickText, xOf } from "./timeAxis";
import { heardOf, leftOf, valuesOf } from "./traceStore";
import type { Sheet } from "./useCanvas";

/** Room above the curves. */
export const TOP = 4;

/** The extent of the values with a little room; a level line lies in the middle. */
function extentOf(curves: readonly Curve[], limits: readonly number[]): [number, number] {
  const lowest = Math.min(...curves.map((curve) => curve.lowest), ...limits);
  const highest = Math.max(...curves.map((curve) => curve.highest), ...limits);
  if (!Number.isFinite(lowest)) return [0, 1];
  const room = (highest - lowest) * 0.06 || Math.abs(highest) * 0.5 || 1;
  return [lowest - room, highest + room];
}

/** Draws curves on one axis, over those of the abandoned future, over the lines and numbers of their values; returns the height of the axis in values. */
export function paintCurves(sheet: Sheet, scale: TimeScale, shown: readonly Shown[], bottom: number): number {
  const { pen, colours } = sheet;
  const curves = shown.map(({ trace }) => curveOf(valuesOf(trace), scale, clock.now_s));
  const left = shown
    .flatMap(({ trace }) => leftOf(trace) ?? [])
    .filter((ring) => ring.lastTime > scale.from_s)
    .map((ring) => curveOf(ring, scale, ring.lastTime));
  const limits = limitsOf(shown);
  const [low, high] = extentOf([...curves, ...left], limits);
  const yOf = (value: number) => bottom - ((value - low) / (high - low)) * (bottom - TOP);
  paintValues(sheet, scale, [low, high], yOf, bottom);
  paintLimits(sheet, scale, limits.map(yOf));
  pen.strokeStyle = colours.text3;
  for (const curve of left) strokeCurve(sheet, curve, yOf);
  shown.forEach(({ trace, colour }, at) => {
    const curve = curves[at];
    if (!curve) return;
    pen.save();
    clipTo(sheet, scale, heardOf(trace).within(scale.from_s, scale.to_s), bottom);
    pen.strokeStyle = colours.curves[colour] ?? colours.text;
    strokeCurve(sheet, curve, yOf);
    pen.restore();
  });
  return high - low;
}

/** The limits that criteria set to what is shown. */
function limitsOf(shown: readonly Shown[]): number[] {
  const criteria = useRun.getState().timeline?.criteria ?? [];
  return criteria.flatMap(({ curve }) => {
    const isShown = shown.some(({ trace }) => trace.topic === curve?.topic && trace.path === curve.path);
    return isShown ? (curve?.limits ?? []) : [];
  });
}

/** A dashed line at the height of each limit. */
function paintLimits({ pen, colours }: Sheet, { left, right }: TimeScale, heights: readonly number[]): void {
  pen.strokeStyle = colours.text;
  pen.lineWidth = 1;
  pen.setLineDash([6, 3]);
  for (const y of heights) {
    pen.beginPath();
    pen.moveTo(left, Math.round(y) + 0.5);
    pen.lineTo(right, Math.round(y) + 0.5);
    pen.stroke();
  }
  pen.setLineDash([]);
}

/** Lets nothing be drawn where the page did not listen: what a value was there is not known. */
function clipTo(
  { pen }: Sheet,
  scale: TimeScale,
  heard: readonly (readonly [number, number])[],
  bottom: number,
): void {
  pen.beginPath();
  for (const [from_s, to_s] of heard) {
    const from = xOf(scale, from_s);
    pen.rect(from, TOP - 1, xOf(scale, to_s) - from, bottom - TOP + 2);
  }
  pen.clip();
}

function strokeCurve({ pen }: Sheet, { xs, values }: Curve, yOf: (value: number) => number): void {
  pen.lineWidth = 1.5;
  pen.lineJoin = "round";
  pen.beginPath();
  xs.forEach((x, index) => {
    pen.lineTo(x, yOf(values[index] ?? Number.NaN));
  });
  pen.stroke();
}

/** The lines of the values of an axis and, on the left, their numbers. */
export function paintValues(
  { pen, colours }: Sheet,
  scale: TimeScale,
  [low, high]: [number, number],
  yOf: (value: number) => number,
  bottom: number,
): void {
  const ticks = ticksBetween(low, high, Math.max(2, (bottom - TOP) / 24));
  const step = (ticks[1] ?? high) - (ticks[0] ?? low);
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const tick of ticks) {
    const y = Math.round(yOf(tick)) + 0.5;
    pen.strokeStyle = colours.grid;
    pen.beginPath();
    pen.moveTo(scale.left, y);
    pen.lineTo(scale.right, y);
    pen.stroke();
    pen.fillStyle = colours.text3;
    pen.fillText(tickText(tick, step), scale.left - 6, Math.min(Math.max(y, TOP + 4), bottom - 4));
  }
}
