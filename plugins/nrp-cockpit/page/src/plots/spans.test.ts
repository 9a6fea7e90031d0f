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

test("a leap leaves a gap in a stretch that goes on, and in no other", () => {
  const on = heard(2);
  on.leave(6, 16);
  expect(on.within(0, 20)).toEqual([
    [2, 6],
    [16, 20],
  ]);
  const over = heard(2, 4);
  over.leave(6, 16);
  expect(over.within(0, 20)).toEqual([[2, 4]]);
});

test("what comes late from before the begin of a stretch belongs to it, but not to one that has ended", () => {
  const spans = heard(2, 4, 20);
  spans.include(16);
  expect(spans.within(0, 30)).toEqual([
    [2, 4],
    [16, 30],
  ]);
  spans.include(3);
  expect(spans.within(0, 30)).toEqual([
    [2, 4],
    [4, 30],
  ]);
});
