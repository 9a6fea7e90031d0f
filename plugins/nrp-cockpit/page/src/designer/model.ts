import type { Box, Feature, Held, NodeData, PlacedFinding } from "./types";

const isNode = (held: Held | undefined): held is NodeData =>
  typeof held === "object" && held !== null && !Array.isArray(held);

/** The part at a path of the server, such as `transfer_function/0/device/1`; undefined where there is none. */
export function partAt(model: NodeData, path: string): NodeData | undefined {
  let found: Held | undefined = model;
  for (const step of path === "" ? [] : path.split("/")) {
    if (Array.isArray(found)) found = found[Number(step)];
    else if (isNode(found)) found = found.fields[step];
    else return undefined;
  }
  return isNode(found) ? found : undefined;
}

/** The transfer function that a path leads into; empty where it leads into none. */
export function functionOf(path: string): string {
  const steps = path.split("/");
  return steps[0] === "transfer_function" && steps.length > 1 ? steps.slice(0, 2).join("/") : "";
}

/** What is shown when the form of a part is closed: what it is inside of. */
export function ownerOf(path: string): string {
  const [list, at, ...deeper] = path.split("/");
  return deeper.length > 0 ? `${list}/${at}` : "";
}

/** Whether something selected can be copied and removed as a whole: an item of a list. */
export const isItem = (path: string): boolean =>
  /^(transfer_function|population|projection|intervention)\//.test(path);

/** What a part is called: its name, or its kind; of an intervention its kind and its cells. */
export function titleOf(part: NodeData): string {
  const { name, src, ref, effect } = part.fields;
  if (isNode(effect)) {
    const { cells, sources, targets } = effect.fields;
    return [effect.type.toLowerCase(), cells, sources, targets && `to ${targets}`].filter(Boolean).join(" ");
  }
  for (const held of [name, src, ref]) if (typeof held === "string") return held;
  return part.text || part.type;
}

/** The first and the last line of a part in its text: all that is indented deeper, and its end. */
export function linesOf(text: string, part: NodeData): [number, number] {
  const lines = text.split("\n");
  const indent = (line: string) => line.length - line.trimStart().length;
  const first = lines[part.line - 1] ?? "";
  let last = part.line;
  while (last < lines.length && indent(lines[last] ?? "") > indent(first)) last++;
  if (/^(<\/|\))/.test((lines[last] ?? "").trim()) && indent(lines[last] ?? "") === indent(first)) last++;
  return [part.line, Math.max(last, part.line)];
}

const WEIGHTS = ["error", "warning", "note"] as const;

/** The findings of a box, the worst first. */
export const findingsAt = (findings: readonly PlacedFinding[], box: Box): PlacedFinding[] =>
  findings
    .filter((finding) => finding.box === box.id)
    .toSorted((a, b) => WEIGHTS.indexOf(a.weight) - WEIGHTS.indexOf(b.weight));

/** What a form calls a feature: its name in XML, in words. */
export const labelOf = ({ name }: Feature): string =>
  name.replaceAll(/(?<=[a-z])[A-Z]/g, (letter) => ` ${letter.toLowerCase()}`);
