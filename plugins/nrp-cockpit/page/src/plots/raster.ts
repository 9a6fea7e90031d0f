/** The lines of a picture that show the spikes of one population, in device pixels. */
export interface Band {
  top: number;
  height: number;
  cells: number;
  /** How high the line of a neuron is, with the gap below it; below 1 several neurons share a line. */
  pitch: number;
}

/** The picture of the spikes: four bytes a pixel, as the machine orders them. */
export interface Pixels {
  data: Uint32Array;
  width: number;
}

const GAP = 6;
/** Lines that are this high leave a gap to the next one. */
const GAPPED = 5;

/** Shares a height among populations: half of it evenly, half by their numbers of neurons; all by numbers if few. */
export function layBands(sizes: readonly number[], height: number): Band[] {
  const room = Math.max(0, height - GAP * (sizes.length - 1));
  const all = sizes.reduce((sum, size) => sum + size, 0);
  const few = room / all >= GAPPED;
  let top = 0;
  return sizes.map((cells) => {
    const own = room * (few ? cells / all : 0.5 / sizes.length + (0.5 * cells) / all);
    const pitch = own / cells >= 2 ? Math.floor(own / cells) : own / cells;
    const band = { top: Math.round(top), height: Math.floor(own), cells, pitch };
    top += own + GAP;
    return band;
  });
}

/** The first pixel of a neuron's line below the top of its band. */
export const lineOf = (band: Band, cell: number): number => Math.floor(cell * band.pitch);

/** The number of the neuron at a height below the top of its band. */
export const cellAt = (band: Band, y: number): number =>
  Math.max(0, Math.min(band.cells - 1, Math.floor(y / band.pitch)));

/** Marks a spike in the first pixel of its line; `fillLines` does the rest. */
export function markSpike(pixels: Pixels, band: Band, x: number, cell: number, colour: number): void {
  if (x >= 0 && x < pixels.width && cell < band.cells)
    pixels.data[(band.top + lineOf(band, cell)) * pixels.width + x] = colour;
}

/** Repeats the marks of each line over its height. */
export function fillLines({ data, width }: Pixels, band: Band): void {
  const high = band.pitch >= GAPPED ? Math.floor(band.pitch * 0.85) : Math.floor(band.pitch);
  for (let cell = 0; cell < band.cells && high > 1; cell++) {
    const first = (band.top + lineOf(band, cell)) * width;
    for (let row = 1; row < high; row++) data.copyWithin(first + row * width, first, first + width);
  }
}

/** A CSS colour `#rrggbb` as an opaque pixel of a little-endian machine, which all browsers run on. */
export function pixelOf(hex: string): number {
  const value = Number.parseInt(hex.slice(1), 16);
  return (0xff000000 | ((value & 0xff) << 16) | (value & 0xff00) | (value >> 16)) >>> 0;
}
