import { columnsOf } from "./columns";
import type { Link, Part } from "./nodes";

/** A part with its place, in pixels. */
export interface Placed {
  part: Part;
  x: number;
  y: number;
  /** Half the width and height of a population's box; of a neuron both are its radius. */
  rx: number;
  ry: number;
  /** Where its name stands, and how many letters have room there. */
  side: "left" | "right" | "above";
  letters: number;
  /** Whether its rate stands behind its name, for want of height. */
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
const NAME_GAP = 10;
/** The room of a rate behind a name, and the height that a name needs to have its rate below it. */
const RATE_PX = 44;
const TWO_LINES_PX = 28;
const TOP = 14;
const BOX = { rx: 60, ry: 20 };
/** How far apart the parts of a column are at least. */
const LEAST_PX = { neuron: 14, box: 36 };

/** What depends on the room that there is. */
interface Fit {
  radius: number;
  margin: number;
  letters: number;
  tight: boolean;
}

/** Lays the graph out in a rectangle. */
export function layGraph(
  parts: readonly Part[],
  links: readonly Link[],
  width: number,
  height: number,
): Graph {
  const room = height - 2 * TOP;
  const columns = columnsOf(parts, links).flatMap((column) => wrapped(column, room));
  const fit = fitOf(parts, width, room / Math.max(1, ...columns.map(({ length }) => length)));
  const step = (width - 2 * fit.margin) / Math.max(1, columns.length - 1);
  const nodes = columns.flatMap((column, at) => {
    const x = columns.length === 1 ? width / 2 : fit.margin + at * step;
    const side = at === 0 ? "left" : at === columns.length - 1 ? "right" : "above";
    const pitch = room / column.length;
    return column.map((part, row): Placed => {
      const box = { rx: BOX.rx, ry: Math.min(BOX.ry, pitch / 2 - 2) };
      const size = part.index === null ? box : { rx: fit.radius, ry: fit.radius };
      return { part, x, y: TOP + (row + 0.5) * pitch, ...size, side, letters: fit.letters, tight: fit.tight };
    });
  });
  return { nodes, lines: linesOf(links, nodes) };
}

/** A column that is too high for its room as several, side by side. */
function wrapped(column: readonly Part[], room: number): Part[][] {
  const least = column.some(({ index }) => index === null) ? LEAST_PX.box : LEAST_PX.neuron;
  const rows = Math.max(1, Math.floor(room / least));
  const count = Math.ceil(column.length / rows);
  const each = Math.ceil(column.length / count);
  return Array.from({ length: count }, (_, at) => column.slice(at * each, (at + 1) * each));
}

function fitOf(parts: readonly Part[], width: number, pitch: number): Fit {
  const boxed = parts.some(({ index }) => index === null);
  const names = parts.map(({ index, name }) => (index === null ? 0 : Math.max(name.length, DIGITS)));
  const tight = pitch < TWO_LINES_PX;
  const rate = tight ? RATE_PX : 0;
  const words = Math.min(Math.min(Math.max(0, ...names), LETTERS) * LETTER_PX + rate, 0.28 * width);
  const radius = Math.max(6, Math.min(14, pitch / 2 - 4));
  const margin = Math.max(radius + NAME_GAP + words, boxed ? BOX.rx + 16 : 0);
  return { radius, margin, letters: Math.floor((words - rate) / LETTER_PX), tight };
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
  const out =
    part.index === null ? Math.min(rx / Math.abs(dx || 1e-9), ry / Math.abs(dy || 1e-9)) * length : rx;
  return [x + (dx / length) * (out + gap), y + (dy / length) * (out + gap)];
}

/** A loop above a node that projects to itself. */
function loopOf({ x, y, rx, ry }: Placed): string {
  const [half, high] = [Math.min(rx, 12) * 0.7, ry + 14];
  const at = y - ry - 1;
  return `M${round(x - half)} ${round(at)}C${round(x - 2 * half)} ${round(y - high)} ${round(x + 2 * half)} ${round(y - high)} ${round(x + half)} ${round(at - END_PX)}`;
}

const round = (value: number) => Math.round(value * 10) / 10;
