import { describe, expect, test } from "vitest";
import { ALL, layBands, lineOf, markSpike, pixelOf, rowAt, shifted, zoomed } from "./raster";

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

  test("leave room for a name beside each of the groups of a fly's brain", () => {
    const sizes = [20, 20, 60, 20, 1, 1, 1, 1, 1, 1, 4, 2362, 1303, 134_844];
    const tops = layBands(sizes, 150).map(({ top }) => top);
    tops.slice(1).forEach((top, at) => {
      expect(top - (tops[at] ?? 0)).toBeGreaterThanOrEqual(10);
    });
  });

  test("stay inside the height", () => {
    for (const sizes of [[8], [3, 900], [1, 1, 1, 40_000]]) {
      const last = layBands(sizes, 150).at(-1);
      expect((last?.top ?? 0) + (last?.height ?? 0)).toBeLessThanOrEqual(150);
    }
  });

  test("say which row is at a height", () => {
    for (const size of [8, 37, 4000]) {
      const [band] = layBands([size], 150);
      if (!band) throw new Error("no band");
      const row = rowAt(band, lineOf(band, size - 1) + 0.5);
      expect(Math.abs(row - (size - 1))).toBeLessThanOrEqual(Math.ceil(size / 150));
    }
  });
});

describe("the part in sight", () => {
  test("keeps what is under the pointer where it is", () => {
    const sight = zoomed(ALL, 0.25, 0.1, 140_000, 300);
    expect(sight.from + 0.25 * (sight.to - sight.from)).toBeCloseTo(0.25);
    expect(sight.to - sight.from).toBeCloseTo(0.1);
    const again = zoomed(sight, 0.8, 0.5, 140_000, 300);
    const pointed = ({ from, to }: typeof sight) => from + 0.8 * (to - from);
    expect(pointed(again)).toBeCloseTo(pointed(sight));
  });

  test("ends at both ends of the cells, and where a cell is high enough", () => {
    expect(shifted({ from: 0.25, to: 0.5 }, -1)).toEqual({ from: 0, to: 0.25 });
    expect(shifted({ from: 0.1, to: 0.3 }, 1).to).toBe(1);
    expect(zoomed({ from: 0.1, to: 0.3 }, 0.5, 100, 1000, 300)).toEqual(ALL);
    const [band] = layBands([140_000], 300, zoomed(ALL, 0.5, 0, 140_000, 300));
    expect(band?.pitch).toBeGreaterThanOrEqual(47);
    expect(band?.pitch).toBeLessThanOrEqual(48);
  });
});

describe("the picture", () => {
  const lines = (top: number, high: number, shared: 0 | 1) => ({
    tops: Int32Array.of(-1, top),
    highs: Uint16Array.of(1, high),
    inks: Uint32Array.of(7, 7),
    shared: Uint8Array.of(0, shared),
  });

  test("shows a spike over the height of its neuron's line, and nothing outside the picture", () => {
    const pixels = { data: new Uint32Array(4 * 20), width: 4, height: 20 };
    markSpike(pixels, lines(10, 8, 0), 2, 1);
    for (const cell of [0, 5]) markSpike(pixels, lines(10, 8, 0), 2, cell);
    const marked = [...pixels.data].flatMap((value, at) => (value ? [[at % 4, Math.floor(at / 4)]] : []));
    expect(marked).toEqual(Array.from({ length: 8 }, (_, row) => [2, 10 + row]));
    markSpike(pixels, lines(19, 8, 0), 0, 1);
    expect(pixels.data).toHaveLength(80);
  });

  test("gets darker where several cells of a line fire", () => {
    const pixels = { data: new Uint32Array(4), width: 1, height: 4 };
    const alphas = [1, 2, 3].map(() => {
      markSpike(pixels, lines(2, 1, 1), 0, 1);
      return (pixels.data[2] ?? 0) >>> 24;
    });
    expect(alphas).toEqual([0x70, 0x88, 0xa0]);
    for (let more = 0; more < 20; more++) markSpike(pixels, lines(2, 1, 1), 0, 1);
    expect((pixels.data[2] ?? 0) >>> 24).toBe(255);
  });

  test("has the bytes of its colour in the order of a canvas", () => {
    expect([...new Uint8Array(new Uint32Array([pixelOf("#d55e00")]).buffer)]).toEqual([0xd5, 0x5e, 0, 255]);
  });
});
