import { expect, test } from "vitest";
import { Spans } from "./spans";

const heard = (...times_s: number[]) => {
  const spans = new Spans();
  times_s.forEach((t_s, at) => {
    if (at % 2 === 0) spans.begin(t_s);
    else spans.end(t_s);
  });
  return spans;
};

test("what was not heard lies between the stretches that were", () => {
  expect(heard(2, 4, 6).gaps(0, 10)).toEqual([
    [0, 2],
    [4, 6],
  ]);
  expect(heard(2, 4).gaps(3, 5)).toEqual([[4, 5]]);
  expect(heard().gaps(3, 5)).toEqual([[3, 5]]);
  expect(heard(0).gaps(3, 5)).toEqual([]);
});

test("what was heard is cut to the window", () => {
  expect(heard(2, 4, 6).within(3, 7)).toEqual([
    [3, 4],
    [6, 7],
  ]);
});

test("after a seek the present stretch goes on from there, and no future is left", () => {
  const inside = heard(2, 4, 6);
  inside.forgetFrom(7);
  expect(inside.within(0, 99)).toEqual([
    [2, 4],
    [6, 99],
  ]);
  const before = heard(2, 4, 6);
  before.forgetFrom(5);
  expect(before.within(0, 99)).toEqual([
    [2, 4],
    [5, 99],
  ]);
  const ended = heard(2, 4);
  ended.forgetFrom(3);
  expect(ended.within(0, 99)).toEqual([[2, 3]]);
});

test("what is no longer kept counts as not heard", () => {
  const spans = heard(2, 4, 6);
  spans.forgetBefore(3);
  expect(spans.gaps(0, 10)).toEqual([
    [0, 3],
    [4, 6],
  ]);
  spans.forgetBefore(5);
  expect(spans.within(0, 99)).toEqual([[6, 99]]);
  spans.forgetBefore(7);
  expect(spans.gaps(0, 10)).toEqual([[0, 7]]);
  expect(spans.has(1e9)).toBe(true);
});
