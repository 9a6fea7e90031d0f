import { describe, expect, test } from "vitest";
import type { Device, Population, Projection } from "../state/types";
import { columnsOf } from "./columns";
import { layGraph } from "./graph";
import { linksOf, partsOf } from "./nodes";

const population = (
  label: string,
  size: number,
  first: number,
  role: Population["role"] = "circuit",
): Population => ({
  label,
  size,
  first,
  cell: "IF_cond_alpha",
  role,
  positions: null,
});

const projection = (
  pre: string,
  post: string,
  edges: [number, number, number][] | null,
  label = `${pre} to ${post}`,
): Projection => ({
  id: label,
  label,
  pre,
  post,
  receptor: "excitatory",
  synapse: "static",
  size: edges?.length ?? 5000,
  excites: true,
  edges,
});

const device = (name: string, kind: "source" | "sink", neurons: number[]): Device => ({
  name,
  kind,
  neurons,
  topic: `/brain/devices/${name}`,
  population: "circuit",
  unit: "",
});

/** The eight cells of the Braitenberg vehicle. */
const circuit = [population("circuit", 8, 0)];
const devices = [
  device("eyes/left_eye", "source", [0, 2]),
  device("eyes/right_eye", "source", [1, 3]),
  device("eyes/other", "source", [4]),
  device("wheels/left_wheel", "sink", [6]),
  device("wheels/right_wheel", "sink", [7]),
];
const wires = (pairs: [number, number][]) =>
  projection(
    "circuit",
    "circuit",
    pairs.map(([a, b]) => [a, b, 1]),
  );
const synapses = wires([
  [2, 7],
  [3, 6],
  [4, 7],
  [5, 7],
  [0, 4],
  [1, 4],
  [0, 5],
  [1, 5],
]);

describe("the columns of the graph", () => {
  const parts = partsOf(circuit, devices);
  const columns = columnsOf(parts, linksOf([synapses], parts)).map((column) =>
    column.map(({ index }) => index),
  );

  test("lead from sensors through the circuit to actors", () => {
    expect(columns.map((column) => [...column].sort())).toEqual([
      [0, 1, 2, 3],
      [4, 5],
      [6, 7],
    ]);
  });

  test("are ordered so that few lines cross", () => {
    const place = (index: number) =>
      columns.flatMap((column) => [column.indexOf(index)]).find((at) => at >= 0) ?? -1;
    expect(place(2) < place(3)).toBe(place(7) < place(6));
  });
});

describe("the parts of the graph", () => {
  test("are the neurons of a small population with their devices' names, and a large population as a whole", () => {
    const parts = partsOf(
      [population("eyes", 2, 0, "sensor"), population("cortex", 800, 2)],
      [device("see/left_eye", "source", [0])],
    );
    expect(parts.map(({ id, name, role }) => [id, name, role])).toEqual([
      ["eyes/0", "left eye", "sensor"],
      ["eyes/1", "", "sensor"],
      ["cortex", "cortex", "circuit"],
    ]);
  });

  test("are whole populations where even small ones would be many neurons", () => {
    const many = Array.from({ length: 10 }, (_, at) => population(`leg ${at}`, 10, 10 * at));
    expect(partsOf(many, [])).toHaveLength(10);
  });
});

describe("the lines of the graph", () => {
  const populations = [population("eyes", 2, 0, "sensor"), population("cortex", 800, 2)];
  const parts = partsOf(populations, []);

  test("join the synapses between the same parts, as wide as the strongest", () => {
    const [line, ...more] = linksOf(
      [
        projection("eyes", "cortex", [
          [1, 5, 0.1],
          [1, 6, -0.3],
        ]),
      ],
      parts,
    );
    expect([line?.from.id, line?.to.id, line?.weight]).toEqual(["eyes/1", "cortex", 0.3]);
    expect(more).toEqual([]);
  });

  test("run from all to all where the synapses are too many to be told", () => {
    const lines = linksOf([projection("eyes", "cortex", null)], parts);
    expect(lines.map(({ from }) => from.id)).toEqual(["eyes/0", "eyes/1"]);
  });
});

describe("the layout", () => {
  test.each([
    [440, 175],
    [1200, 700],
    [220, 110],
  ])("keeps every part inside %i by %i, and no two on each other", (width, height) => {
    const parts = partsOf(circuit, devices);
    const { nodes } = layGraph(parts, linksOf([synapses], parts), width, height);
    expect(nodes).toHaveLength(8);
    for (const { x, y, rx, ry } of nodes)
      expect([x - rx, y - ry, width - x - rx, height - y - ry].every((room) => room > 0)).toBe(true);
    const pairs = nodes.flatMap((a, at) => nodes.slice(at + 1).map((b) => [a, b] as const));
    for (const [a, b] of pairs) expect(Math.hypot(a.x - b.x, a.y - b.y)).toBeGreaterThan(a.rx + b.rx);
  });

  test.each([
    [398, 128],
    [440, 175],
    [900, 500],
  ])("keeps a large population beside the neurons apart from them in %i by %i", (width, height) => {
    const parts = partsOf([...circuit, population("noise", 1000, 8, "sensor")], devices);
    const { nodes } = layGraph(parts, linksOf([synapses], parts), width, height);
    const box = nodes.find(({ part }) => part.index === null);
    if (!box) throw new Error("the population is missing");
    for (const { x, rx, part } of nodes) {
      expect(Math.min(x - rx, width - x - rx)).toBeGreaterThan(0);
      if (part !== box.part) expect(Math.abs(x - box.x)).toBeGreaterThan(rx + box.rx);
    }
  });

  test("sets a column that is too high side by side", () => {
    const parts = partsOf(
      Array.from({ length: 3 }, (_, at) => population(`p${at}`, 16, 16 * at)),
      [],
    );
    const { nodes } = layGraph(parts, [], 440, 175);
    const places = new Set(nodes.map(({ x, y }) => `${x} ${y}`));
    expect(places.size).toBe(48);
    expect(new Set(nodes.map(({ x }) => x)).size).toBeGreaterThan(3);
  });

  test("draws a way for every line, also from a part to itself and for both directions", () => {
    const parts = partsOf([population("a", 100, 0), population("b", 100, 100)], []);
    const links = linksOf(
      [projection("a", "a", null), projection("a", "b", null), projection("b", "a", null)],
      parts,
    );
    const paths = layGraph(parts, links, 440, 175).lines.map(({ path }) => path);
    expect(new Set(paths).size).toBe(3);
    for (const path of paths) expect(path).not.toMatch(/NaN|Infinity/);
  });
});
