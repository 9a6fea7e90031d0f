import type { Link, Part } from "./nodes";

/**
 * The parts in columns from left to right: sensors that nothing in the brain drives, or all sensors if each is driven;
 * then the circuit by its distance from them, then actors. Within a column the order is such that few lines cross.
 */
export function columnsOf(parts: readonly Part[], links: readonly Link[]): Part[][] {
  const others = links.filter(({ from, to }) => from !== to);
  const driven = new Set(others.map(({ to }) => to));
  const sensors = parts.filter(({ role }) => role === "sensor");
  const undriven = sensors.filter((part) => !driven.has(part));
  const first = undriven.length > 0 ? undriven : sensors;
  const last = parts.filter(({ role }) => role === "actor");
  const outer = new Set([...first, ...last]);
  const distance = distancesFrom(first, others);
  const between = parts.filter((part) => !outer.has(part));
  const layerOf = (part: Part) => distance.get(part) ?? 1;
  const layers = [...new Set(between.map(layerOf))].sort((a, b) => a - b);
  const middle = layers.map((layer) => between.filter((part) => layerOf(part) === layer));
  return uncrossed(
    [first, ...middle, last].filter(({ length }) => length > 0),
    others,
  );
}

function distancesFrom(starts: readonly Part[], links: readonly Link[]): Map<Part, number> {
  const distance = new Map(starts.map((part) => [part, 0]));
  const queue = [...starts];
  for (const part of queue) {
    for (const { from, to } of links) {
      if (from !== part || distance.has(to)) continue;
      distance.set(to, (distance.get(part) ?? 0) + 1);
      queue.push(to);
    }
  }
  return distance;
}

const SWEEPS = 4;

/** Orders each column by the mean height of what its parts are linked with (the barycentre method). */
function uncrossed(columns: readonly Part[][], links: readonly Link[]): Part[][] {
  let sorted = columns.map((column) => [...column]);
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    const heights = new Map(
      sorted.flatMap((column) => column.map((part, at) => [part, (at + 0.5) / column.length] as const)),
    );
    const fixed = sweep % 2 === 0 ? 0 : sorted.length - 1;
    sorted = sorted.map((column, at) => (at === fixed ? column : byMeanHeight(column, links, heights)));
  }
  return sorted;
}

function byMeanHeight(
  column: readonly Part[],
  links: readonly Link[],
  heights: ReadonlyMap<Part, number>,
): Part[] {
  const mean = (part: Part) => {
    const ends = links.flatMap(({ from, to }) => (from === part ? [to] : to === part ? [from] : []));
    const sum = ends.reduce((total, end) => total + (heights.get(end) ?? 0.5), 0);
    return ends.length > 0 ? sum / ends.length : (heights.get(part) ?? 0.5);
  };
  return column.toSorted((a, b) => mean(a) - mean(b));
}
