/** The lines of a picture that show the spikes of some cells, in device pixels. */
export interface Band {
  /** May be above or below the picture, where only a part of all cells is in sight. */
  top: number;
  height: number;
  cells: number;
  /** How high the line of a cell is, with the gap below it; below 1 several cells share a line. */
  pitch: number;
}

/** The picture of the spikes: four bytes a pixel, as the machine orders them. */
export interface Pixels {
  data: Uint32Array;
  width: number;
  height: number;
}

/** The part of the height of all bands that is in sight, from 0 to 1. */
export interface Sight {
  from: number;
  to: number;
}

export const ALL: Sight = { from: 0, to: 1 };

const GAP = 6;
/** Many bands stand closer together. */
const SMALL_GAP = 2;
const MANY = 8;
/** Lines that are this high leave a gap to the next one. */
const GAPPED = 5;
/** No cell is drawn higher. */
const HIGHEST = 48;

/** Shares a height among bands: by their cells if there are few, else partly evenly and partly by magnitude. */
export function layBands(sizes: readonly number[], inSight: number, { from, to } = ALL): Band[] {
  const height = inSight / (to - from);
  const many = sizes.length > MANY;
  const [gap, even] = many ? [SMALL_GAP, 0.9] : [GAP, 0.5];
  const room = Math.max(0, height - gap * (sizes.length - 1));
  const all = sizes.reduce((sum, size) => sum + size, 0);
  const few = inSight / all >= GAPPED;
  const weights = sizes.map((size) => (few ? size : Math.log2(size + 1)));
  const total = weights.reduce((sum, weight) => sum + weight, 0);
  let top = -from * height;
  return sizes.map((cells, at) => {
    const share = (weights[at] ?? 0) / total;
    const own = room * (few ? share : even / sizes.length + (1 - even) * share);
    const pitch = own / cells >= 2 ? Math.floor(own / cells) : own / cells;
    const band = { top: Math.round(top), height: Math.floor(own), cells, pitch };
    top += own + gap;
    return band;
  });
}

/** The first pixel of a line below the top of its band. */
export const lineOf = (band: Band, row: number): number => Math.floor(row * band.pitch);

/** The row at a height below the top of its band. */
export const rowAt = (band: Band, y: number): number =>
  Math.max(0, Math.min(band.cells - 1, Math.floor(y / band.pitch)));

/** How many pixels of its line a spike fills. */
export const highOf = ({ pitch }: Band): number =>
  pitch >= GAPPED ? Math.floor(pitch * 0.85) : Math.max(1, Math.floor(pitch));

/** Less of the height in sight, or more, around the one at a share of the picture; `cells`: of all bands. */
export function zoomed(
  { from, to }: Sight,
  at: number,
  factor: number,
  cells: number,
  height: number,
): Sight {
  const least = Math.min(1, height / (HIGHEST * Math.max(1, cells)));
  const length = Math.min(1, Math.max(least, (to - from) * factor));
  const begin = from + at * (to - from - length);
  return shifted({ from: begin, to: begin + length }, 0);
}

/** The sight moved by a part of all, as far as there is something to see. */
export function shifted({ from, to }: Sight, by: number): Sight {
  const length = to - from;
  const begin = Math.max(0, Math.min(1 - length, from + by));
  return { from: begin, to: begin + length };
}

const OPAQUE = 0xff000000;
const FIRST_ALPHA = 0x70;
const MORE_ALPHA = 0x18;

/** Where the spikes of the cells of a population are drawn. */
export interface Lines {
  /** The first pixel of each cell; negative: it is not in sight. */
  tops: Int32Array;
  highs: Uint16Array;
  /** The colour of each cell, as an opaque pixel. */
  inks: Uint32Array;
  /** Whether several cells share the line of a cell: it gets darker with the number of their spikes. */
  shared: Uint8Array;
}

/** Marks a spike at a place of the picture. */
export function markSpike({ data, width, height }: Pixels, lines: Lines, x: number, cell: number): void {
  const top = lines.tops[cell];
  if (top === undefined || top < 0) return;
  const ink = lines.inks[cell] as number;
  if (lines.shared[cell]) {
    const at = top * width + x;
    const alpha = (data[at] as number) >>> 24;
    const more = alpha === 0 ? FIRST_ALPHA : Math.min(255, alpha + MORE_ALPHA);
    data[at] = ((ink & ~OPAQUE) | (more << 24)) >>> 0;
    return;
  }
  const end = Math.min(height, top + (lines.highs[cell] as number));
  for (let y = top; y < end; y++) data[y * width + x] = ink;
}

/** A CSS colour `#rrggbb` as an opaque pixel of a little-endian machine, which all browsers run on. */
export function pixelOf(hex: string): number {
  const value = Number.parseInt(hex.slice(1), 16);
  return (OPAQUE | ((value & 0xff) << 16) | (value & 0xff00) | (value >> 16)) >>> 0;
}
