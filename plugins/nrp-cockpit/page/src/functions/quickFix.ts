import type { Text } from "@codemirror/state";
import type { Finding } from "../state/types";

/** One change of a text. */
export interface Edit {
  changes: { from: number; to: number; insert: string };
}

const escaped = (name: string) => name.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** The name as a whole: `rate` is not in `rates`, and `/odom` is not in `/odom/x`. */
const whole = (name: string) => new RegExp(`(?<![\\w/])${escaped(name)}(?![\\w/])`, "g");

/** What puts the name that was probably meant in the place of the one that nothing has; null: there is no such fix. */
export function editOf({ instead, line, column }: Finding, doc: Text): Edit | null {
  if (!instead || line === null || line < 1 || line > doc.lines) return null;
  const { from, text } = doc.line(line);
  const places = [...text.matchAll(whole(instead.written))].map(({ index }) => index);
  const place = places.find((index) => index >= (column ?? 1) - 1) ?? places[0];
  if (place === undefined) return null;
  const start = from + place;
  return { changes: { from: start, to: start + instead.written.length, insert: instead.meant } };
}

/** The part of a text to replace so that it becomes another one: what both begin and end with stays. */
export function difference(before: string, after: string): Edit["changes"] {
  const most = Math.min(before.length, after.length);
  let from = 0;
  while (from < most && before[from] === after[from]) from++;
  let end = 0;
  while (end < most - from && before.at(-1 - end) === after.at(-1 - end)) end++;
  return { from, to: before.length - end, insert: after.slice(from, after.length - end) };
}
