"""External input to the cells: the spikes of source cells, and events from devices.

A generator emits a spike at least one step from now, and the spike arrives at least one step later. So an
event that is known one step before arrives at the grid point after its time; this holds for devices, whose
delay is at least one step. Generators cannot have plastic synapses: these need a relay, which delays each
spike by one more step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from nrp_core.brain import RECEPTORS, FloatArray, Grid, IntArray, Network, SynapticEvents

from nrp_brain_nest.cells import Cells
from nrp_brain_nest.generators import SpikeGenerators
from nrp_brain_nest.weights import Weights


class SourceCells:
    """The cells of a network that only emit spikes.

    Args:
        nest: the module.
        network: the network.
        grid: NEST's time grid.
    """

    def __init__(self, nest: Any, network: Network, grid: Grid) -> None:
        self._nest, self._network, self._grid = nest, network, grid
        self._generators = SpikeGenerators(nest, grid, weighted=False)
        self._rows: dict[int | None, tuple[IntArray, IntArray]] = {}

    def nodes(self, label: str, *, copy: int | None) -> IntArray:
        """Return the NEST ids of the nodes that emit the spikes of a population, created on demand.

        Args:
            label: the label of the population.
            copy: number of the set of generators, whose synapses all have one NEST model; None for the relays
                of plastic synapses, whose spikes are one step later.
        """
        if copy not in self._rows:
            size = self._network.size
            self._rows[copy] = np.full(size, -1), np.zeros(size, np.int64)
        (numbers, found), ids = self._rows[copy], self._network.ids_of(label)
        if ids.size and numbers[ids[0]] < 0:
            numbers[ids], nodes = self._generators.add(ids.size)
            found[ids] = self._relays(nodes) if copy is None else nodes
        emitters: IntArray = found[ids]
        return emitters

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add spikes of cells (global ids)."""
        steps = self._grid.first_at(times_ms)
        for every, _ in self._rows.values():
            numbers = every[neurons]
            used = numbers >= 0
            if used.any():
                self._generators.send(numbers[used], steps[used], np.ones(int(used.sum())))

    def feed(self, until_step: int) -> None:
        """Pass all input up to the end of a window to NEST."""
        self._generators.feed(until_step)

    def _relays(self, generators: IntArray) -> IntArray:
        relays = np.array(self._nest.Create("parrot_neuron", generators.size).tolist())
        _link(self._nest, generators, relays, np.ones(relays.size), self._grid)
        return relays


class DeviceInput:
    """Events of devices at cells: one generator for each cell and receptor with events.

    Args:
        nest: the module.
        cells: the targets.
        weights: conversion to NEST's weights.
        grid: NEST's time grid.
    """

    def __init__(self, nest: Any, cells: Cells, weights: Weights, grid: Grid) -> None:
        self._nest, self._cells, self._weights, self._grid = nest, cells, weights, grid
        self._generators = SpikeGenerators(nest, grid, weighted=True)
        self._numbers = np.full((len(RECEPTORS), cells.nodes.size), -1)

    def send(self, events: SynapticEvents, now_step: int) -> None:
        """Add events.

        Raises:
            CapabilityError: NEST does not have such a synapse on a target.
        """
        weights = self._weights.onto(events.neurons, events.weights, events.receptor)
        numbers = self._numbers[RECEPTORS.index(events.receptor)]
        if (unknown := numbers[events.neurons] < 0).any():
            new = np.unique(events.neurons[unknown])
            numbers[new], generators = self._generators.add(new.size)
            _link(self._nest, generators, self._cells.nodes[new], np.ones(new.size), self._grid)
        steps = np.maximum(self._grid.first_at(events.times_ms) - 1, now_step + 1)
        self._generators.send(numbers[events.neurons], steps, weights)

    def feed(self, until_step: int) -> None:
        """Pass all input up to the end of a window to NEST."""
        self._generators.feed(until_step)


def _link(nest: Any, pre: IntArray, post: IntArray, weights: FloatArray, grid: Grid) -> None:
    """Connect nodes one by one with the shortest delay."""
    synapses = {"weight": weights, "delay": np.full(pre.size, grid.step_ms)}
    nest.Connect(pre, post, "one_to_one", synapses)
