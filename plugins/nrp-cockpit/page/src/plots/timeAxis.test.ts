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
