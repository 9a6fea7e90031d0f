import type { TimeRing } from "../plots/timeRing";

/** Some values of a quantity by time. */
export interface Column {
  name: string;
  values: TimeRing;
}

/** A field as RFC 4180 has it. */
const field = (text: string): string => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** So many lines become one text: a file may be longer than a text can be. */
const LINES = 4096;

/** A table with its head, in texts that follow each other. */
function table(head: readonly string[], rows: Iterable<readonly string[]>): string[] {
  const texts: string[] = [];
  let lines = [line(head)];
  for (const row of rows) {
    if (lines.length === LINES) {
      texts.push(lines.join(""));
      lines = [];
    }
    lines.push(line(row));
  }
  return [...texts, lines.join("")];
}

const line = (row: readonly string[]): string => `${row.map(field).join(",")}\r\n`;

/** Nanoseconds are exact in it, and no digits of rounding follow them. */
const time = (t_s: number): string => String(Number(t_s.toFixed(9)));

/** Times closer than half a nanosecond are one time. */
const SAME_S = 5e-10;

/** The columns whose next number is the earliest, and its time; of columns in the order of time. */
function earliest(columns: readonly Column[], next: readonly number[]): { t_s: number; at: number[] } {
  let [t_s, at] = [Number.POSITIVE_INFINITY, [] as number[]];
  columns.forEach(({ values }, column) => {
    const index = next[column] as number;
    if (index >= values.length) return;
    const own_s = values.timeAt(index);
    if (Math.abs(own_s - t_s) < SAME_S) at.push(column);
    else if (own_s < t_s) [t_s, at] = [own_s, [column]];
  });
  return { t_s, at };
}

function* merged(columns: readonly Column[]): Generator<{ t_s: number; at: number[]; next: number[] }> {
  const next = columns.map(() => 0);
  for (;;) {
    const { t_s, at } = earliest(columns, next);
    if (at.length === 0) return;
    yield { t_s, at, next };
    for (const column of at) next[column] = (next[column] as number) + 1;
  }
}

/** Curves as a table with a line for each time; a field is empty where its curve has no value at that time. */
export function curvesCsv(columns: readonly Column[]): string[] {
  function* rows() {
    for (const { t_s, at, next } of merged(columns)) {
      const row = columns.map(({ values }, column) =>
        at.includes(column) ? String(values.valueAt(next[column] as number)) : "",
      );
      yield [time(t_s), ...row];
    }
  }
  return table(["t_s", ...columns.map(({ name }) => name)], rows());
}

/** Spikes as a table in the order of time: a line for each, with its population and the number of its cell there. */
export function spikesCsv(columns: readonly Column[]): string[] {
  function* rows() {
    for (const { t_s, at, next } of merged(columns))
      for (const column of at) {
        const { name, values } = columns[column] as Column;
        yield [time(t_s), name, String(values.valueAt(next[column] as number))];
      }
  }
  return table(["t_s", "population", "cell"], rows());
}
