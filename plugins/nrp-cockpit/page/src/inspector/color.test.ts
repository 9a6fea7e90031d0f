import { expect, it } from "vitest";
import { colorTopics, entityOfTopic, fromHex, SWATCHES, toHex } from "./color";

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

it("a topic that colours names its part", () => {
  const topics = ["/husky/camera", "/husky/base_link/chassis/color"];
  expect(colorTopics(topics).map(entityOfTopic)).toEqual(["husky/base_link/chassis"]);
});
