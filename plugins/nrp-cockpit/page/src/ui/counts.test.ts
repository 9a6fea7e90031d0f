import { expect, it } from "vitest";
import { counted, thousands } from "./counts";

it("commas stand where the browser puts them", () => {
  for (const count of [0, 7, 999, 1000, 15080, 138639, 15081234])
    expect(thousands(count)).toBe(count.toLocaleString("en"));
});

it("only one thing is singular", () => {
  expect([0, 1, 1000].map((count) => counted(count, "cell"))).toEqual(["0 cells", "1 cell", "1,000 cells"]);
});
