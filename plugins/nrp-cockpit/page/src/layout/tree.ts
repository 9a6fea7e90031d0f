/** Where the panels stand: nested rows and columns whose parts have relative sizes. */

import type { Kind, PanelId } from "../state/panels";

export interface Split {
  direction: "row" | "column";
  parts: readonly Node[];
  /** One for each part; only their ratios count. */
  sizes: readonly number[];
}

export type Node = PanelId | Split;

/** A way from the root to a node: the index of the part at each level. */
export type Path = readonly number[];

export type Side = "left" | "right" | "above" | "below";

export const defaultTree: Split = {
  direction: "row",
  sizes: [632, 456, 256],
  parts: [
    {
      direction: "column",
      sizes: [1.6, 1],
      parts: ["scene", { direction: "row", sizes: [1.12, 1], parts: ["camera", "map"] }],
    },
    { direction: "column", sizes: [1, 1, 1], parts: ["brain", "spikes", "traces"] },
    "inspector",
  ],
};

/** The panels from left to right and from top to bottom. */
export const panelsOf = (node: Node): PanelId[] =>
  typeof node === "string" ? [node] : node.parts.flatMap(panelsOf);

/** The first name of a panel of this kind that the tree does not have. */
export function freeId(tree: Split, kind: Kind): PanelId {
  const taken = new Set(panelsOf(tree));
  let id: PanelId = kind;
  for (let number = 2; taken.has(id); number++) id = `${kind} ${number}`;
  return id;
}

/** The tree with another panel in the place of one. */
export const replace = (tree: Split, id: PanelId, by: PanelId): Split =>
  rename(tree, (one) => (one === id ? by : one));

/** The tree with two panels in each other's place. */
export const swapPanels = (tree: Split, a: PanelId, b: PanelId): Split =>
  rename(tree, (one) => (one === a ? b : one === b ? a : one));

const rename = (tree: Split, name: (id: PanelId) => PanelId): Split => ({
  ...tree,
  parts: tree.parts.map((part) => (typeof part === "string" ? name(part) : rename(part, name))),
});

/** The tree with a panel on one side of another, each with half of its room. */
export function putBeside(tree: Split, id: PanelId, side: Side, added: PanelId): Split {
  const at = tree.parts.indexOf(id);
  if (at < 0) {
    const parts = tree.parts.map((part) =>
      typeof part === "string" ? part : putBeside(part, id, side, added),
    );
    return { ...tree, parts };
  }
  const direction = side === "left" || side === "right" ? "row" : "column";
  const before = side === "left" || side === "above";
  const pair = before ? [added, id] : [id, added];
  if (direction !== tree.direction)
    return { ...tree, parts: tree.parts.with(at, { direction, parts: pair, sizes: [1, 1] }) };
  const half = (tree.sizes[at] ?? 1) / 2;
  return {
    ...tree,
    parts: tree.parts.toSpliced(at, 1, ...pair),
    sizes: tree.sizes.toSpliced(at, 1, half, half),
  };
}

/** The tree with a panel at its end, with as much room as the others have on average. */
export const append = (tree: Split, added: PanelId): Split => ({
  ...tree,
  parts: [...tree.parts, added],
  sizes: [...tree.sizes, tree.sizes.reduce((sum, size) => sum + size, 0) / tree.sizes.length],
});

/** The tree without a panel, whose neighbours take its room. */
export function without(tree: Split, id: PanelId): Split {
  const parts: Node[] = [];
  const sizes: number[] = [];
  tree.parts.forEach((part, at) => {
    const kept = typeof part === "string" ? part : without(part, id);
    if (kept === id || (typeof kept !== "string" && kept.parts.length === 0)) return;
    const [only, second] = typeof kept === "string" ? [] : kept.parts;
    parts.push(only !== undefined && second === undefined ? only : kept);
    sizes.push(tree.sizes[at] ?? 1);
  });
  return { ...tree, parts, sizes };
}

/** The smallest share of two neighbours' common room that one may keep. */
const SMALLEST = 0.1;

/**
 * The tree after the border between two parts of the split at `path` moved by `share` of their common room. They may
 * have parts between them that are not shown.
 */
export function moveBorder(
  tree: Split,
  path: Path,
  [first, second]: readonly [number, number],
  share: number,
): Split {
  const [step, ...rest] = path;
  if (step !== undefined) {
    const part = tree.parts[step];
    if (part === undefined || typeof part === "string") return tree;
    return { ...tree, parts: tree.parts.with(step, moveBorder(part, rest, [first, second], share)) };
  }
  const before = tree.sizes[first] ?? 1;
  const both = before + (tree.sizes[second] ?? 1);
  const now = Math.min(Math.max(before + share * both, SMALLEST * both), (1 - SMALLEST) * both);
  return { ...tree, sizes: tree.sizes.with(first, now).with(second, both - now) };
}
