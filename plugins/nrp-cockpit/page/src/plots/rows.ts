import type { Role } from "../brain/cells";
import type { Selection } from "../state/selection";
import type { Population } from "../state/types";
import { drawGaps, MARGIN } from "./pen";
import { type Band, lineOf } from "./raster";
import { heardOf } from "./spikeStore";
import type { TimeScale } from "./timeAxis";
import type { Sheet } from "./useCanvas";

/** Room for the names of events above the first row. */
export const TOP = 16;

/** A population in the picture of the spikes. */
export interface Row {
  population: Population;
  roles: readonly Role[];
  band: Band;
}

/** The place of a row in CSS pixels. */
export const topOf = ({ band }: Row, ratio: number): number => TOP + band.top / ratio;
export const bottomOf = ({ band }: Row, ratio: number): number => TOP + (band.top + band.height) / ratio;

const LABEL_PX = 11;

/** Names populations and, where `numbered` and their lines are high enough, neurons by the brain's own numbers. */
export function drawNames({ pen, colours, ratio }: Sheet, rows: readonly Row[], numbered: boolean): void {
  pen.textBaseline = "middle";
  pen.fillStyle = colours.text2;
  for (const row of rows) {
    const { band, population } = row;
    const pitch = band.pitch / ratio;
    const numbers = numbered && pitch >= LABEL_PX;
    const top = topOf(row, ratio);
    pen.textAlign = "left";
    const room = MARGIN.left - (numbers ? 24 : 12);
    pen.fillText(shortened(pen, population.label, room), 8, top + (numbers ? pitch : LABEL_PX) / 2);
    pen.textAlign = "right";
    for (let cell = 0; numbers && cell < population.size; cell++)
      pen.fillText(String(population.first + cell), MARGIN.left - 6, top + (cell + 0.5) * pitch);
  }
}

/** As much of a text as fits into a width. */
function shortened(pen: CanvasRenderingContext2D, text: string, width: number): string {
  if (pen.measureText(text).width <= width) return text;
  let length = text.length - 1;
  while (length > 1 && pen.measureText(`${text.slice(0, length)}…`).width > width) length--;
  return `${text.slice(0, length)}…`;
}

/** Puts a soft ground behind the selected population or neuron. */
export function drawSelected(
  { pen, colours, ratio }: Sheet,
  scale: TimeScale,
  row: Row,
  selected: Selection,
): void {
  const { band, population } = row;
  pen.fillStyle = colours.accentSoft;
  if (selected.kind === "population" && selected.label === population.label)
    pen.fillRect(0, topOf(row, ratio), scale.right, band.height / ratio);
  if (selected.kind === "neuron" && selected.population === population.label) {
    const top = topOf(row, ratio) + lineOf(band, selected.index) / ratio;
    pen.fillRect(0, top, scale.right, Math.max(band.pitch, 2) / ratio);
  }
}

/** Tells where the page did not listen, so that no one takes it for silence. */
export function drawUnheard(sheet: Sheet, scale: TimeScale, row: Row, now_s: number): void {
  const gaps = heardOf(row.population.label).gaps(Math.max(0, scale.from_s), Math.min(scale.to_s, now_s));
  drawGaps(sheet, scale, gaps, topOf(row, sheet.ratio), bottomOf(row, sheet.ratio));
}
