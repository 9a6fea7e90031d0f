import { expect, test } from "vitest";
import { TimeRing } from "../plots/timeRing";
import { curvesCsv, spikesCsv } from "./csv";

const ring = (...pairs: [number, number][]): TimeRing => {
  const made = new TimeRing(16);
  for (const [t_s, value] of pairs) made.push(t_s, value);
  return made;
};

test("curves share a line where they have the same time, and names are quoted where they must be", () => {
  const text = curvesCsv([
    { name: "left, voltage", values: ring([0.02, 1.5], [0.06, 2]) },
    { name: "right", values: ring([0.02, -1], [0.1 - 0.06, 3]) },
  ]);
  expect(text.join("").split("\r\n")).toEqual([
    't_s,"left, voltage",right',
    "0.02,1.5,-1",
    "0.04,,3",
    "0.06,2,",
    "",
  ]);
});

test("spikes stand in the order of time over all populations", () => {
  const text = spikesCsv([
    { name: "eyes", values: ring([0.1, 2], [0.3, 0]) },
    { name: "wheels", values: ring([0.2, 1]) },
  ]);
  expect(text.join("").split("\r\n")).toEqual([
    "t_s,population,cell",
    "0.1,eyes,2",
    "0.2,wheels,1",
    "0.3,eyes,0",
    "",
  ]);
});
