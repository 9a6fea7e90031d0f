import { expect, test } from "vitest";
import { outlinesOf, pin, type Seen, unpin, usePins } from "./pins";

const seen = (t_s: number, counts = [1], borders = [0, 1]): Seen => ({ t_s, counts, borders, summary: null });
const times = (id: string) => (usePins.getState().pins[id] ?? []).map(({ t_s }) => t_s);

test("two moments of a projection are kept; a third one replaces the second", () => {
  pin("a", seen(1));
  pin("a", seen(2));
  pin("b", seen(9));
  pin("a", seen(3));
  expect([times("a"), times("b")]).toEqual([[1, 3], [9]]);
  unpin("a", 1);
  pin("a", seen(3));
  expect(times("a")).toEqual([3]);
});

test("histograms of different extent share their axes, and equal areas are equally many synapses", () => {
  const [narrow, wide] = outlinesOf([seen(0, [4], [0, 1]), seen(1, [2, 2], [0, 1, 2])]);
  expect(narrow).toEqual([
    [0, 0],
    [0, 1],
    [0.5, 1],
    [0.5, 0],
  ]);
  expect(wide).toEqual([
    [0, 0],
    [0, 0.5],
    [0.5, 0.5],
    [0.5, 0.5],
    [1, 0.5],
    [1, 0],
  ]);
  const [single] = outlinesOf([seen(0, [7], [0.5, 0.5])]);
  expect(single?.flat().every(Number.isFinite)).toBe(true);
});
