import { expect, test } from "vitest";
import { groupingOf } from "../state/grouping";
import type { CellGroup, Population } from "../state/types";
import { bandsOf } from "./order";

const brain: Population = {
  label: "brain",
  size: 20,
  first: 0,
  cell: "IF_curr_exp",
  role: "circuit",
  positions: null,
  placed: false,
};
const group = (name: string, ...ranges: [number, number][]): CellGroup => {
  const cells = { brain: ranges };
  return { name, cells, own: ranges.length > 0 ? cells : {} };
};
const GROUPS = [group("left", [0, 3]), group("right", [3, 5], [8, 9]), group("both")];

test("each cell stands in its own group, and a group without own cells has no band", () => {
  const bands = bandsOf(brain, groupingOf(brain, GROUPS), null);
  expect(bands.map(({ label, cells }) => [label, [...cells]])).toEqual([
    ["left", [0, 1, 2]],
    ["right", [3, 4, 8]],
    ["other brain", [5, 6, 7, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19]],
  ]);
});

test("the cells of a population without groups are one band", () => {
  const [band] = bandsOf(brain, groupingOf(brain, []), null);
  expect([band?.label, band?.group, band?.cells.length]).toEqual(["brain", null, 20]);
});

test("cells that fired most come first, and silent ones take no room", () => {
  const counts = new Uint32Array(20);
  counts[1] = 2;
  counts[2] = 5;
  counts[9] = 1;
  const bands = bandsOf(brain, groupingOf(brain, GROUPS), counts);
  expect(bands.map(({ label, cells }) => [label, [...cells]])).toEqual([
    ["left", [2, 1]],
    ["other brain", [9]],
  ]);
});
