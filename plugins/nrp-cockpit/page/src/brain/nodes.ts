import type { Device, Population, Projection } from "../state/types";
import { type Role, rolesOf } from "./cells";

/** What the graph shows as one thing: a neuron of a small population, or a whole population. */
export interface Part {
  id: string;
  population: Population;
  /** The neuron's number in the population; null: all of it. */
  index: number | null;
  role: Role;
  /** What the neuron is to the robot: the name of its device, else empty; of a population its label. */
  name: string;
}

/** A line of the graph: one or more synapses of a projection between the same two parts. */
export interface Link {
  id: string;
  projection: Projection;
  from: Part;
  to: Part;
  /** The largest weight among them, without its sign; null when the weights are not known. */
  weight: number | null;
}

/** Populations up to this size are drawn neuron by neuron, as long as all of these together are few. */
const SMALL = 16;
const MOST_NEURONS = 48;

export function partsOf(populations: readonly Population[], devices: readonly Device[]): Part[] {
  const small = populations.filter(({ size }) => size <= SMALL);
  const few = small.reduce((sum, { size }) => sum + size, 0) <= MOST_NEURONS;
  return populations.flatMap((population): Part[] => {
    const { label, size, role } = population;
    if (!few || size > SMALL) return [{ id: label, population, index: null, role, name: label }];
    return rolesOf(population, devices).map((role, index) => ({
      id: `${label}/${index}`,
      population,
      index,
      role,
      name: nameOf(population.first + index, devices),
    }));
  });
}

/** The last part of the name of the device that drives or reads a neuron. */
function nameOf(neuron: number, devices: readonly Device[]): string {
  const name = devices.find(({ neurons }) => neurons.includes(neuron))?.name ?? "";
  return name.slice(name.lastIndexOf("/") + 1).replaceAll("_", " ");
}

/** The lines between parts; where a projection does not name its synapses, each part of one end meets each of the other. */
export function linksOf(projections: readonly Projection[], parts: readonly Part[]): Link[] {
  return projections.flatMap((projection) => {
    const links = new Map<string, Link>();
    for (const [from, to, weight] of pairsOf(projection, parts)) {
      const id = `${projection.id}: ${from.id} > ${to.id}`;
      const known = links.get(id)?.weight ?? 0;
      links.set(id, { id, projection, from, to, weight: weight && Math.max(Math.abs(weight), known) });
    }
    return [...links.values()];
  });
}

function pairsOf(projection: Projection, parts: readonly Part[]): [Part, Part, number | null][] {
  const [pre, post] = [projection.pre, projection.post].map((label) =>
    parts.filter(({ population }) => population.label === label),
  ) as [Part[], Part[]];
  if (projection.edges === null)
    return pre.flatMap((from) => post.map((to) => [from, to, null] as [Part, Part, null]));
  return projection.edges.flatMap(([a, b, weight]) => {
    const [from, to] = [partAt(pre, a), partAt(post, b)];
    return from && to ? [[from, to, weight] as [Part, Part, number]] : [];
  });
}

/** The part that shows a neuron: the parts of a population are either one for each neuron, or one for all. */
const partAt = (parts: readonly Part[], index: number): Part | undefined =>
  parts[0]?.index === null ? parts[0] : parts[index];
