import { expect, test } from "vitest";
import { Spans } from "./spans";
import { curveRow, spikeRow } from "./tables";
import { TimeRing } from "./timeRing";

const ring = (numbers: [number, number][]): TimeRing => {
  const made = new TimeRing(16);
  for (const [t_s, value] of numbers) made.push(t_s, value);
  return made;
};

test("a curve is said by its value and its range in the window", () => {
  const sine = ring([
    [0, 9],
    [1, -2],
    [2, 3],
    [3, 1],
  ]);
  expect(curveRow("x", sine, 1, 3)).toEqual(["x", "1.00", "-2.00", "3.00"]);
  expect(curveRow("x", ring([]), 0, 1)).toEqual(["x", "–", "–", "–"]);
});

test("a rate is a count by cells and seconds, and unknown where spikes were not heard", () => {
  const spikes = ring([
    [0.5, 0],
    [1.5, 1],
    [2.5, 0],
  ]);
  const heard = new Spans();
  heard.begin(0);
  expect(spikeRow({ label: "cells", size: 2 }, spikes, heard, 1, 3)).toEqual(["cells", "2", "2", "0.500 Hz"]);
  heard.end(2);
  expect(spikeRow({ label: "cells", size: 2 }, spikes, heard, 1, 3)[2]).toBe("–");
});
