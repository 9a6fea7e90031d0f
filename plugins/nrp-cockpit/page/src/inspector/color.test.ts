import { expect, it } from "vitest";
import type { Body } from "../state/types";
import { coloredParts, fromHex, SWATCHES, toHex } from "./color";

it("a colour survives the way through the colour input", () => {
  for (const hex of ["#000000", "#ffffff", "#12ab9f"]) expect(toHex(fromHex(hex))).toBe(hex);
});

it("a colour beyond the range is shown as the nearest one", () => {
  expect(toHex({ r: 2, g: -1, b: 0.5, a: 1 })).toBe("#ff0080");
});

it("the four colours of one click are those of their names", () => {
  expect(SWATCHES.map(({ name, color }) => `${name} ${toHex(color)}`)).toEqual([
    "Red #ff0000",
    "Blue #0000ff",
    "Green #00ff00",
    "White #ffffff",
  ]);
});

const husky: Body = {
  name: "husky",
  static: false,
  pose: null,
  topics: ["/husky/camera", "/husky/base/deck/color", "/husky/base/plate/color"],
  colorable: null,
  colored_part: null,
};

it("a topic that colours names its part", () => {
  expect(coloredParts(husky)).toEqual([
    { topic: "/husky/base/deck/color", entity: "husky/base/deck" },
    { topic: "/husky/base/plate/color", entity: "husky/base/plate" },
  ]);
});

it("the part that the experiment names comes first, by that name, and only once", () => {
  const named: Body = { ...husky, colorable: "/plate", colored_part: "husky/base/plate" };
  expect(coloredParts(named)).toEqual([
    { topic: "/plate", entity: "husky/base/plate" },
    { topic: "/husky/base/deck/color", entity: "husky/base/deck" },
  ]);
});
