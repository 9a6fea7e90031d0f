import type { Group } from "./store";

export type Cell = string | number | boolean | null;

/** A number with at most six digits that say something; a dash for what a run does not have. */
export function shown(cell: Cell): string {
  if (cell === null || cell === "") return "–";
  if (typeof cell === "boolean") return cell ? "yes" : "no";
  return typeof cell === "number" ? short(cell) : cell;
}

function short(value: number): string {
  const size = Math.abs(value);
  const rounded = Number(value.toPrecision(6));
  return size !== 0 && size < 1e-3 ? rounded.toExponential() : String(rounded);
}

/** The mean of a measure and its standard deviation over the runs of a group. */
export function meanOf({ measured }: Group, name: string): string {
  const { mean, sd, n } = measured[name] ?? { mean: null, sd: null, n: 0 };
  if (mean === null || n === 0) return "–";
  const middle = Number(mean.toPrecision(4));
  return sd ? `${middle} ± ${Number(sd.toPrecision(2))}` : String(middle);
}

const PLAIN = /^[\w@%+=:,./-]+$/;

/** The words of a command as a shell reads them. */
export const inShell = (words: readonly string[]): string =>
  words.map((word) => (PLAIN.test(word) ? word : `'${word.replaceAll("'", `'\\''`)}'`)).join(" ");
