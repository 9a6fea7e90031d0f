import { describe, expect, test } from "vitest";
import { cellAt, fillLines, layBands, lineOf, markSpike, pixelOf } from "./raster";

describe("the bands of populations", () => {
  test("follow the numbers of neurons while every neuron has a line to see", () => {
    const [five, one] = layBands([5, 1], 126);
    expect([five?.height, one?.height]).toEqual([100, 20]);
    expect(one?.top).toBe(106);
  });

  test("leave room for a small population beside a large one", () => {
    const [, small] = layBands([10_000, 10], 206);
    expect(small?.height).toBeGreaterThanOrEqual(50);
  });

  test("stay inside the height", () => {
    for (const sizes of [[8], [3, 900], [1, 1, 1, 40_000]]) {
      const last = layBands(sizes, 150).at(-1);
      expect((last?.top ?? 0) + (last?.height ?? 0)).toBeLessThanOrEqual(150);
    }
  });

  test("say which neuron is at a height", () => {
    for (const size of [8, 37, 4000]) {
      const [band] = layBands([size], 150);
      if (!band) throw new Error("no band");
      const cell = cellAt(band, lineOf(band, size - 1) + 0.5);
      expect(Math.abs(cell - (size - 1))).toBeLessThanOrEqual(Math.ceil(size / 150));
    }
  });
});

describe("the picture", () => {
  test("shows a spike over the height of its neuron's line, and nothing outside the picture", () => {
    const [band] = layBands([2], 20);
    if (!band) throw new Error("no band");
    const pixels = { data: new Uint32Array(4 * 20), width: 4 };
    markSpike(pixels, band, 2, 1, 7);
    for (const x of [-1, 4]) markSpike(pixels, band, x, 0, 7);
    fillLines(pixels, band);
    const marked = [...pixels.data].flatMap((value, at) => (value ? [[at % 4, Math.floor(at / 4)]] : []));
    expect(marked).toEqual(Array.from({ length: 8 }, (_, row) => [2, 10 + row]));
  });

  test("has the bytes of its colour in the order of a canvas", () => {
    expect([...new Uint8Array(new Uint32Array([pixelOf("#d55e00")]).buffer)]).toEqual([0xd5, 0x5e, 0, 255]);
  });
});
