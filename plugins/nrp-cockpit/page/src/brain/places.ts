import type { Part } from "./nodes";

/** Which side of the graph a column stands on: its names are outside, beside it; those of the middle are above. */
export type Side = "left" | "right" | "above";

/** A column of neurons, or of the boxes of populations. */
export interface Column {
  parts: readonly Part[];
  side: Side;
  /** The room that its names would like beside it, in pixels. */
  wanted: number;
}

/** The sizes of the columns, in pixels. */
export interface Widths {
  /** Half the width of a box. */
  box: number;
  /** The middle of each column. */
  xs: number[];
  /** The room for a name of each column. */
  words: number[];
}

/** Half the width of a box: as it is drawn if there is room, as its numbers need it, and where it is too narrow. */
const BOX_PX = { most: 60, least: 46, narrow: 30 };
/** Names get at least this much, as long as they need it, before boxes do. */
const LEAST_WORDS_PX = 90;
/** A side never takes more of the width. */
const MOST_WORDS = 0.32;
const EDGE_PX = 8;
const GAP_PX = 14;
const NAME_GAP = 10;

export const isBox = ({ index }: Part): boolean => index === null;
const isOfBoxes = ({ parts }: Column): boolean => parts.some(isBox);
const isNamed = (column: Column): boolean => column.side !== "above" && !isOfBoxes(column);

/** Puts columns beside each other, so that nothing overlaps as long as there is room. */
export function placed(columns: readonly Column[], width: number, radius: number): Widths {
  const boxes = columns.filter(isOfBoxes).length;
  const named = columns.filter(isNamed);
  const between = GAP_PX * (columns.length - 1) + 2 * EDGE_PX;
  const room = width - between - 2 * radius * (columns.length - boxes) - NAME_GAP * named.length;
  const least = named.reduce((sum, { wanted }) => sum + Math.min(wanted, LEAST_WORDS_PX), 0);
  const beforeNames = clamp(room / (2 * boxes), BOX_PX.narrow, BOX_PX.least);
  const box = boxes === 0 ? 0 : clamp((room - least) / (2 * boxes), beforeNames, BOX_PX.most);
  const most = Math.min(MOST_WORDS * width, (room - 2 * box * boxes) / Math.max(1, named.length));
  const beside = columns.map((column) =>
    isNamed(column) ? NAME_GAP + clamp(column.wanted, 0, Math.max(0, most)) : 0,
  );
  const halves = columns.map((column) => (isOfBoxes(column) ? box : radius));
  const xs = middles(columns, halves, beside, width);
  const words = columns.map((column, at) =>
    isNamed(column) ? (beside[at] ?? 0) - NAME_GAP : roomAbove(xs, at, width),
  );
  return { box, xs, words };
}

/** The middles of columns that stand from edge to edge, with the same room between any two. */
function middles(
  columns: readonly Column[],
  halves: readonly number[],
  beside: readonly number[],
  width: number,
): number[] {
  if (columns.length === 1) return [width / 2];
  const taken = [...halves.map((half) => 2 * half), ...beside].reduce((sum, each) => sum + each, 0);
  const gap = (width - 2 * EDGE_PX - taken) / (columns.length - 1);
  let at = EDGE_PX;
  return columns.map(({ side }, column) => {
    const [half, name] = [halves[column] ?? 0, beside[column] ?? 0];
    const x = at + half + (side === "left" ? name : 0);
    at += 2 * half + name + gap;
    return x;
  });
}

/** How wide a name above a column may be before it meets one above the next. */
function roomAbove(xs: readonly number[], at: number, width: number): number {
  const x = xs[at] ?? 0;
  const [before, after] = [xs[at - 1] ?? -x, xs[at + 1] ?? 2 * width - x];
  return Math.min(x - before, after - x);
}

const clamp = (value: number, least: number, most: number) => Math.max(least, Math.min(most, value));
