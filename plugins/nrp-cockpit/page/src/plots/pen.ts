import { type TimeScale, ticksBetween, tickText, xOf } from "./timeAxis";
import type { Pen, Sheet } from "./useCanvas";
import { crosshair } from "./useTimeNavigation";

/** The margins of every plot, so that their times stand below each other. */
export const MARGIN = { left: 80, right: 12, bottom: 18 };

const TICK_PX = 72;

function vertical(pen: Pen, x: number, top: number, bottom: number): void {
  pen.beginPath();
  pen.moveTo(Math.round(x) + 0.5, top);
  pen.lineTo(Math.round(x) + 0.5, bottom);
  pen.stroke();
}

/** The grid of time between two heights and, below it, its seconds. */
export function drawTimeAxis(
  { pen, colours, figure }: Sheet,
  scale: TimeScale,
  top: number,
  bottom: number,
  named = true,
): void {
  const ticks = ticksBetween(scale.from_s, scale.to_s, (scale.right - scale.left) / TICK_PX);
  const step = (ticks[1] ?? 1) - (ticks[0] ?? 0);
  pen.strokeStyle = colours.grid;
  pen.fillStyle = colours.text3;
  pen.textAlign = "center";
  pen.textBaseline = "top";
  pen.lineWidth = 1;
  for (const tick of ticks) {
    vertical(pen, xOf(scale, tick), top, bottom);
    const x = Math.min(xOf(scale, tick), scale.right - 8);
    if (named) pen.fillText(`${tickText(tick, step)}${figure ? "" : " s"}`, x, bottom + 4); // or the axis is named
  }
}

const WORDS_PX = 60;

/** A ground for the stretches that were not heard, with words where they fit. */
export function drawGaps(
  { pen, colours }: Sheet,
  scale: TimeScale,
  gaps: readonly (readonly [number, number])[],
  top: number,
  bottom: number,
): void {
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  for (const [from_s, to_s] of gaps) {
    const [from, to] = [xOf(scale, from_s), xOf(scale, to_s)];
    pen.fillStyle = colours.hover;
    pen.fillRect(from, top, to - from, bottom - top);
    pen.fillStyle = colours.text3;
    if (to - from > WORDS_PX) pen.fillText("not recorded", (from + to) / 2, (top + bottom) / 2);
  }
}

/** Now, and the pointer. */
export function drawCursors(
  { pen, colours, figure }: Sheet,
  scale: TimeScale,
  now_s: number,
  top: number,
  bottom: number,
): void {
  if (figure) return;
  if (now_s >= scale.from_s && now_s <= scale.to_s) {
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 2;
    vertical(pen, xOf(scale, now_s) - 0.5, top, bottom);
    pen.lineWidth = 1;
  }
  if (crosshair.share === null) return;
  pen.strokeStyle = colours.text3;
  vertical(pen, scale.left + crosshair.share * (scale.right - scale.left), top, bottom);
}

/** The events of the run that lie in the window, as dashed lines; with their names where there is room for them. */
export function drawEvents(
  { pen, colours }: Sheet,
  scale: TimeScale,
  events: readonly { name: string; t_s: number | null }[],
  lines: { top: number; bottom: number; names?: number },
): void {
  pen.strokeStyle = colours.text3;
  pen.fillStyle = colours.text2;
  pen.textBaseline = "middle";
  pen.textAlign = "center";
  let free = Number.NEGATIVE_INFINITY;
  for (const { name, t_s } of events) {
    if (t_s === null || t_s < scale.from_s || t_s > scale.to_s) continue;
    pen.setLineDash([3, 3]);
    vertical(pen, xOf(scale, t_s), lines.top, lines.bottom);
    pen.setLineDash([]);
    const half = pen.measureText(name).width / 2;
    if (lines.names === undefined || xOf(scale, t_s) - half < free) continue;
    pen.fillText(name, xOf(scale, t_s), lines.names);
    free = xOf(scale, t_s) + half + 4;
  }
}

/** Sets the font of the page at the size of small print. */
export function setFont({ pen, colours }: Sheet): void {
  pen.font = colours.font;
}
