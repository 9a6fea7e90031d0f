import { groupOf, type Part } from "./nodes";

/** What the server says about the synapses between groups; null: there are too many to count. */
export interface ConnectionData {
  parts: { population: string; group: string | null }[] | null;
  links: { projection: string; from: number; to: number; synapses: number; weight: number }[] | null;
}

/** The synapses of all projections between two parts of the brain. */
export interface Between {
  projection: string;
  /** The group at the other end; null: the cells of a population that are in no group. */
  group: string | null;
  population: string;
  /** What these cells are called. */
  name: string;
  synapses: number;
  /** The mean weight. */
  weight: number;
}

/** The synapses between groups of cells, as they were when the run began. */
export class Connections {
  constructor(private readonly data: ConnectionData) {}

  /** The parts that a projection connects, with the weight of all synapses onto one cell of the target. */
  pairs(projection: string, pre: readonly Part[], post: readonly Part[]): [Part, Part, number][] {
    return (this.data.links ?? []).flatMap((link) => {
      if (link.projection !== projection) return [];
      const [from, to] = [this.find(pre, link.from), this.find(post, link.to)];
      return from && to ? [[from, to, (link.weight * link.synapses) / to.size] as [Part, Part, number]] : [];
    });
  }

  /** The synapses that leave a group or reach it, most first. */
  of(group: string, end: "from" | "to"): Between[] {
    const { parts, links } = this.data;
    const other = end === "from" ? "to" : "from";
    return (links ?? [])
      .filter((link) => parts?.[link[end]]?.group === group)
      .map(({ projection, synapses, weight, ...ends }) => {
        const { group: at = null, population = "" } = parts?.[ends[other]] ?? {};
        const isRest = parts?.some((part) => part.group !== null && part.population === population);
        const name = at ?? (isRest ? `other ${population}` : population);
        return { projection, group: at, population, name, synapses, weight };
      })
      .toSorted((a, b) => b.synapses - a.synapses);
  }

  private find(parts: readonly Part[], number: number): Part | undefined {
    const one = this.data.parts?.[number];
    if (parts[0]?.index !== null) return undefined;
    return parts.find((part) => groupOf(part) === one?.group && part.population.label === one?.population);
  }
}
