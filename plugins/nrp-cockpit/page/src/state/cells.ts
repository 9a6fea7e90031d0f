import type { Device, Population } from "./types";

export type Role = Population["role"];

/** The part that each neuron of a population plays: what a device drives is a sensor, what one reads an actor. */
export function rolesOf(population: Population, devices: readonly Device[]): Role[] {
  const neuronsOf = (kind: string) =>
    new Set(devices.flatMap((device) => (device.kind === kind ? device.neurons : [])));
  const [read, driven] = [neuronsOf("sink"), neuronsOf("source")];
  return Array.from({ length: population.size }, (_, index) => {
    const number = population.first + index;
    if (read.has(number)) return "actor";
    return driven.has(number) ? "sensor" : population.role;
  });
}
