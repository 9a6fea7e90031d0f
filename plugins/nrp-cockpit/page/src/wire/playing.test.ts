import { expect, it } from "vitest";
import { Playing } from "./playing";

const MS = 1e6;
const playing = () => new Playing({ begin_ns: 0, end_ns: 1000 * MS, timestep_ns: 20 * MS });

it("plays at its pace in whole steps, and loses no part of a step", () => {
  const one = playing();
  one.play();
  expect(one.advance(15)).toBe(false);
  expect(one.advance(15)).toBe(true); // 30 ms are due
  expect(one.now_ns).toBe(20 * MS);
  one.advance(15); // and the other 10 of them
  expect(one.now_ns).toBe(40 * MS);
  one.pace = 2;
  one.advance(10);
  expect(one.now_ns).toBe(60 * MS);
});

it("catches up at most a tenth of a second", () => {
  const one = playing();
  one.play();
  one.advance(5000);
  expect(one.now_ns).toBe(100 * MS);
});

it("stops where it was to run to, and at the end", () => {
  const one = playing();
  one.runTo(30 * MS);
  one.advance(90);
  expect([one.now_ns, one.state]).toEqual([40 * MS, "paused"]);
  one.pace = null;
  one.play();
  while (one.advance(0));
  expect([one.now_ns, one.state]).toEqual([1000 * MS, "finished"]);
  expect(() => one.play()).toThrow("the run has ended");
});

it("seeks the step at or after a time, within the recording", () => {
  const one = playing();
  one.seek(0.49e9);
  expect(one.now_ns).toBe(500 * MS);
  one.step(-1);
  expect(one.now_ns).toBe(480 * MS);
  one.seek(7e9);
  expect([one.now_ns, one.state]).toEqual([1000 * MS, "finished"]);
  one.seek(-1e9);
  expect([one.now_ns, one.state]).toEqual([0, "paused"]);
});
