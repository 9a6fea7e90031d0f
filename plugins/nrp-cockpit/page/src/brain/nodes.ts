import { cellName, type Role, rolesOf } from "../state/cells";
import { type Grouping, groupingOf, partName } from "../state/grouping";
import type { CellGroup, Device, Population, Projection } from "../state/types";

/** What the graph shows as one thing: a neuron of a small population, a group of cells, or a whole population. */
export interface Part {
  id: string;
  population: Population;
  /** The neuron's number in the population; null: several cells. */
  index: number | null;
  /** How the cells of the population are shared among its boxes, and which of these it is; null: it is a neuron. */
  share: { grouping: Grouping; part: number } | null;
  size: number;
  role: Role;
  /** What the neuron is to the robot: the name of its device, else empty; of cells the name of their group. */
  name: string;
}

/** The group that a box shows; null: it is a neuron, or shows the cells in no group. */
export const groupOf = ({ share }: Part): string | null =>
  share && (share.grouping.names[share.part] ?? null);

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

export function partsOf(
  populations: readonly Population[],
  devices: readonly Device[],
  groups: readonly CellGroup[] = [],
): Part[] {
  const small = populations.filter(({ size }) => size <= SMALL);
  const few = small.reduce((sum, { size }) => sum + size, 0) <= MOST_NEURONS;
  return populations.flatMap((population): Part[] => {
    const roles = rolesOf(population, devices);
    if (!few || population.size > SMALL) return boxesOf(population, roles, groups);
    return roles.map((role, index) => ({
      id: `${population.label}/${index}`,
      population,
      index,
      share: null,
      size: 1,
      role,
      name: cellName(population.first + index, devices),
    }));
  });
}

function boxesOf(population: Population, roles: readonly Role[], groups: readonly CellGroup[]): Part[] {
  const grouping = groupingOf(population, groups);
  const { label } = population;
  return grouping.names.map((_, part) => ({
    id: grouping.names.length > 1 ? `${label}#${part}` : label,
    population,
    index: null,
    share: { grouping, part },
    size: grouping.sizes[part] ?? 0,
    role: grouping.names.length > 1 ? roleOf(grouping, part, roles) : population.role,
    name: partName(population, grouping, part),
  }));
}

/** The part that most cells of a box play. */
function roleOf({ partOf }: Grouping, part: number, roles: readonly Role[]): Role {
  const counts = { sensor: 0, circuit: 0, actor: 0 };
  partOf.forEach((one, cell) => {
    if (one === part) counts[roles[cell] ?? "circuit"]++;
  });
  const all = Object.keys(counts) as Role[];
  return all.reduce((most, role) => (counts[role] > counts[most] ? role : most));
}
