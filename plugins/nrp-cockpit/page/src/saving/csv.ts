import type { TimeRing } from "../plots/timeRing";

/** Some values of a quantity by time. */
export interface Column {
  name: string;
  values: TimeRing;
}

/** A field as RFC 4180 has it. */
const field = (text: string): string => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

const lines = (rows: readonly (readonly string[])[]): string =>
  rows.map((row) => `${row.map(field).join(",")}\r\n`).join("");

/** Nanoseconds are exact in it, and no digits of rounding follow them. */
const time = (t_s: number): string => String(Number(t_s.toFixed(9)));

/** Curves as a table with a line for each time; a field is empty where its curve has no value at that time. */
export function curvesCsv(columns: readonly Column[]): string {
  const rows = new Map<string, string[]>();
  columns.forEach(({ values }, at) => {
    values.visit(Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY, (t_s, value) => {
      const row = rows.get(time(t_s)) ?? new Array<string>(columns.length).fill("");
      row[at] = String(value);
      rows.set(time(t_s), row);
    });
  });
  const sorted = [...rows].sort(([a], [b]) => Number(a) - Number(b));
  return lines([["t_s", ...columns.map(({ name }) => name)], ...sorted.map(([t_s, row]) => [t_s, ...row])]);
}

/** Spikes as a table in the order of time: a line for each, with its population and the number of its cell there. */
export function spikesCsv(columns: readonly Column[]): string {
  const rows: [number, string, number][] = [];
  for (const { name, values } of columns)
    values.visit(Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY, (t_s, cell) => {
      rows.push([t_s, name, cell]);
    });
  rows.sort(([a], [b]) => a - b);
  return lines([
    ["t_s", "population", "cell"],
    ...rows.map(([t_s, name, cell]) => [time(t_s), name, String(cell)]),
  ]);
}
