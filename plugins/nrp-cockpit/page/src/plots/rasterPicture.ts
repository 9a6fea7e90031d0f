import { clock } from "./clock";
import type { Palette } from "./palette";
import { highOf, type Lines, lineOf, markSpike, type Pixels, pixelOf } from "./raster";
import { type Row, TOP } from "./rows";
import { Scroll, type Stretch } from "./scroll";
import { spikesOf } from "./spikeStore";
import { type TimeScale, xOf } from "./timeAxis";
import type { Sheet } from "./useCanvas";

/** How wide a spike is in a figure. */
const SPIKE_PX = 0.75;

/** The spikes of some bands in a window of time that moves. */
export class RasterPicture {
  private readonly image = document.createElement("canvas");
  private readonly picture: ImageData;
  private readonly pixels: Pixels;
  private readonly scroll: Scroll;
  private readonly lines: ReadonlyMap<string, Lines>;

  /** Sizes in device pixels. */
  constructor(width: number, height: number, columns_per_s: number, rows: readonly Row[], colours: Palette) {
    this.image.width = width;
    this.image.height = height;
    this.picture = new ImageData(width, height);
    this.pixels = { data: new Uint32Array(this.picture.data.buffer), width, height };
    this.scroll = new Scroll(width, columns_per_s);
    this.lines = linesOf(rows, height, colours);
  }

  /** Draws what is new since the last picture, and puts the picture onto the sheet. */
  paint({ pen, ratio }: Sheet, left: number, from_s: number): void {
    const { scroll, pixels } = this;
    const labels = [...this.lines.keys()];
    const fresh = scroll.moveTo(from_s, labels.map(spikesOf));
    let [first, end] = fresh ?? [scroll.end, scroll.first];
    if (fresh) this.clear(fresh);
    for (const [label, lines] of this.lines)
      scroll.visit(spikesOf(label), fresh, (column, cell) => {
        if (column < first) first = column;
        if (column >= end) end = column + 1;
        markSpike(pixels, lines, scroll.placeOf(column), cell);
      });
    if (end > first) this.put([first, end]);
    const [cut, high] = [scroll.placeOf(scroll.first), pixels.height];
    const right = pixels.width - cut;
    pen.drawImage(this.image, cut, 0, right, high, left, TOP, right / ratio, high / ratio);
    if (cut > 0)
      pen.drawImage(this.image, 0, 0, cut, high, left + right / ratio, TOP, cut / ratio, high / ratio);
  }

  /** Draws each spike in sight as a line. */
  stroke({ pen, ratio, colours }: Sheet, scale: TimeScale): void {
    pen.lineWidth = SPIKE_PX;
    pen.lineCap = "butt";
    for (const [label, { tops, highs, inks }] of this.lines)
      for (const role of ["sensor", "circuit", "actor"] as const) {
        const ink = pixelOf(colours[role]);
        pen.beginPath();
        spikesOf(label).visit(scale.from_s, Math.min(scale.to_s, clock.now_s + 1e-9), (t_s, cell) => {
          const top = tops[cell] ?? -1;
          if (top < 0 || inks[cell] !== ink) return;
          const [x, y] = [xOf(scale, t_s), TOP + top / ratio];
          pen.moveTo(x, y);
          pen.lineTo(x, y + (highs[cell] as number) / ratio);
        });
        pen.strokeStyle = colours[role];
        pen.stroke();
      }
  }

  private clear(stretch: Stretch): void {
    const { data, width, height } = this.pixels;
    for (const [from, to] of this.placesOf(stretch))
      for (let y = 0; y < height; y++) data.fill(0, y * width + from, y * width + to);
  }

  private put(stretch: Stretch): void {
    const pen = this.image.getContext("2d");
    for (const [from, to] of this.placesOf(stretch))
      pen?.putImageData(this.picture, 0, 0, from, 0, to - from, this.pixels.height);
  }

  /** The places of columns, which may go on at the other end. */
  private placesOf([first, end]: Stretch): Stretch[] {
    const { width } = this.pixels;
    if (end - first >= width) return [[0, width]];
    const [from, to] = [this.scroll.placeOf(first), this.scroll.placeOf(end)];
    if (from < to) return [[from, to]];
    return to > 0
      ? [
          [from, width],
          [0, to],
        ]
      : [[from, width]];
  }
}

/** Where the cells of each population are drawn, and in which colour. */
function linesOf(rows: readonly Row[], height: number, colours: Palette): Map<string, Lines> {
  const inks = {
    sensor: pixelOf(colours.sensor),
    circuit: pixelOf(colours.circuit),
    actor: pixelOf(colours.actor),
  };
  const all = new Map<string, Lines>();
  for (const { population, roles, band, cells } of rows) {
    const lines = all.get(population.label) ?? noLines(population.size);
    all.set(population.label, lines);
    for (let row = 0; row < cells.length; row++) {
      const cell = cells[row] as number;
      const top = band.top + lineOf(band, row);
      if (top < 0 || top >= height) continue;
      lines.tops[cell] = top;
      lines.highs[cell] = highOf(band);
      lines.shared[cell] = band.pitch < 1 ? 1 : 0;
      lines.inks[cell] = inks[roles[cell] ?? population.role];
    }
  }
  return all;
}

const noLines = (size: number): Lines => ({
  tops: new Int32Array(size).fill(-1),
  highs: new Uint16Array(size),
  inks: new Uint32Array(size),
  shared: new Uint8Array(size),
});
