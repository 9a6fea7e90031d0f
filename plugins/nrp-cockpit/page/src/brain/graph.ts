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
const NAME_GAP = 10;
const TOP = 14;
const BOX = { rx: 60, ry: 20 };

/** Lays the graph out in a rectangle. */
export function layGraph(
  parts: readonly Part[],
  links: readonly Link[],
  width: number,
  height: number,
): Graph {
  const columns = columnsOf(parts, links);
  const most = Math.max(1, ...columns.map(({ length }) => length));
  const radius = Math.max(6, Math.min(14, (height - 2 * TOP) / most / 2 - 4));
  const boxed = parts.some(({ index }) => index === null);
  const longest = Math.min(
    LETTERS,
    Math.max(0, ...parts.map(({ index, name }) => (index === null ? 0 : name.length))),
  );
  const names = Math.min(longest * LETTER_PX, 0.24 * width);
  const margin = Math.max(radius + NAME_GAP + names, boxed ? BOX.rx + 16 : 0);
  const letters = Math.floor(names / LETTER_PX);
  const nodes = columns.flatMap((column, at) => {
    const x = columns.length === 1 ? width / 2 : margin + (at / (columns.length - 1)) * (width - 2 * margin);
    const side = at === 0 ? "left" : at === columns.length - 1 ? "right" : "above";
    const pitch = (height - 2 * TOP) / column.length;
    return column.map((part, row): Placed => {
      const size =
        part.index === null
          ? { rx: BOX.rx, ry: Math.min(BOX.ry, pitch / 2 - 2) }
          : { rx: radius, ry: radius };
      return { part, x, y: TOP + (row + 0.5) * pitch, ...size, side, letters };
    });
  });
  return { nodes, lines: linesOf(links, nodes) };
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
