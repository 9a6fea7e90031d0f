import { type Grouping, partName } from "../state/grouping";
import type { Population } from "../state/types";

/** How the cells of a band stand below each other: by number, or those that fired most first, without silent ones. */
export type Order = "number" | "active";

/** Cells of one population that are drawn together, from the top down. */
export interface Ordered {
  population: Population;
  /** The group's name; null: the cells in no group. */
  group: string | null;
  /** What is written beside them. */
  label: string;
  cells: Uint32Array;
}

/** The bands of a population: one for each group. `counts`: the spikes of each cell, where the active ones come first. */
export function bandsOf(population: Population, grouping: Grouping, counts: Uint32Array | null): Ordered[] {
  const { names, sizes, partOf } = grouping;
  const cells = sizes.map((size) => new Uint32Array(size));
  const filled = sizes.map(() => 0);
  for (let cell = 0; cell < population.size; cell++) {
    if (counts && counts[cell] === 0) continue;
    const part = partOf[cell] as number;
    const at = filled[part] as number;
    (cells[part] as Uint32Array)[at] = cell;
    filled[part] = at + 1;
  }
  const bands = names.map((group, part): Ordered => {
    const own = (cells[part] as Uint32Array).subarray(0, filled[part]);
    if (counts) own.sort((a, b) => (counts[b] as number) - (counts[a] as number) || a - b);
    return { population, group, label: partName(population, grouping, part), cells: own };
  });
  return bands.filter((band) => band.cells.length > 0);
}
