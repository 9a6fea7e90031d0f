import { describe, expect, test } from "vitest";
import { Scroll } from "./scroll";
import { TimeRing } from "./timeRing";

const ringOf = (...times_s: number[]) => {
  const ring = new TimeRing(1024);
  times_s.forEach((t_s, at) => {
    ring.push(t_s, at);
  });
  return ring;
};

/** The columns that are marked when a picture moves to a time. */
function marked(scroll: Scroll, ring: TimeRing, from_s: number): number[] {
  const columns: number[] = [];
  const fresh = scroll.moveTo(from_s, [ring]);
  scroll.visit(ring, fresh, (column) => columns.push(column));
  return columns;
}

describe("a picture that moves over time", () => {
  test("draws each number once, however it moves on", () => {
    const ring = ringOf(0.05, 0.15, 0.25);
    const scroll = new Scroll(10, 10);
    expect(marked(scroll, ring, 0)).toEqual([0, 1, 2]);
    expect(marked(scroll, ring, 0)).toEqual([]);
    ring.push(0.95, 3);
    ring.push(1.05, 4); // not in sight yet
    expect(marked(scroll, ring, 0)).toEqual([9]);
    expect(marked(scroll, ring, 0.1)).toEqual([10]);
  });

  test("draws again what comes back into sight", () => {
    const ring = ringOf(0.05, 0.15, 1.55);
    const scroll = new Scroll(10, 10);
    expect(marked(scroll, ring, 0.6)).toEqual([15]);
    expect(marked(scroll, ring, 0.1)).toEqual([1]);
    expect(marked(scroll, ring, 7)).toEqual([]);
    expect(marked(scroll, ring, 0)).toEqual([0, 1]);
  });

  test("draws all anew when numbers were dropped", () => {
    const ring = ringOf(0.05, 0.15, 0.25);
    const scroll = new Scroll(10, 10);
    marked(scroll, ring, 0);
    ring.forgetFrom(0.2);
    ring.push(0.35, 9);
    expect(scroll.moveTo(0, [ring])).toEqual([0, 10]);
    ring.forgetFrom(0.2);
    expect(marked(scroll, ring, 0)).toEqual([0, 1]);
  });

  test("keeps columns at places that return", () => {
    const scroll = new Scroll(10, 10);
    expect([0, 9, 10, 25, -1].map((column) => scroll.placeOf(column))).toEqual([0, 9, 0, 5, 9]);
  });
});
