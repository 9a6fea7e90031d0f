import { type Role, rolesOf } from "../brain/cells";
import type { Selection } from "../state/selection";
import type { Device, Population } from "../state/types";
import { clock } from "./clock";
import type { Palette } from "./palette";
import { drawCursors, drawEvents, drawTimeAxis, MARGIN, setFont } from "./pen";
import { type Band, cellAt, fillLines, layBands, lineOf, markSpike, type Pixels, pixelOf } from "./raster";
import { binFor, type Histogram, histogramOf } from "./rates";
import { spikesOf } from "./spikeStore";
import { type TimeScale, tickText, xOf } from "./timeAxis";
import type { Sheet } from "./useCanvas";
import { scaleNow } from "./useTimeNavigation";

export type Kind = "spikes" | "rates";

interface Event {
  name: string;
  t_s: number | null;
}

const TOP = 16;
const LABEL_PX = 11;

/** Paints the populations below each other, as lines of spikes or as histograms of rates. */
export class SpikesPicture {
  scale: TimeScale = { from_s: 0, to_s: 1, left: 0, right: 1 };
  private bands: Band[] = [];
  private ratio = 1;
  private readonly roles: Role[][];
  private readonly image = document.createElement("canvas");
  private pixels: ImageData | null = null;

  constructor(
    private readonly populations: readonly Population[],
    devices: readonly Device[],
  ) {
    this.roles = populations.map((population) => rolesOf(population, devices));
  }

  paint(sheet: Sheet, kind: Kind, events: readonly Event[], selected: Selection | null): void {
    const { width, height, ratio } = sheet;
    const bottom = height - MARGIN.bottom;
    this.ratio = ratio;
    this.scale = scaleNow(MARGIN.left, width - MARGIN.right);
    this.bands = layBands(
      this.populations.map(({ size }) => size),
      Math.floor((bottom - TOP) * ratio),
    );
    if (bottom - TOP < 8 || this.scale.right - this.scale.left < 8) return;
    setFont(sheet);
    this.mark(sheet, selected);
    drawTimeAxis(sheet, this.scale, TOP, bottom);
    if (kind === "spikes") this.paintSpikes(sheet);
    else this.paintRates(sheet);
    drawEvents(sheet, this.scale, events, { top: TOP, bottom, names: TOP / 2 });
    drawCursors(sheet, this.scale, clock.now_s, TOP, bottom);
    this.name(sheet, kind);
  }

  /** What is shown at a height: a neuron where each has a line of its own, else its population. */
  at(y: number): Selection | null {
    const below = (y - TOP) * this.ratio;
    const index = this.bands.findIndex(({ top, height }) => below >= top && below < top + height);
    const [band, population] = [this.bands[index], this.populations[index]];
    if (!band || !population) return null;
    if (band.pitch < 1) return { kind: "population", label: population.label };
    return { kind: "neuron", population: population.label, index: cellAt(band, below - band.top) };
  }

  private paintSpikes({ pen, colours }: Sheet): void {
    const { left, right } = this.scale;
    const last = this.bands.at(-1);
    const wide = Math.round((right - left) * this.ratio);
    const high = (last?.top ?? 0) + (last?.height ?? 0) + 1;
    if (this.pixels?.width !== wide || this.pixels.height !== high) {
      this.image.width = wide;
      this.image.height = high;
      this.pixels = new ImageData(wide, high);
    }
    const pixels = { data: new Uint32Array(this.pixels.data.buffer), width: wide };
    pixels.data.fill(0);
    this.bands.forEach((band, index) => {
      this.markSpikes(pixels, band, index, colours);
    });
    this.image.getContext("2d")?.putImageData(this.pixels, 0, 0);
    pen.drawImage(this.image, left, TOP, wide / this.ratio, high / this.ratio);
  }

  private markSpikes(pixels: Pixels, band: Band, index: number, colours: Palette): void {
    const { from_s, to_s } = this.scale;
    const perSecond = pixels.width / (to_s - from_s);
    const colourOf = this.roles[index]?.map((role) => pixelOf(colours[role])) ?? [];
    spikesOf(this.populations[index]?.label ?? "").visit(from_s, to_s, (t_s, cell) =>
      markSpike(pixels, band, Math.floor((t_s - from_s) * perSecond), cell, colourOf[cell] ?? 0),
    );
    fillLines(pixels, band);
  }

  private paintRates(sheet: Sheet): void {
    const { from_s, to_s } = this.scale;
    const bin_s = binFor(to_s - from_s);
    this.populations.forEach(({ label, size, role }, index) => {
      const band = this.bands[index];
      if (!band) return;
      const histogram = histogramOf(spikesOf(label), size, from_s, Math.min(to_s, clock.now_s), bin_s);
      this.paintHistogram(sheet, band, histogram, sheet.colours[role]);
    });
  }

  private paintHistogram({ pen, colours }: Sheet, band: Band, histogram: Histogram, colour: string): void {
    const { first, bin_s, rates_hz } = histogram;
    const { left, right } = this.scale;
    const highest = Math.max(1, ...rates_hz);
    const [height, base] = [band.height / this.ratio - 4, TOP + (band.top + band.height) / this.ratio];
    pen.save();
    pen.beginPath();
    pen.rect(left, TOP, right - left, base - TOP);
    pen.clip();
    pen.fillStyle = colour;
    rates_hz.forEach((rate_hz, bin) => {
      const x = xOf(this.scale, (first + bin) * bin_s);
      const high = (rate_hz / highest) * height;
      pen.fillRect(x, base - high, xOf(this.scale, (first + bin + 1) * bin_s) - x - 0.5, high);
    });
    pen.restore();
    pen.fillStyle = colours.text3;
    pen.textAlign = "right";
    pen.textBaseline = "alphabetic";
    pen.fillText(`${tickText(highest, highest / 10)} Hz`, left - 6, base - 2);
  }

  /** Puts a soft ground behind what is selected. */
  private mark({ pen, colours }: Sheet, selected: Selection | null): void {
    this.populations.forEach(({ label }, index) => {
      const band = this.bands[index];
      const whole = selected?.kind === "population" && selected.label === label;
      const cell = selected?.kind === "neuron" && selected.population === label ? selected.index : null;
      if (!band || (!whole && cell === null)) return;
      const from = band.top + (cell === null ? 0 : lineOf(band, cell));
      const high = cell === null ? band.height : Math.max(band.pitch, 2);
      pen.fillStyle = colours.accentSoft;
      pen.fillRect(0, TOP + from / this.ratio, this.scale.right, high / this.ratio);
    });
  }

  /** Names populations and, where their lines are high enough, neurons by the brain's own numbers. */
  private name({ pen, colours }: Sheet, kind: Kind): void {
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    this.populations.forEach(({ label, size, first }, index) => {
      const band = this.bands[index];
      if (!band) return;
      const numbered = kind === "spikes" && band.pitch / this.ratio >= LABEL_PX;
      const y =
        TOP +
        (band.top + (numbered ? band.pitch : Math.min(band.height, LABEL_PX * this.ratio)) / 2) / this.ratio;
      pen.fillStyle = colours.text2;
      pen.textAlign = "left";
      pen.fillText(shortened(pen, label, MARGIN.left - 24), 8, y);
      pen.textAlign = "right";
      for (let cell = 0; numbered && cell < size; cell++) {
        const line = (band.top + (cell + 0.5) * band.pitch) / this.ratio;
        pen.fillText(String(first + cell), MARGIN.left - 6, TOP + line);
      }
    });
  }
}

/** As much of a text as fits into a width. */
function shortened(pen: CanvasRenderingContext2D, text: string, width: number): string {
  if (pen.measureText(text).width <= width) return text;
  let length = text.length - 1;
  while (length > 1 && pen.measureText(`${text.slice(0, length)}…`).width > width) length--;
  return `${text.slice(0, length)}…`;
}
