import { sizeOf } from "../brain/grouping";
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

/** The populations, each with the projections that leave it; several to the same cells have their own names. */
export function populationsOf({
  populations,
  projections,
}: Pick<Experiment, "populations" | "projections">): Branch[] {
  const isOnly = ({ pre, post, excites }: Projection) =>
    projections.filter((one) => one.pre === pre && one.post === post && one.excites === excites).length === 1;
  return populations.map(({ label, size }) => ({
    name: label,
    note: `${size}`,
    to: { kind: "population", label },
    parts: projections
      .filter(({ pre }) => pre === label)
      .map((projection) => ({
        name: `${projection.excites ? "→" : "⊣"} ${isOnly(projection) ? projection.post : projection.label}`,
        note: projection.excites ? "excites" : "inhibits",
        to: { kind: "projection", id: projection.id },
      })),
  }));
}
