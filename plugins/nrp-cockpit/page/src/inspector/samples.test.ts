import { describe, expect, it } from "vitest";
import { extended } from "./samples";

const at = (t_s: number, v_mv = -65) => ({ t_s, v_mv: [v_mv] });

describe("the samples of a membrane", () => {
  it("keep the last seconds, each time once", () => {
    const samples = [0, 1, 2, 3, 4.5].reduce(
      (all, t_s) => extended(all, at(t_s)),
      [] as readonly ReturnType<typeof at>[],
    );
    expect(samples.map(({ t_s }) => t_s)).toEqual([1, 2, 3, 4.5]);
    expect(extended(samples, at(4.5, -50))).toBe(samples);
  });

  it("forget what a way back undid", () => {
    expect(extended([at(1), at(2), at(3)], at(1.5)).map(({ t_s }) => t_s)).toEqual([1, 1.5]);
  });
});
