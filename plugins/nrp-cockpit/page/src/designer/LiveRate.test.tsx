// @vitest-environment happy-dom
import { cleanup, render } from "@testing-library/react";
import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { clock } from "../plots/clock";
import { heardOf, spikesOf } from "../plots/spikeStore";
import { useRun } from "../state/run";
import type { Experiment } from "../state/types";
import { wire } from "../wire";
import { LiveRate } from "./LiveRate";

const experiment = {
  populations: [
    { label: "eyes", size: 3 },
    { label: "wheels", size: 2 },
  ],
  groups: [{ name: "left", cells: { eyes: [[0, 1]], wheels: [[1, 2]] } }],
} as unknown as Experiment;

beforeEach(() => {
  vi.spyOn(wire, "subscribe").mockReturnValue(() => undefined);
  useRun.setState({ experiment });
  for (const label of ["eyes", "wheels"]) heardOf(label).begin(0);
  clock.data(2);
  for (let spike = 0; spike < 30; spike++) spikesOf("eyes").push(1.5 + spike / 100, spike % 3);
  spikesOf("wheels").push(1.2, 1);
  spikesOf("wheels").push(1.3, 1);
});
afterEach(() => {
  cleanup();
  vi.restoreAllMocks();
  for (const label of ["eyes", "wheels"]) {
    spikesOf(label).forgetFrom(0);
    heardOf(label).forgetFrom(0);
  }
});

const shown = (name: string) => render(<LiveRate of={name} />).container.textContent;

test("a box shows the mean rate of its cells in the last second, of a population or of a group", () => {
  expect(shown("eyes")).toBe("10 Hz");
  expect(shown("wheels")).toBe("1.0 Hz");
  expect(shown("left")).toBe("6.0 Hz"); // 10 of one eye, 2 of one wheel
});

test("cells that only the drawing has show no rate, and what was not heard is unknown", () => {
  expect(shown("drawn")).toBe("");
  heardOf("wheels").end(1);
  expect(shown("wheels")).toBe("– Hz");
});
