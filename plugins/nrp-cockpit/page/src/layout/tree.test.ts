import { expect, test } from "vitest";
import {
  append,
  defaultTree,
  freeId,
  moveBorder,
  panelsOf,
  putBeside,
  replace,
  type Split,
  swapPanels,
  without,
} from "./tree";

const tree: Split = {
  direction: "row",
  sizes: [2, 1],
  parts: ["scene", { direction: "column", sizes: [1, 1], parts: ["camera", "map"] }],
};

test("a panel beside another in the direction of its split takes half of its room", () => {
  expect(putBeside(tree, "scene", "left", "brain")).toEqual({
    ...tree,
    sizes: [1, 1, 1],
    parts: ["brain", "scene", tree.parts[1]],
  });
});

test("a panel across the direction of the split splits the other's place", () => {
  const column = { direction: "column", sizes: [1, 1], parts: ["scene", "brain"] };
  expect(putBeside(tree, "scene", "below", "brain").parts[0]).toEqual(column);
  expect(putBeside(tree, "map", "right", "brain").parts[1]).toMatchObject({
    parts: ["camera", { direction: "row", parts: ["map", "brain"] }],
  });
});

test("a split with one panel left is that panel", () => {
  expect(without(tree, "map")).toEqual({ ...tree, parts: ["scene", "camera"] });
  expect(panelsOf(without(without(tree, "map"), "camera"))).toEqual(["scene"]);
});

test("whatever is closed and put back, each panel is there once", () => {
  for (const id of panelsOf(defaultTree))
    for (const other of panelsOf(defaultTree).filter((one) => one !== id))
      for (const side of ["left", "right", "above", "below"] as const) {
        const moved = putBeside(without(defaultTree, id), other, side, id);
        expect(panelsOf(moved).toSorted()).toEqual(panelsOf(defaultTree).toSorted());
      }
});

test("the second of a kind has a number, and a free one is used again", () => {
  const two = append(tree, "camera 2");
  expect(freeId(tree, "camera")).toBe("camera 2");
  expect(freeId(two, "camera")).toBe("camera 3");
  expect(freeId(without(two, "camera"), "camera")).toBe("camera");
  expect(panelsOf(replace(tree, "map", "spikes"))).toEqual(["scene", "camera", "spikes"]);
  expect(panelsOf(swapPanels(tree, "scene", "map"))).toEqual(["map", "camera", "scene"]);
});

test("a border moves between the two parts that are in view, and neither vanishes", () => {
  const three: Split = { direction: "row", sizes: [1, 5, 1], parts: ["scene", "camera", "map"] };
  expect(moveBorder(three, [], [0, 2], 0.25).sizes).toEqual([1.5, 5, 0.5]);
  const [first = 0, , last = 0] = moveBorder(three, [], [0, 2], -9).sizes;
  expect([first, last].map((size) => size.toFixed(2))).toEqual(["0.20", "1.80"]);
  expect(moveBorder(tree, [1], [0, 1], 0.25).parts[1]).toMatchObject({ sizes: [1.5, 0.5] });
});
