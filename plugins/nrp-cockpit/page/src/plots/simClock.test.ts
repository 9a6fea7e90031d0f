import { describe, expect, test, vi } from "vitest";
import { SimClock } from "./simClock";

/** A clock, and the times that it went back to. */
function newClock() {
  const clock = new SimClock();
  const back = vi.fn();
  clock.onBack(back);
  return { clock, back };
}

test("data move the time on, but never back", () => {
  const { clock } = newClock();
  clock.run(1, true);
  clock.data(1.5);
  clock.data(1.2);
  expect(clock.now_s).toBe(1.5);
});

describe("the status", () => {
  test("of a run that goes on may lag behind the data", () => {
    const { clock, back } = newClock();
    clock.run(1, true);
    clock.data(1.5);
    clock.run(1.4, true);
    expect(back).not.toHaveBeenCalled();
    expect(clock.now_s).toBe(1.5);
  });

  test("that is earlier than before takes the time back", () => {
    const { clock, back } = newClock();
    clock.run(9, true);
    clock.run(2, true);
    expect(back).toHaveBeenCalledExactlyOnceWith(2);
    expect(clock.now_s).toBe(2);
  });

  test("of a run that stands undoes data that come late from before a seek", () => {
    const { clock, back } = newClock();
    clock.run(9, false);
    clock.run(2, false);
    clock.data(8.9);
    clock.run(2, false);
    expect(back).toHaveBeenCalledTimes(2);
    expect(clock.now_s).toBe(2);
  });

  test("that is rounded otherwise than the data undoes nothing", () => {
    const { clock, back } = newClock();
    clock.data(0.3);
    clock.run(0.29999999999999993, false);
    expect(back).not.toHaveBeenCalled();
  });
});
