import { columnsOf } from "./columns";
import type { Link, Part } from "./nodes";
import { type Column, isBox, placed, type Side } from "./places";

/** A part with its place, in pixels. */
export interface Placed {
  part: Part;
  x: number;
  y: number;
  /** Half the width and height of a population's box; of a neuron both are its radius. */
  rx: number;
  ry: number;
  /** Where its name stands, and how many letters have room there. */
  side: Side;
  letters: number;
  /** Whether height is wanting: its rate stands behind its name, and above and below it neither has room. */
  tight: boolean;
}

/** A line with its way as the data of an SVG path. */
export interface Drawn {
  link: Link;
  path: string;
}

export interface Graph {
  nodes: Placed[];
  lines: Drawn[];
}

/** The mean width of a letter. */
const LETTER_PX = 6.5;
const LETTERS = 20;
/** A neuron without a name may have its number instead. */
const DIGITS = 5;
/** The room of a rate behind a name, and the height that a name needs to have its rate below it. */
const RATE_PX = 40;
const TWO_LINES_PX = 28;
/** The height of a name above a neuron and of its rate below it. */
const AROUND_PX = 34;
const TOP = 14;
const BOX_RY = 20;
/** The room beside the name in a box. */
const BOX_INSET = 16;
/** How far apart the parts of a column are at least. */
const LEAST_PX = { neuron: 14, box: 39, lowBox: 26 };
/** The width that a box needs with the gap to the next one, for boxes lower than usual to be worth it. */
const BOX_PX = 104;

/** Lays the graph out in a rectangle. */
export function layGraph(
  parts: readonly Part[],
  links: readonly Link[],
  width: number,
  height: number,
): Graph {
  const room = height - 2 * TOP;
  const least = leastBox(parts.filter(isBox).length, width, room);
  const columns = columnsOf(parts, links).flatMap((column, at, { length }) =>
    split(column, room, least, at === 0 ? "left" : at === length - 1 ? "right" : "above"),
  );
  const pitch = room / Math.max(1, ...columns.map((column) => column.parts.length));
  const radius = Math.max(6, Math.min(14, pitch / 2 - 4));
  const { box, xs, words } = placed(columns, width, radius);
  const nodes = columns.flatMap(({ parts: column, side }, at) => {
    const [x, own] = [xs[at] ?? 0, room / column.length];
    const tight = own < (side === "above" ? 2 * radius + AROUND_PX : TWO_LINES_PX);
    const beside = (words[at] ?? 0) - (tight && side !== "above" ? RATE_PX : 0);
    return column.map((part, row): Placed => {
      const size = isBox(part) ? { rx: box, ry: Math.min(BOX_RY, own / 2 - 2) } : { rx: radius, ry: radius };
      const letters = Math.max(0, Math.floor((isBox(part) ? 2 * box - BOX_INSET : beside) / LETTER_PX));
      return { part, x, y: TOP + (row + 0.5) * own, ...size, side, letters, tight };
    });
  });
  return { nodes, lines: linesOf(links, nodes) };
}

/** How far apart boxes are at least: closer if there are too many to stand beside each other. */
function leastBox(boxes: number, width: number, room: number): number {
  const fit = Math.floor(room / LEAST_PX.box) * Math.floor(width / BOX_PX);
  return boxes > fit ? LEAST_PX.lowBox : LEAST_PX.box;
}

const isTight = (column: readonly Part[], room: number) => room / column.length < TWO_LINES_PX;

/** The room that the names of a column of neurons would like, with their rates where there is no line for these. */
function wantedBy(column: readonly Part[], room: number): number {
  const letters = column.map(({ name }) => Math.max(name.length, DIGITS));
  return Math.min(Math.max(...letters), LETTERS) * LETTER_PX + (isTight(column, room) ? RATE_PX : 0);
}

/**
 * A column as some side by side: neurons and boxes apart, because they need different room, and as many as it takes
 * to fit the height. Names stand beside the outermost, or beside the neurons next to the boxes.
 */
function split(column: readonly Part[], room: number, least: number, side: Side): Column[] {
  const neurons = wrapped(
    column.filter((part) => !isBox(part)),
    room,
    LEAST_PX.neuron,
  );
  const boxes = wrapped(column.filter(isBox), room, least);
  const outer = side === "left" ? 0 : neurons.length - 1;
  const named = neurons.map((parts, at): Column => {
    const wanted = wantedBy(parts, room);
    return { parts, side: at === outer ? side : "above", wanted };
  });
  const boxed = boxes.map((parts): Column => ({ parts, side, wanted: 0 }));
  return side === "left" ? [...boxed, ...named] : [...named, ...boxed];
}

function wrapped(column: readonly Part[], room: number, least: number): Part[][] {
  const rows = Math.max(1, Math.floor(room / least));
  const count = Math.ceil(column.length / rows);
  const each = Math.ceil(column.length / count);
  return Array.from({ length: count }, (_, at) => column.slice(at * each, (at + 1) * each));
}

function linesOf(links: readonly Link[], nodes: readonly Placed[]): Drawn[] {
  const placeOf = new Map(nodes.map((node) => [node.part, node]));
  const ways = new Set(links.map(({ from, to }) => `${from.id} > ${to.id}`));
  return links.flatMap((link) => {
    const [from, to] = [placeOf.get(link.from), placeOf.get(link.to)];
    if (!from || !to) return [];
    if (from === to) return { link, path: loopOf(from) };
    const both = ways.has(`${link.to.id} > ${link.from.id}`);
    return { link, path: pathOf(from, to, both || from.x === to.x ? 0.2 : 0) };
  });
}

/** A way from border to border, bent sideways by a share of its length. */
function pathOf(from: Placed, to: Placed, bend: number): string {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const [mx, my] = [(from.x + to.x) / 2 - dy * bend, (from.y + to.y) / 2 + dx * bend];
  const [ax, ay] = borderOf(from, mx, my, 1);
  const [bx, by] = borderOf(to, mx, my, END_PX);
  return `M${round(ax)} ${round(ay)}Q${round(mx)} ${round(my)} ${round(bx)} ${round(by)}`;
}

/** Room for the mark at the end of a line. */
const END_PX = 3;

/** Where a line from the middle of a node towards a point leaves the node, and `gap` pixels more. */
function borderOf({ part, x, y, rx, ry }: Placed, toX: number, toY: number, gap: number): [number, number] {
  const [dx, dy] = [toX - x, toY - y];
  const length = Math.hypot(dx, dy) || 1;
  const out = isBox(part) ? Math.min(rx / Math.abs(dx || 1e-9), ry / Math.abs(dy || 1e-9)) * length : rx;
  return [x + (dx / length) * (out + gap), y + (dy / length) * (out + gap)];
}

/** A loop above a node that projects to itself. */
function loopOf({ x, y, rx, ry }: Placed): string {
  const [half, high] = [Math.min(rx, 12) * 0.7, ry + 14];
  const at = y - ry - 1;
  return `M${round(x - half)} ${round(at)}C${round(x - 2 * half)} ${round(y - high)} ${round(x + 2 * half)} ${round(y - high)} ${round(x + half)} ${round(at - END_PX)}`;
}

const round = (value: number) => Math.round(value * 10) / 10;
