import type { CellGroup, Population } from "./types";

/** The cells of a population, each in exactly one part. */
export interface Grouping {
  /** The names of the parts; null: the cells in no group. */
  names: readonly (string | null)[];
  sizes: readonly number[];
  /** The part of each cell. */
  partOf: Uint16Array;
}

/** Shares the cells of a population among its groups and, as the last part, those in none. */
export function groupingOf({ label, size }: Population, groups: readonly CellGroup[]): Grouping {
  const own = groups.filter((group) => group.own[label]);
  const sizes = own.map((group) => cellsIn(group.own, label));
  const partOf = new Uint16Array(size).fill(own.length);
  own.forEach((group, part) => {
    for (const [from, to] of group.own[label] ?? []) partOf.fill(part, from, to);
  });
  const rest = size - sizes.reduce((sum, one) => sum + one, 0);
  const names = own.map(({ name }) => name);
  return rest > 0 ? { names: [...names, null], sizes: [...sizes, rest], partOf } : { names, sizes, partOf };
}

/** What a part of a population is called. */
export const partName = ({ label }: Population, { names }: Grouping, part: number): string =>
  names[part] ?? (names.length > 1 ? `other ${label}` : label);

/** The number of cells in ranges of a population. */
export const cellsIn = (ranges: CellGroup["cells"], population: string): number =>
  (ranges[population] ?? []).reduce((sum, [from, to]) => sum + to - from, 0);

/** All cells of a group. */
export const sizeOf = ({ cells }: CellGroup): number =>
  Object.keys(cells).reduce((sum, label) => sum + cellsIn(cells, label), 0);
