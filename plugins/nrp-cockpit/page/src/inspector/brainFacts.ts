import type { Device, Experiment, Projection } from "../state/types";

/** The devices that drive or read a neuron, by its number in the whole brain. */
export const devicesOf = (devices: readonly Device[], neuron: number): Device[] =>
  devices.filter(({ neurons }) => neurons.includes(neuron));

/** The smallest, mean and largest weight of a projection; null where its synapses are not listed one by one. */
export function weightsOf({ edges }: Projection): { least: number; mean: number; most: number } | null {
  if (!edges || edges.length === 0) return null;
  const weights = edges.map(([, , weight]) => weight);
  const mean = weights.reduce((sum, weight) => sum + weight, 0) / weights.length;
  return { least: Math.min(...weights), mean, most: Math.max(...weights) };
}

/** The synapses from and to a neuron of a population, in the projections that list theirs. */
export function synapsesOf(experiment: Experiment, population: string, index: number) {
  const count = (end: "pre" | "post", column: 0 | 1) =>
    experiment.projections
      .filter((projection) => projection[end] === population)
      .flatMap(({ edges }) => edges ?? [])
      .filter((edge) => edge[column] === index).length;
  return { from: count("pre", 0), to: count("post", 1) };
}
