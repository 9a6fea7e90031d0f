import { describe, expect, test } from "vitest";
import type { Device, Population, Projection } from "../state/types";
import { columnsOf } from "./columns";
import { Connections } from "./connections";
import { layGraph } from "./graph";
import { linksOf } from "./links";
import { groupOf, partsOf } from "./nodes";

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
  placed: false,
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
      ["eyes/1", "", "circuit"],
      ["cortex", "cortex", "circuit"],
    ]);
  });

  test("are whole populations where even small ones would be many neurons", () => {
    const many = Array.from({ length: 10 }, (_, at) => population(`leg ${at}`, 10, 10 * at));
    expect(partsOf(many, [])).toHaveLength(10);
  });
});

describe("the groups of a large population", () => {
  const cells = (from: number, to: number) => ({ cortex: [[from, to] as [number, number]] });
  const groups = [
    { name: "left", cells: cells(0, 100), own: cells(0, 100) },
    { name: "right", cells: cells(100, 200), own: cells(100, 200) },
    { name: "both", cells: cells(0, 200), own: {} },
  ];
  const cortex = [population("cortex", 800, 0)];
  const reads = device("motor", "sink", [150]);
  const parts = partsOf(
    cortex,
    [{ ...reads, neurons: Array.from({ length: 60 }, (_, at) => 100 + at) }],
    groups,
  );

  test("are boxes, each in the role of most of its cells, beside the cells in no group", () => {
    expect(parts.map((part) => [part.name, part.size, part.role, groupOf(part)])).toEqual([
      ["left", 100, "circuit", "left"],
      ["right", 100, "actor", "right"],
      ["other cortex", 600, "circuit", null],
    ]);
  });

  test("are linked by the synapses that the server counted, as strongly as a cell gets them", () => {
    const ends = ["left", "right", "both", null].map((group) => ({ population: "cortex", group }));
    const known = new Connections({
      parts: ends,
      links: [
        { projection: "cortex to cortex", from: 0, to: 1, synapses: 500, weight: -0.2 },
        { projection: "cortex to cortex", from: 3, to: 0, synapses: 50, weight: 0.2 },
        { projection: "another", from: 3, to: 3, synapses: 50, weight: 0.2 },
      ],
    });
    const lines = linksOf([projection("cortex", "cortex", null)], parts, known);
    expect(lines.map(({ from, to, weight }) => [from.name, to.name, weight])).toEqual([
      ["left", "right", 1],
      ["other cortex", "left", 0.1],
    ]);
    expect(known.of("left", "from")).toEqual([
      {
        projection: "cortex to cortex",
        group: "right",
        population: "cortex",
        name: "right",
        synapses: 500,
        weight: -0.2,
      },
    ]);
    expect(known.of("left", "to").map(({ name }) => name)).toEqual(["other cortex"]);
    expect(linksOf([projection("cortex", "cortex", null)], parts)).toEqual([]);
  });

  test("are linked by synapses that are told one by one", () => {
    const [line] = linksOf([projection("cortex", "cortex", [[5, 799, 2]])], parts);
    expect([line?.from.name, line?.to.name]).toEqual(["left", "other cortex"]);
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

  test("sets sensors at the left also if the brain drives each of them", () => {
    const parts = partsOf([population("a", 100, 0, "sensor"), population("b", 100, 100)], []);
    const links = linksOf([projection("a", "b", null), projection("b", "a", null)], parts);
    const [a, b] = layGraph(parts, links, 440, 300).nodes;
    expect(a?.part.name).toBe("a");
    expect(a?.x).toBeLessThan(b?.x ?? 0);
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
