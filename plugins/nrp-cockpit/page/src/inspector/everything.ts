import { sizeOf } from "../state/grouping";
import type { Selection } from "../state/selection";
import type { Experiment, Projection } from "../state/types";

/** A line of the outline, and those below it. */
export interface Branch {
  name: string;
  note?: string;
  to: Selection;
  parts?: Branch[];
}

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

/** The populations, each with the projections that leave it; several to the same cells are told apart. */
export function populationsOf({
  populations,
  projections,
}: Pick<Experiment, "populations" | "projections">): Branch[] {
  return populations.map(({ label, size }) => ({
    name: label,
    note: `${size}`,
    to: { kind: "population", label },
    parts: projections
      .filter(({ pre }) => pre === label)
      .map((projection) => ({
        name: `${projection.excites ? "→" : "⊣"} ${endOf(projection, projections)}`,
        note: projection.excites ? "excites" : "inhibits",
        to: { kind: "projection", id: projection.id },
      })),
  }));
}

/** Where a projection ends; of several alike its own name, or a number where PyNN made that name of both ends. */
function endOf(projection: Projection, all: readonly Projection[]): string {
  const { pre, post, excites, label } = projection;
  const alike = all.filter((one) => one.pre === pre && one.post === post && one.excites === excites);
  if (alike.length === 1) return post;
  return label.includes("→") ? `${post} (${alike.indexOf(projection) + 1})` : label;
}
