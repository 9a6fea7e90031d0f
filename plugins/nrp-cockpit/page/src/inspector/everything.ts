import { cellName } from "../state/cells";
import { sizeOf } from "../state/grouping";
import type { Selection } from "../state/selection";
import type { Experiment, Projection } from "../state/types";

/** A line of the outline, and those below it. */
export interface Branch {
  name: string;
  note?: string;
  to: Selection;
  parts?: Branch[];
  /** Branches that are shown after a click, because there are many of a kind. */
  folded?: Branch[];
}

type Brain = Pick<Experiment, "populations" | "projections" | "devices">;

/** The bodies; those that move come first. */
export function bodiesOf({ bodies }: Pick<Experiment, "bodies">): Branch[] {
  return [...bodies]
    .sort((a, b) => Number(a.static) - Number(b.static))
    .map(({ name, static: fixed }) => ({
      name,
      note: fixed ? "fixed" : "moves",
      to: { kind: "body", name },
    }));
}

/** The named groups of cells, with their sizes. */
export const groupsOf = ({ groups }: Pick<Experiment, "groups">): Branch[] =>
  groups.map((group) => ({
    name: group.name,
    note: `${sizeOf(group)}`,
    to: { kind: "group", name: group.name },
  }));

/** More projections than these to the same cells are folded. */
const MOST_ALIKE = 4;

/** The populations, each with the projections that leave it; several to the same cells are told apart. */
export function populationsOf(brain: Brain): Branch[] {
  return brain.populations.map(({ label, size }) => ({
    name: label,
    note: `${size}`,
    to: { kind: "population", label },
    parts: targetsOf(
      brain.projections.filter(({ pre }) => pre === label),
      brain,
    ),
  }));
}

/** Projections of a population, those to the same cells as one line where they are many. */
function targetsOf(projections: readonly Projection[], brain: Brain): Branch[] {
  const byTarget = new Map<string, Projection[]>();
  for (const projection of projections) {
    const target = `${signOf(projection)} ${projection.post}`;
    byTarget.set(target, [...(byTarget.get(target) ?? []), projection]);
  }
  return [...byTarget].flatMap(([name, alike]) => {
    const lines = alike.map(
      (projection): Branch => ({
        name: nameOf(projection, brain),
        note: projection.excites ? "excites" : "inhibits",
        to: { kind: "projection", id: projection.id },
      }),
    );
    const [first] = alike;
    if (!first || lines.length <= MOST_ALIKE) return lines;
    const note = `${lines.length} projections`;
    return [{ name, note, to: { kind: "population", label: first.post } as const, folded: lines }];
  });
}

const signOf = ({ excites }: Pick<Projection, "excites">) => (excites ? "→" : "⊣");

/**
 * A projection by its target. Of several alike by the cells of the robot at its ends, if it has one at each, else by its
 * own name, or by a number where PyNN made that name of both ends.
 */
function nameOf(projection: Projection, brain: Brain): string {
  const { pre, post, excites, label } = projection;
  const sign = signOf(projection);
  const alike = brain.projections.filter(
    (one) => one.pre === pre && one.post === post && one.excites === excites,
  );
  if (alike.length === 1) return `${sign} ${post}`;
  const [from, to] = [cellsAt(projection, 0, brain), cellsAt(projection, 1, brain)];
  if (from && to) return `${from} ${sign} ${to}`;
  return `${sign} ${label.includes("→") ? `${post} (${alike.indexOf(projection) + 1})` : label}`;
}

/** The one name that all cells at an end of a projection have; else empty. */
function cellsAt({ pre, post, edges }: Projection, end: 0 | 1, { populations, devices }: Brain): string {
  const first = populations.find(({ label }) => label === (end === 0 ? pre : post))?.first ?? 0;
  const names = new Set(edges?.map((edge) => cellName(first + edge[end], devices)));
  return names.size === 1 ? ([...names][0] ?? "") : "";
}
