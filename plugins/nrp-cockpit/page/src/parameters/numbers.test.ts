import { expect, test } from "vitest";
import { type ChangeableNumber, LatestOnly, shortened, stepOf } from "./numbers";

const number = (low: number, high: number, whole = false): ChangeableNumber => ({
  name: "",
  value: null,
  low,
  high,
  whole,
  note: "",
});

test.each([
  [number(0, 500), 5],
  [number(-70, -30), 0.2],
  [number(0, 0.05), 0.0005],
  [number(0, 20, true), 1],
  [number(0, 2000, true), 10],
])("a slider has steps that people can read", (given, step) => {
  expect(stepOf(given)).toBe(step);
});

test("a number has no more digits than it was given", () => {
  expect(shortened(0.1 + 0.2)).toBe(0.3);
});

test("of what is asked while the server is busy, only the last is asked for", async () => {
  const asked: number[] = [];
  const latest = new LatestOnly();
  let free: () => void = () => undefined;
  const ask = (value: number) =>
    latest.ask(() => {
      asked.push(value);
      return new Promise<void>((resolve) => {
        free = resolve;
      });
    });
  const done = ask(1);
  void ask(2);
  void ask(3);
  expect(asked).toEqual([1]);
  free();
  await Promise.resolve();
  await Promise.resolve();
  expect(asked).toEqual([1, 3]);
  free();
  await done;
});
