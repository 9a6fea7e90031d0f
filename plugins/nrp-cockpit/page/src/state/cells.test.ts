import { expect, test } from "vitest";
import { rolesOf } from "./cells";
import type { Device, Population } from "./types";

const population = (more: Partial<Population>): Population => ({
  label: "cells",
  size: 4,
  first: 10,
  cell: "IF_curr_exp",
  role: "circuit",
  positions: null,
  placed: false,
  ...more,
});
const device = (kind: Device["kind"], ...neurons: number[]) => ({ kind, neurons }) as Device;

test("a cell is an actor or a sensor by the devices on it, and not by those on others", () => {
  expect(rolesOf(population({ role: "actor" }), [device("sink", 12)])).toEqual([
    "circuit",
    "circuit",
    "actor",
    "circuit",
  ]);
  expect(rolesOf(population({}), [device("source", 10, 11), device("sink", 13)])).toEqual([
    "sensor",
    "sensor",
    "circuit",
    "actor",
  ]);
});

test("sources of spikes are sensors, also when a device reads some of them", () => {
  const sources = population({ cell: "SpikeSourcePoisson", role: "sensor" });
  expect(rolesOf(sources, [])).toEqual(["sensor", "sensor", "sensor", "sensor"]);
  expect(rolesOf(sources, [device("sink", 10)])).toEqual(["actor", "sensor", "sensor", "sensor"]);
});
