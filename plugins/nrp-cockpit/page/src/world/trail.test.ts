import { describe, expect, it } from "vitest";
import { extend, LONGEST, newTrail } from "./trail";

describe("a trail", () => {
  it("leaves out points where the body stood still", () => {
    const trail = newTrail();
    for (let step = 0; step < 10; step++) extend(trail, step, [1, 2, 0]);
    expect(trail.x).toEqual([1]);
    extend(trail, 10, [1.5, 2, 0]);
    expect(trail.x).toEqual([1, 1.5]);
  });

  it("forgets the future when time goes back", () => {
    const trail = newTrail();
    for (let step = 0; step < 10; step++) extend(trail, step, [step, 0, 0]);
    extend(trail, 3.5, [7, 7, 0]);
    expect(trail.t_s).toEqual([0, 1, 2, 3, 3.5]);
    expect(trail.y).toEqual([0, 0, 0, 0, 7]);
  });

  it("begins again after a reset to zero", () => {
    const trail = newTrail();
    for (let step = 1; step < 10; step++) extend(trail, step, [step, 0, 0]);
    extend(trail, 0, [0, 0, 0]);
    expect(trail).toEqual({ x: [0], y: [0], z: [0], t_s: [0] });
  });

  it("keeps both ends when it becomes too long", () => {
    const trail = newTrail();
    for (let step = 0; step < 2 * LONGEST; step++) extend(trail, step, [step, 0, 0]);
    expect(trail.t_s.length).toBeLessThan(LONGEST);
    expect(trail.t_s[0]).toBe(0);
    expect(trail.t_s.at(-1)).toBeGreaterThanOrEqual(2 * LONGEST - 2);
  });
});
