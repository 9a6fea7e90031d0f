import { describe, expect, test } from "vitest";
import { TimeRing } from "./timeRing";

const filled = (count: number, capacity: number) => {
  const ring = new TimeRing(capacity);
  for (let at = 0; at < count; at++) ring.push(at * 0.1, at);
  return ring;
};
const valuesOf = (ring: TimeRing, from_s: number, to_s: number) => {
  const found: number[] = [];
  ring.visit(from_s, to_s, (_, value) => found.push(value));
  return found;
};

describe("a ring of a series", () => {
  test("gives back what was put in, oldest first, while it grows", () => {
    const ring = filled(5000, 8192);
    expect(ring.length).toBe(5000);
    expect(valuesOf(ring, 0, 1e9)).toEqual(Array.from({ length: 5000 }, (_, at) => at));
  });

  test("keeps the newest when it is full", () => {
    const ring = filled(3000, 2048);
    expect(ring.length).toBe(2048);
    expect([ring.valueAt(0), ring.valueAt(2047)]).toEqual([952, 2999]);
  });

  test("finds a stretch of time from its begin to before its end", () => {
    expect(valuesOf(filled(10, 1024), 0.3, 0.5)).toEqual([3, 4]);
    expect(filled(10, 1024).indexAt(99)).toBe(10);
  });

  test("forgets everything from a time on, also after it turned over, and goes on from there", () => {
    const ring = filled(3000, 2048);
    ring.forgetFrom(250);
    expect(ring.timeAt(ring.length - 1)).toBeCloseTo(249.9);
    ring.push(250.05, -1);
    expect(valuesOf(ring, 249.85, 1e9)).toEqual([2499, -1]);
  });

  test("is empty when all of it is forgotten", () => {
    const ring = filled(10, 1024);
    ring.forgetFrom(0);
    expect(ring.length).toBe(0);
  });
});

test("the numbers that a series leaves come before the later ones that it left earlier", () => {
  const [ring, left] = [new TimeRing(64), new TimeRing(64)];
  const numbersOf = (series: TimeRing) => {
    const found: [number, number][] = [];
    series.visit(Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY, (...one) => found.push(one));
    return found;
  };
  const leave = (t_s: number) => {
    left.takeOver(ring, t_s);
    ring.forgetFrom(t_s);
  };
  for (const t_s of [1, 2, 3, 4]) ring.push(t_s, t_s);
  leave(3);
  leave(2);
  expect(numbersOf(ring)).toEqual([[1, 1]]);
  expect(numbersOf(left)).toEqual([
    [2, 2],
    [3, 3],
    [4, 4],
  ]);
  for (const t_s of [2, 3]) ring.push(t_s, 10 * t_s);
  leave(2);
  expect(numbersOf(left)).toEqual([
    [2, 20],
    [3, 30],
    [4, 4],
  ]);
  expect(left.lastTime).toBe(4);
});
