import type { Role } from "../state/cells";
import type { Selection } from "../state/selection";
import type { Ordered } from "./order";
import { drawGaps, MARGIN } from "./pen";
import { type Band, layBands, lineOf, rowAt, type Sight } from "./raster";
import { heardOf } from "./spikeStore";
import type { TimeScale } from "./timeAxis";
import type { Pen, Sheet } from "./useCanvas";

/** Room for the names of events above the first row. */
export const TOP = 16;

/** A band in the picture of the spikes. */
export interface Row extends Ordered {
  /** The roles of all cells of the population. */
  roles: readonly Role[];
  band: Band;
  /** The heights in CSS pixels between which it is in sight. */
  top: number;
  bottom: number;
}

/** The bands that are in sight; `height` in device pixels. */
export function layRows(
  bands: readonly Ordered[],
  rolesOf: (population: string) => readonly Role[],
  height: number,
  ratio: number,
  sight: Sight,
): Row[] {
  const sizes = bands.map(({ cells }) => cells.length);
  return layBands(sizes, height, sight).flatMap((band, at) => {
    const ordered = bands[at];
    const [top, bottom] = [Math.max(0, band.top), Math.min(height, band.top + band.height)];
    if (!ordered || bottom <= top) return [];
    const roles = rolesOf(ordered.population.label);
    return [{ ...ordered, roles, band, top: TOP + top / ratio, bottom: TOP + bottom / ratio }];
  });
}

/** What is shown at a height, in CSS pixels: a neuron where each has a line of its own, else its group or population. */
export function shownAt(rows: readonly Row[], y: number, ratio: number, single: boolean): Selection | null {
  const row = rows.find(({ top, bottom }) => y >= top && y < bottom);
  if (!row) return null;
  const { band, cells, group } = row;
  const { label } = row.population;
  if (single && band.pitch >= 1) {
    const index = cells[rowAt(band, (y - TOP) * ratio - band.top)] ?? 0;
    return { kind: "neuron", population: label, index };
  }
  return group === null ? { kind: "population", label } : { kind: "group", name: group };
}

const LABEL_PX = 11;
/** Names are at least this far apart, and of a font as small where bands are many; between them low bands have none. */
const NAME_PX = 10;
const MANY = 8;
/** The room of a name alone. */
const NAMES_PX = MARGIN.left - 12;
/** The minimum width of a name beside numbers. */
const LEAST_NAME_PX = 28;

/** Names bands and, where `numbered` and their lines are high enough, neurons by the brain's own numbers. */
export function drawNames({ pen, colours, ratio }: Sheet, rows: readonly Row[], numbered: boolean): void {
  pen.textBaseline = "middle";
  pen.fillStyle = colours.text2;
  if (rows.length > MANY) pen.font = colours.font.replace(/^\d+px/, `${NAME_PX}px`);
  let free = 0;
  for (const row of rows) {
    const pitch = row.band.pitch / ratio;
    const isNumbered = numbered && pitch >= LABEL_PX;
    const room = NAMES_PX - (isNumbered ? digitsPx(pen, row) : 0);
    const isNarrow = isTight(pen, row, room);
    free = drawName(pen, row, isNumbered ? pitch : LABEL_PX, isNarrow ? NAMES_PX : room, free);
    if (isNumbered) drawNumbers(pen, row, TOP + row.band.top / ratio, pitch, Number(isNarrow));
  }
}

/** Whether the name takes the place of the first number: that of a band of one cell is not cut for it. */
const isTight = (pen: Pen, { cells, label }: Row, room: number): boolean =>
  room < LEAST_NAME_PX || (cells.length === 1 && pen.measureText(label).width > room);

/** Names a band at its first line, or lower if that is not free, and returns the height at which the next may stand. */
function drawName(pen: Pen, { label, top, bottom }: Row, line: number, room: number, free: number): number {
  const y = Math.max(free, top + Math.min(line, bottom - top) / 2);
  if (y > bottom) return free;
  pen.textAlign = "left";
  pen.fillText(shortened(pen, label, room), 8, y);
  return y + NAME_PX;
}

/** The width of the number of any cell of a band. */
const digitsPx = (pen: Pen, { population, cells }: Row): number =>
  pen.measureText(String(population.first + (cells.at(-1) ?? 0))).width + 6;

/** Numbers the cells in sight but the first ones, where a name stands; the first one begins at a height. */
function drawNumbers(pen: Pen, row: Row, begin: number, pitch: number, skipped: number): void {
  const { cells, population, top, bottom } = row;
  pen.textAlign = "right";
  const first = Math.max(0, Math.ceil((top - begin) / pitch - 0.4)) + skipped;
  const end = Math.min(cells.length, Math.ceil((bottom - begin) / pitch - 0.5));
  for (let at = first; at < end; at++) {
    const number = String(population.first + (cells[at] ?? 0));
    pen.fillText(number, MARGIN.left - 6, begin + (at + 0.5) * pitch);
  }
}

/** As much of a text as fits into a width, with both ends: names often differ in the last letters. */
function shortened(pen: Pen, text: string, width: number): string {
  if (pen.measureText(text).width <= width) return text;
  for (let length = text.length - 1; length > 1; length--) {
    const front = Math.ceil(length / 2);
    const short = `${text.slice(0, front)}…${text.slice(text.length - (length - front))}`;
    if (pen.measureText(short).width <= width) return short;
  }
  return text.slice(0, 1);
}

/** A line above each band that follows another one. */
export function drawBorders({ pen, colours }: Sheet, scale: TimeScale, rows: readonly Row[]): void {
  pen.fillStyle = colours.line;
  for (const { top } of rows.slice(1)) pen.fillRect(8, Math.round(top) - 1, scale.right - 8, 1);
}

/** Puts a soft ground behind the selected population, group or neuron. */
export function drawSelected(
  { pen, colours, ratio }: Sheet,
  scale: TimeScale,
  row: Row,
  selected: Selection,
): void {
  const { band, population, group, cells, top, bottom } = row;
  pen.fillStyle = colours.accentSoft;
  const all =
    (selected.kind === "population" && selected.label === population.label) ||
    (selected.kind === "group" && selected.name === group);
  if (all) pen.fillRect(0, top, scale.right, bottom - top);
  if (selected.kind !== "neuron" || selected.population !== population.label) return;
  const at = cells.indexOf(selected.index);
  const begin = TOP + (band.top + lineOf(band, at)) / ratio;
  const [from, to] = [Math.max(top, begin), Math.min(bottom, begin + Math.max(band.pitch, 2) / ratio)];
  if (at >= 0 && to > from) pen.fillRect(0, from, scale.right, to - from);
}

/** Tells where the page did not listen, so that no one takes it for silence. */
export function drawUnheard(sheet: Sheet, scale: TimeScale, row: Row, now_s: number): void {
  const gaps = heardOf(row.population.label).gaps(Math.max(0, scale.from_s), Math.min(scale.to_s, now_s));
  drawGaps(sheet, scale, gaps, row.top, row.bottom);
}
