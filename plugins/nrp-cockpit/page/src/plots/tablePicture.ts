import { clock } from "./clock";
import type { Palette } from "./palette";
import { lineOf as pixelLineOf } from "./raster";
import { binFor, type LineOf, RateTable } from "./rates";
import { type Row, TOP } from "./rows";
import { spikesOf } from "./spikeStore";
import { niceStep, type TimeScale, tickText, xOf } from "./timeAxis";
import type { Pen, Sheet } from "./useCanvas";

/** A line of the table in the picture, in device pixels. */
interface Line {
  row: Row;
  top: number;
  height: number;
  cells: number;
}

/** No line of a heat map is lower, in CSS pixels. */
const LOWEST_PX = 2;

/** The rates of bands, or of their cells, in a window of time that moves: as bars, or as colours. */
export class TablePicture {
  private readonly table: RateTable;
  private readonly lines: Line[] = [];
  private readonly lineOf = new Map<string, LineOf>();
  private readonly image = document.createElement("canvas");

  /** `each`: whether the cells of a band have lines of their own, as far as there is height for them. */
  constructor(length_s: number, rows: readonly Row[], height: number, ratio: number, each: boolean) {
    for (const row of rows) {
      const together = each ? Math.max(1, Math.ceil((LOWEST_PX * ratio) / row.band.pitch)) : row.cells.length;
      this.addLines(row, height, together);
    }
    const sizes = this.lines.map(({ cells }) => cells);
    this.table = new RateTable(length_s, binFor(length_s), sizes);
  }

  /** Adds the lines of a band that are in sight, each of so many cells. */
  private addLines(row: Row, height: number, together: number): void {
    const { band, cells, population } = row;
    const lineOf = this.lineOf.get(population.label) ?? new Int32Array(population.size).fill(-1);
    this.lineOf.set(population.label, lineOf);
    for (let first = 0; first < cells.length; first += together) {
      const own = cells.subarray(first, first + together);
      const top = band.top + pixelLineOf(band, first);
      const high = own.length === cells.length ? band.height : own.length * band.pitch;
      if (top + high <= 0 || top >= height) continue;
      for (const cell of own) lineOf[cell] = this.lines.length;
      this.lines.push({ row, top, height: high, cells: own.length });
    }
  }

  count(from_s: number): void {
    const populations = [...this.lineOf].map(([label, lineOf]) => ({ ring: spikesOf(label), lineOf }));
    this.table.count(from_s, populations);
  }

  /** Draws the rate of each line as bars, and says how high they are. */
  paintBars(sheet: Sheet, scale: TimeScale): void {
    const { pen, colours } = sheet;
    this.lines.forEach(({ row }, line) => {
      const highest_hz = Math.max(1, this.table.highest_hz(line));
      const [top, bottom] = [row.top, row.bottom];
      pen.save();
      pen.beginPath();
      pen.rect(scale.left, top, scale.right - scale.left, bottom - top);
      pen.clip();
      pen.fillStyle = colours[row.population.role];
      const px_per_hz = Math.max(0, bottom - top - 4) / highest_hz;
      this.fillBars(pen, scale, line, bottom, px_per_hz);
      pen.restore();
      if (bottom - top < BOTH_PX) return;
      const hasAxis = bottom - top >= AXIS_PX;
      const tick_hz = niceStep(highest_hz * AXIS_SHARE);
      pen.fillStyle = colours.text3;
      pen.textAlign = "right";
      pen.textBaseline = "alphabetic";
      const low = hasAxis ? "0" : `${tickText(highest_hz, highest_hz / 10)} Hz`;
      pen.fillText(low, scale.left - 6, bottom - 2);
      if (!hasAxis) return;
      const high = bottom - tick_hz * px_per_hz;
      pen.fillRect(scale.left - 4, high, 4, 1);
      pen.textBaseline = "middle";
      pen.fillText(`${tickText(tick_hz, tick_hz)} Hz`, scale.left - 6, high);
    });
  }

  private fillBars(pen: Pen, scale: TimeScale, line: number, bottom: number, px_per_hz: number): void {
    const { table } = this;
    for (let bin = table.first; bin < table.first + table.bins; bin++) {
      const [left, right] = [xOf(scale, bin * table.bin_s), xOf(scale, (bin + 1) * table.bin_s)];
      pen.fillRect(left, bottom, right - left - 0.5, -table.rate_hz(line, bin) * px_per_hz);
    }
  }

  /** Draws the rate of each line and bin as a colour, and above them the colours with their rates. */
  paintColours(sheet: Sheet, scale: TimeScale): void {
    const { table, lines } = this;
    if (lines.length === 0) return;
    const highest_hz = niceStep(Math.max(1, ...lines.map((_, line) => table.highest_hz(line))));
    const ramp = rampOf(sheet.colours);
    const picture = new ImageData(table.bins, lines.length);
    const pixels = new Uint32Array(picture.data.buffer);
    for (let line = 0; line < lines.length; line++)
      for (let bin = 0; bin < table.bins; bin++) {
        const rate_hz = table.rate_hz(line, table.first + bin);
        pixels[line * table.bins + bin] = ramp[shadeOf(rate_hz, highest_hz)] as number;
      }
    this.image.width = table.bins;
    this.image.height = lines.length;
    this.image.getContext("2d")?.putImageData(picture, 0, 0);
    this.putLines(sheet, scale);
    drawRamp(sheet, scale, ramp, highest_hz);
  }

  private putLines(sheet: Sheet, scale: TimeScale): void {
    const { pen, ratio } = sheet;
    const { table } = this;
    const [left, right] = [table.first, table.first + table.bins].map((bin) =>
      xOf(scale, bin * table.bin_s),
    ) as [number, number];
    pen.save();
    pen.imageSmoothingEnabled = false;
    pen.beginPath();
    pen.rect(scale.left, TOP, Math.min(scale.right, xOf(scale, clock.now_s)) - scale.left, sheet.height);
    pen.clip();
    this.lines.forEach(({ row, top, height }, line) => {
      const [from, to] = [
        Math.max(row.top, TOP + top / ratio),
        Math.min(row.bottom, TOP + (top + height) / ratio),
      ];
      if (to > from) pen.drawImage(this.image, 0, line, table.bins, 1, left, from, right - left, to - from);
    });
    pen.restore();
  }
}

/** The height of a band that holds its name and its highest rate. */
const BOTH_PX = 26;
/** Bars from this height on have an axis with two ticks, below the name; lower ones say how high the highest is. */
const AXIS_PX = 80;
/** The least share of the highest rate at which its upper tick is; it is at most 2.5 times as high. */
const AXIS_SHARE = 0.32;
const SHADES = 256;

/** The number of the colour of a rate: its root, so that low rates beside high ones are seen. */
const shadeOf = (rate_hz: number, highest_hz: number) =>
  Math.min(SHADES - 1, Math.round(Math.sqrt(rate_hz / highest_hz) * (SHADES - 1)));

/** The colours from none over the accent to that of text, as pixels. */
function rampOf({ panel, accent, text }: Palette): Uint32Array {
  const [low, middle, high] = [panel, accent, text].map(channelsOf) as [number[], number[], number[]];
  return Uint32Array.from({ length: SHADES }, (_, at) => {
    const share = at / (SHADES - 1);
    const [a, b, part] = share < 0.7 ? [low, middle, share / 0.7] : [middle, high, (share - 0.7) / 0.3];
    const [red, green, blue] = a.map((value, one) => Math.round(value + ((b[one] ?? 0) - value) * part));
    return at === 0 ? 0 : (0xff000000 | ((blue ?? 0) << 16) | ((green ?? 0) << 8) | (red ?? 0)) >>> 0;
  });
}

/** Red, green and blue of a CSS colour `#rrggbb` or `#rgb`. */
function channelsOf(hex: string): number[] {
  const digits = hex.length < 7 ? hex.replace(/[^#]/g, "$&$&") : hex;
  return [1, 3, 5].map((at) => Number.parseInt(digits.slice(at, at + 2), 16));
}

const RAMP_PX = { width: 96, height: 6 };

/** The colours with the rates of their ends and of their middle. */
function drawRamp(
  { pen, colours }: Sheet,
  { right }: TimeScale,
  ramp: Uint32Array,
  highest_hz: number,
): void {
  const { width, height } = RAMP_PX;
  const [words, top] = [`${tickText(highest_hz, highest_hz / 10)} Hz`, TOP / 2 - height / 2];
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  pen.fillStyle = colours.panel;
  const end = right - pen.measureText(words).width - 6;
  pen.fillRect(end - width - 16, 0, right - end + width + 16, TOP - 1);
  pen.fillStyle = colours.text3;
  pen.fillText(words, right, TOP / 2);
  pen.fillText("0", end - width - 6, TOP / 2);
  for (let x = 0; x < width; x++) {
    const ink = ramp[Math.round((x / (width - 1)) * (ramp.length - 1))] ?? 0;
    pen.fillStyle = ink === 0 ? colours.panel : cssOf(ink);
    pen.fillRect(end - width + x, top, 1, height);
  }
  pen.strokeStyle = colours.line;
  pen.strokeRect(end - width - 0.5, top - 0.5, width + 1, height + 1);
}

const cssOf = (ink: number) => `rgb(${ink & 0xff} ${(ink >> 8) & 0xff} ${(ink >> 16) & 0xff})`;
