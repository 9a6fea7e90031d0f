import type { Device, Population } from "./types";

export type Role = Population["role"];

/** What a neuron is to the robot: the last part of the name of the device that drives or reads it, else empty. */
export function cellName(neuron: number, devices: readonly Device[]): string {
  const name = devices.find(({ neurons }) => neurons.includes(neuron))?.name ?? "";
  return name.slice(name.lastIndexOf("/") + 1).replaceAll("_", " ");
}

/**
 * The part that each neuron of a population plays: what a device drives is a sensor, what one reads an actor. Other
 * cells of such a population are part of the circuit, unless they are sources of spikes.
 */
export function rolesOf(population: Population, devices: readonly Device[]): Role[] {
  const neuronsOf = (kind: string) =>
    new Set(devices.flatMap((device) => (device.kind === kind ? device.neurons : [])));
  const [read, driven] = [neuronsOf("sink"), neuronsOf("source")];
  const numbers = Array.from({ length: population.size }, (_, index) => population.first + index);
  const isTouched = numbers.some((number) => read.has(number) || driven.has(number));
  const other = isTouched && !population.cell.startsWith("SpikeSource") ? "circuit" : population.role;
  return numbers.map((number) => (read.has(number) ? "actor" : driven.has(number) ? "sensor" : other));
}
