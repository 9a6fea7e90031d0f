import { expect, it } from "vitest";
import type { Device, Experiment, Projection } from "../state/types";
import { devicesOf, synapsesOf, weightsOf } from "./brainFacts";

const projection = (pre: string, post: string, edges: Projection["edges"]): Projection => ({
  id: `${pre}-${post}`,
  label: `${pre}-${post}`,
  pre,
  post,
  receptor: "excitatory",
  synapse: "static",
  size: edges?.length ?? 1e6,
  excites: true,
  edges,
});

const fan = projection("a", "b", [
  [0, 0, 1],
  [0, 1, 2],
  [1, 1, 6],
]);

it("weights are summed up where synapses are listed", () => {
  expect(weightsOf(fan)).toEqual({ least: 1, mean: 3, most: 6 });
  expect(weightsOf(projection("a", "b", null))).toBeNull();
  expect(weightsOf(projection("a", "b", []))).toBeNull();
});

it("the synapses of a neuron are counted in its own population only", () => {
  const experiment = {
    projections: [fan, projection("b", "a", [[1, 0, 1]])],
  } as Partial<Experiment> as Experiment;
  expect(synapsesOf(experiment, "a", 0)).toEqual({ from: 2, to: 1 });
  expect(synapsesOf(experiment, "b", 1)).toEqual({ from: 1, to: 2 });
});

it("the devices of a neuron are those that touch its number in the brain", () => {
  const device = (name: string, neurons: number[]): Device => ({
    name,
    neurons,
    topic: `/brain/devices/${name}/rate`,
    population: "a",
    kind: "sink",
    unit: "Hz",
  });
  const found = devicesOf([device("left", [0, 1]), device("right", [2])], 1);
  expect(found.map(({ name }) => name)).toEqual(["left"]);
});
