/** Where the panels stand: nested rows and columns whose parts have relative sizes. */

export const PANELS = ["scene", "camera", "map", "brain", "spikes", "traces", "inspector"] as const;
export type PanelId = (typeof PANELS)[number];

export interface Split {
  direction: "row" | "column";
  parts: readonly Node[];
  /** One for each part; only their ratios count. */
  sizes: readonly number[];
}

export type Node = PanelId | Split;

/** A way from the root to a node: the index of the part at each level. */
export type Path = readonly number[];

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

/** The smallest share of two neighbours' common room that one may keep. */
const SMALLEST = 0.1;

/** The tree after the border behind part `index` of the split at `path` moved by `share` of both neighbours' room. */
export function moveBorder(tree: Node, path: Path, index: number, share: number): Node {
  if (typeof tree === "string") return tree;
  const [first, ...rest] = path;
  if (first !== undefined) {
    return {
      ...tree,
      parts: tree.parts.map((part, at) => (at === first ? moveBorder(part, rest, index, share) : part)),
    };
  }
  const before = tree.sizes[index] ?? 1;
  const both = before + (tree.sizes[index + 1] ?? 1);
  const now = Math.min(Math.max(before + share * both, SMALLEST * both), (1 - SMALLEST) * both);
  return {
    ...tree,
    sizes: tree.sizes.map((size, at) => (at === index ? now : at === index + 1 ? both - now : size)),
  };
}

/** The tree with two panels in each other's place. */
export function swapPanels(tree: Node, a: PanelId, b: PanelId): Node {
  if (typeof tree === "string") return tree === a ? b : tree === b ? a : tree;
  return { ...tree, parts: tree.parts.map((part) => swapPanels(part, a, b)) };
}
