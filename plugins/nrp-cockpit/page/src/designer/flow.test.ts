import { expect, test } from "vitest";
import { type BoxNode, edgesOf, nodesOf, partOfWire } from "./flow";
import type { DesignState } from "./types";

const row = "transfer_function/0/topic/0";
const state = {
  boxes: [
    { id: "topic:/camera", kind: "topic", name: "/camera", x: 0, y: 8 },
    { id: "transfer_function/0", kind: "function", name: "eyes", x: 264, y: 24, rows: [] },
  ],
  wires: [
    {
      id: "w",
      kind: "message",
      source: "topic:/camera",
      source_end: "topic:/camera",
      target: "transfer_function/0",
      target_end: row,
    },
  ],
} as unknown as DesignState;

test("a box stands where the server says, and is selected with its parts", () => {
  const [topic, eyes] = nodesOf(state, row, []);
  expect(topic).toMatchObject({ position: { x: 0, y: 8 }, selected: false });
  expect(eyes).toMatchObject({ position: { x: 264, y: 24 }, selected: true });
});

test("a box that was measured stays measured, so that wires do not jump", () => {
  const before = [{ id: "topic:/camera", measured: { width: 200, height: 44 } }] as BoxNode[];
  expect(nodesOf(state, "", before)[0]?.measured).toEqual({ width: 200, height: 44 });
});

test("a wire ends at the handles of its ends and belongs to a part", () => {
  const [edge] = edgesOf(state, row);
  expect(edge).toMatchObject({ sourceHandle: "topic:/camera", targetHandle: row, selected: true });
  expect(edge && partOfWire(edge)).toBe(row);
});

const projection = (id: string, target: string) => ({
  id,
  kind: "excites",
  label: "1 uS",
  part: id,
  source: "population/0",
  source_end: "population/0",
  target,
  target_end: `into:${target}`,
});

test("projections between the same populations bend apart, and one to itself goes over its box", () => {
  const brain = {
    boxes: [{ id: "population/0", kind: "neurons", name: "a", rows: [{}, {}] }],
    wires: [
      projection("projection/0", "population/1"),
      projection("projection/1", "population/1"),
      projection("projection/2", "population/0"),
    ],
  } as unknown as DesignState;
  const [one, other, loop] = edgesOf(brain, "projection/1");
  expect(one).not.toMatchObject({ pathOptions: (other as { pathOptions?: object }).pathOptions });
  expect([one?.selected, other?.selected]).toEqual([false, true]);
  expect(loop).toMatchObject({ type: "loop", data: { rows: 2, before: 0 } });
  expect(loop && partOfWire(loop)).toBe("projection/2");
});
