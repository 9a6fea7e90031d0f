import type { Projection } from "../state/types";
import type { Connections } from "./connections";
import type { Link, Part } from "./nodes";

/**
 * The lines between parts; where a projection does not name its synapses, those between groups that are known, or each
 * part of one end meets each of the other.
 */
export function linksOf(
  projections: readonly Projection[],
  parts: readonly Part[],
  connections: Connections | null = null,
): Link[] {
  return strongest(
    projections.flatMap((projection) => {
      const links = new Map<string, Link>();
      for (const [from, to, weight] of pairsOf(projection, parts, connections)) {
        const id = `${projection.id}: ${from.id} > ${to.id}`;
        const known = links.get(id)?.weight ?? 0;
        links.set(id, { id, projection, from, to, weight: weight && Math.max(Math.abs(weight), known) });
      }
      return [...links.values()];
    }),
  );
}

function pairsOf(
  projection: Projection,
  parts: readonly Part[],
  connections: Connections | null,
): [Part, Part, number | null][] {
  const [pre, post] = [projection.pre, projection.post].map((label) =>
    parts.filter(({ population }) => population.label === label),
  ) as [Part[], Part[]];
  if (projection.edges !== null)
    return projection.edges.flatMap(([a, b, weight]) => {
      const [from, to] = [partAt(pre, a), partAt(post, b)];
      return from && to ? [[from, to, weight] as [Part, Part, number]] : [];
    });
  if (isGrouped(pre) || isGrouped(post)) return connections?.pairs(projection.id, pre, post) ?? [];
  return pre.flatMap((from) => post.map((to) => [from, to, null] as [Part, Part, null]));
}

const isGrouped = ([first, second]: readonly Part[]) => first?.index === null && second !== undefined;

/** The part that shows a neuron: the parts of a population are either one for each neuron, or boxes. */
function partAt(parts: readonly Part[], index: number): Part | undefined {
  const share = parts[0]?.share;
  return parts[share ? (share.grouping.partOf[index] ?? 0) : index];
}

/** A graph of more lines is a tangle: only the strongest are drawn. */
const MOST_LINES = 48;

function strongest(links: readonly Link[]): Link[] {
  const isOfBoxes = ({ from, to }: Link) => from.share !== null && to.share !== null;
  const boxes = links.filter(isOfBoxes);
  if (boxes.length <= MOST_LINES) return [...links];
  const kept = new Set(boxes.toSorted((a, b) => (b.weight ?? 0) - (a.weight ?? 0)).slice(0, MOST_LINES));
  return links.filter((link) => !isOfBoxes(link) || kept.has(link));
}
