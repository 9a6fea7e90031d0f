import { type Role, rolesOf } from "../brain/cells";
import type { Selection } from "../state/selection";
import type { Device, Population } from "../state/types";
import { clock } from "./clock";
import type { Palette } from "./palette";
import { drawCursors, drawEvents, drawTimeAxis, MARGIN, setFont } from "./pen";
import { cellAt, fillLines, layBands, markSpike, type Pixels, pixelOf } from "./raster";
import { drawRates } from "./ratesPicture";
import { drawNames, drawSelected, drawUnheard, type Row, TOP } from "./rows";
import { spikesOf } from "./spikeStore";
import type { TimeScale } from "./timeAxis";
import type { Sheet } from "./useCanvas";
import { scaleNow } from "./useTimeNavigation";

export type Kind = "spikes" | "rates";

interface Event {
  name: string;
  t_s: number | null;
}

/** Paints the populations below each other, as lines of spikes or as histograms of rates. */
export class SpikesPicture {
  scale: TimeScale = { from_s: 0, to_s: 1, left: 0, right: 1 };
  private rows: Row[] = [];
  private ratio = 1;
  private kind: Kind = "spikes";
  private readonly roles: Role[][];
  private readonly image = document.createElement("canvas");
  private pixels: ImageData | null = null;
  private readonly inks = new Map<readonly Role[], Uint32Array>();
  private inked: Palette | null = null;

  constructor(
    private readonly populations: readonly Population[],
    devices: readonly Device[],
  ) {
    this.roles = populations.map((population) => rolesOf(population, devices));
  }

  paint(sheet: Sheet, kind: Kind, events: readonly Event[], selected: Selection | null): void {
    const bottom = sheet.height - MARGIN.bottom;
    this.kind = kind;
    this.ratio = sheet.ratio;
    this.scale = scaleNow(MARGIN.left, sheet.width - MARGIN.right);
    if (bottom - TOP < 8 || this.scale.right - this.scale.left < 8) return;
    this.rows = this.layRows(Math.floor((bottom - TOP) * sheet.ratio));
    setFont(sheet);
    for (const row of this.rows) {
      if (selected) drawSelected(sheet, this.scale, row, selected);
      drawUnheard(sheet, this.scale, row, clock.now_s);
    }
    drawTimeAxis(sheet, this.scale, TOP, bottom);
    if (kind === "spikes") this.paintSpikes(sheet);
    else for (const row of this.rows) drawRates(sheet, this.scale, row, clock.now_s);
    drawEvents(sheet, this.scale, events, { top: TOP, bottom, names: TOP / 2 });
    drawCursors(sheet, this.scale, clock.now_s, TOP, bottom);
    drawNames(sheet, this.rows, kind === "spikes");
  }

  /** What is shown at a height: a neuron where each has a line of its own, else its population. */
  at(y: number): Selection | null {
    const below = (y - TOP) * this.ratio;
    const row = this.rows.find(({ band }) => below >= band.top && below < band.top + band.height);
    if (!row) return null;
    const { label } = row.population;
    if (row.band.pitch < 1 || this.kind === "rates") return { kind: "population", label };
    return { kind: "neuron", population: label, index: cellAt(row.band, below - row.band.top) };
  }

  private layRows(height: number): Row[] {
    const sizes = this.populations.map(({ size }) => size);
    return layBands(sizes, height).flatMap((band, at) => {
      const [population, roles] = [this.populations[at], this.roles[at]];
      return population && roles ? [{ population, roles, band }] : [];
    });
  }

  private paintSpikes({ pen, colours, ratio }: Sheet): void {
    const { left, right } = this.scale;
    const last = this.rows.at(-1)?.band;
    const wide = Math.round((right - left) * ratio);
    const high = (last?.top ?? 0) + (last?.height ?? 0) + 1;
    if (this.pixels?.width !== wide || this.pixels.height !== high) {
      this.image.width = wide;
      this.image.height = high;
      this.pixels = new ImageData(wide, high);
    }
    const pixels = { data: new Uint32Array(this.pixels.data.buffer), width: wide };
    pixels.data.fill(0);
    for (const row of this.rows) this.markSpikes(pixels, row, colours);
    this.image.getContext("2d")?.putImageData(this.pixels, 0, 0);
    pen.drawImage(this.image, left, TOP, wide / ratio, high / ratio);
  }

  private markSpikes(pixels: Pixels, { band, population, roles }: Row, colours: Palette): void {
    const { from_s, to_s } = this.scale;
    const px_per_s = pixels.width / (to_s - from_s);
    const inks = this.inksOf(roles, colours);
    const spikes = spikesOf(population.label);
    const end = spikes.indexAt(to_s);
    for (let index = spikes.indexAt(from_s); index < end; index++) {
      const cell = spikes.valueAt(index); // 80 000 a picture: a call for each would take longer than the marks
      const x = Math.floor((spikes.timeAt(index) - from_s) * px_per_s);
      markSpike(pixels, band, x, cell, inks[cell] ?? 0);
    }
    fillLines(pixels, band);
  }

  /** The colours of the cells of a population, made once for each theme. */
  private inksOf(roles: readonly Role[], colours: Palette): Uint32Array {
    if (this.inked !== colours) this.inks.clear();
    this.inked = colours;
    const known = this.inks.get(roles) ?? Uint32Array.from(roles, (role) => pixelOf(colours[role]));
    this.inks.set(roles, known);
    return known;
  }
}
