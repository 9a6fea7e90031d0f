import { expect, test } from "vitest";
import { ticksBetween, tickText, timeAt, valueText, xOf } from "./timeAxis";

test("ticks are round and inside", () => {
  expect(ticksBetween(5.12, 9.12, 5)).toEqual([6, 7, 8, 9]);
  expect(ticksBetween(0, 0.06, 3).map((tick) => tickText(tick, 0.02))).toEqual([
    "0.00",
    "0.02",
    "0.04",
    "0.06",
  ]);
  expect(ticksBetween(1, 1, 5)).toEqual([]);
});

test("an axis has two ticks or more, whose texts are what they are at", () => {
  const texts = (from: number, to: number, most: number) => {
    const ticks = ticksBetween(from, to, most);
    const step = (ticks[1] ?? 0) - (ticks[0] ?? 0);
    return ticks.map((tick) => tickText(tick, step));
  };
  expect(texts(7.31, 7.86, 1.5)).toEqual(["7.4", "7.6", "7.8"]);
  expect(texts(12.02, 13.4, 1)).toEqual(["12.5", "13.0"]);
  expect(texts(0, 0.74, 1)).toEqual(["0.0", "0.5"]);
  expect(texts(-0.04, 0.05, 2)).toEqual(["0.00", "0.05"]);
  expect(ticksBetween(1000, 1000 + 1.2e-13, 3).length).toBeLessThan(20); // though there is no number between
  for (let at = 0; at < 200; at++) {
    const [from, width] = [Math.sin(at) * 30, 10 ** (at % 5) * 0.013];
    const ticks = ticksBetween(from, from + width, 1 + (at % 3));
    expect(ticks.length).toBeGreaterThanOrEqual(2);
    expect(ticks.every((tick) => tick >= from - 1e-9 && tick <= from + width + 1e-9)).toBe(true);
  }
});

test("the texts of an axis are numbers that differ, each nearest to its tick", () => {
  for (let size = -9; size <= 9; size++)
    for (let share = 0; share <= 6; share++)
      for (const from of [-1.37, -0.4, 0, 0.62, 1]) {
        const ticks = ticksBetween(from * 10 ** size, (from + 10 ** -share) * 10 ** size, 2);
        const step = (ticks[1] ?? Number.NaN) - (ticks[0] ?? Number.NaN);
        expect(ticks.length).toBeGreaterThanOrEqual(2);
        for (const tick of ticks)
          expect(Math.abs(Number(tickText(tick, step)) - tick)).toBeLessThan(step / 20);
      }
});

test("values have three digits", () => {
  expect([0.0361, 1.104, 72.34, 123456, 0, 2e-9, undefined].map((each) => valueText(each))).toEqual([
    "0.0361",
    "1.10",
    "72.3",
    "123456",
    "0.00",
    "2.00e-9",
    "–",
  ]);
});

test("a place on the scale leads back to its time", () => {
  const scale = { from_s: 5, to_s: 9, left: 60, right: 460 };
  expect(xOf(scale, 7)).toBe(260);
  expect(timeAt(scale, xOf(scale, 6.3))).toBeCloseTo(6.3);
});

test("says about 0 for what is left of a value that decays", () => {
  expect(valueText(5.7e-54, 0.05)).toBe("≈ 0");
  expect(valueText(5.7e-54)).toBe("5.70e-54");
  expect(valueText(1e-6, 0.05)).toBe("1.00e-6");
  expect(valueText(0, 0.05)).toBe("0.00");
});
