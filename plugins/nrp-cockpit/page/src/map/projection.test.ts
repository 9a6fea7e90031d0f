import { describe, expect, it } from "vitest";
import type { Footprint } from "./footprint";
import { barLength, fittedTo, lengthText, movedBy, toCanvas, toWorld, zoomedAt } from "./projection";

const size = { width: 300, height: 200 };
const view = { x: 1, y: -2, scale: 25 };

const room: Footprint = {
  body: "room",
  outline: [
    [-6, -4],
    [6, -4],
    [6, 4],
    [-6, 4],
  ],
  bottom_m: 0,
  top_m: 1,
  color: { r: 1, g: 1, b: 1, a: 1 },
};

describe("the map", () => {
  it("has x to the right and y to the top", () => {
    const [x0, y0] = toCanvas(view, size, [0, 0]);
    const [x1, y1] = toCanvas(view, size, [1, 1]);
    expect([x1 - x0, y1 - y0]).toEqual([25, -25]);
  });

  it("finds the place of a pixel", () => {
    const [x, y] = toWorld(view, size, toCanvas(view, size, [3.25, -1.5]));
    expect(x).toBeCloseTo(3.25);
    expect(y).toBeCloseTo(-1.5);
  });

  it("keeps the place under the pointer while it zooms", () => {
    const before = toWorld(view, size, [40, 170]);
    const after = toWorld(zoomedAt(view, size, [40, 170], 3), size, [40, 170]);
    expect(after[0]).toBeCloseTo(before[0]);
    expect(after[1]).toBeCloseTo(before[1]);
  });

  it("moves with the pointer", () => {
    const [x, y] = toCanvas(view, size, [2, 2]);
    const [movedX, movedY] = toCanvas(movedBy(view, 7, -9), size, [2, 2]);
    expect(movedX - x).toBeCloseTo(7);
    expect(movedY - y).toBeCloseTo(-9);
  });

  it("fits a whole room with a margin", () => {
    const fitted = fittedTo([room], size);
    expect(fitted).toMatchObject({ x: 0, y: 0 });
    for (const point of room.outline) {
      const [x, y] = toCanvas(fitted ?? view, size, point);
      expect(Math.min(x, size.width - x, y, size.height - y)).toBeGreaterThan(11.9);
    }
    expect(fittedTo([], size)).toBeNull();
  });

  it("has a bar of a round length that fits", () => {
    expect([100, 36, 30, 7].map((scale) => barLength(scale, 72))).toEqual([0.5, 2, 2, 10]);
  });

  it("says the length of its bar as people do, for a room and for an insect", () => {
    expect([10, 2, 0.5, 0.2, 0.01, 0.005, 0.0002].map(lengthText)).toEqual([
      "10 m",
      "2 m",
      "0.5 m",
      "20 cm",
      "1 cm",
      "5 mm",
      "0.2 mm",
    ]);
  });
});
