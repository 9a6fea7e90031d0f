import { binFor, type Histogram, histogramOf } from "./rates";
import { bottomOf, type Row, topOf } from "./rows";
import { spikesOf } from "./spikeStore";
import { type TimeScale, tickText, xOf } from "./timeAxis";
import type { Sheet } from "./useCanvas";

/** Draws the mean rate of a population as a histogram, and says how high its highest bar is. */
export function drawRates(sheet: Sheet, scale: TimeScale, row: Row, now_s: number): void {
  const { pen, colours, ratio } = sheet;
  const { label, size, role } = row.population;
  const [top, bottom] = [topOf(row, ratio), bottomOf(row, ratio)];
  const bin_s = binFor(scale.to_s - scale.from_s);
  const histogram = histogramOf(spikesOf(label), size, scale.from_s, Math.min(scale.to_s, now_s), bin_s);
  const highest_hz = Math.max(1, ...histogram.rates_hz);
  pen.save();
  pen.beginPath();
  pen.rect(scale.left, top, scale.right - scale.left, bottom - top);
  pen.clip();
  pen.fillStyle = colours[role];
  fillBars(pen, scale, histogram, bottom, (bottom - top - 4) / highest_hz);
  pen.restore();
  pen.fillStyle = colours.text3;
  pen.textAlign = "right";
  pen.textBaseline = "alphabetic";
  pen.fillText(`${tickText(highest_hz, highest_hz / 10)} Hz`, scale.left - 6, bottom - 2);
}

function fillBars(
  pen: CanvasRenderingContext2D,
  scale: TimeScale,
  { first, bin_s, rates_hz }: Histogram,
  bottom: number,
  px_per_hz: number,
): void {
  rates_hz.forEach((rate_hz, bin) => {
    const [left, right] = [xOf(scale, (first + bin) * bin_s), xOf(scale, (first + bin + 1) * bin_s)];
    pen.fillRect(left, bottom, right - left - 0.5, -rate_hz * px_per_hz);
  });
}
