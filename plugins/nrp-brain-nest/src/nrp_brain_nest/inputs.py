"""What reaches the cells from outside NEST: the spikes of source cells, and events from devices.

A generator emits a spike at the earliest one step from now, and the spike arrives one step later or more.
So an event arrives at the grid point after its time if it was known a step before; a device's events are,
whose delay is a step or more. Plasticity is not for generators: there each spike takes one step more, to
a relay.
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
        network: it holds them.
        grid: NEST's.
    """

    def __init__(self, nest: Any, network: Network, grid: Grid) -> None:
        self._nest, self._network, self._grid = nest, network, grid
        self._generators = SpikeGenerators(nest, grid, weighted=False)
        self._rows: dict[int | None, tuple[IntArray, IntArray]] = {}

    def nodes(self, label: str, *, copy: int | None) -> IntArray:
        """Return NEST's ids of what emits the spikes of a population, made when first asked for.

        Args:
            label: of the population.
            copy: which of the generators, whose synapses are all of one model in NEST; None for the relays
                that plastic synapses need, whose spikes come one step later.
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
        """Let cells (global ids) emit spikes."""
        steps = self._grid.first_at(times_ms)
        for every, _ in self._rows.values():
            numbers = every[neurons]
            used = numbers >= 0
            if used.any():
                self._generators.send(numbers[used], steps[used], np.ones(int(used.sum())))

    def feed(self, until_step: int) -> None:
        """Give NEST everything up to the end of a window."""
        self._generators.feed(until_step)

    def _relays(self, generators: IntArray) -> IntArray:
        relays = np.array(self._nest.Create("parrot_neuron", generators.size).tolist())
        _link(self._nest, generators, relays, np.ones(relays.size), self._grid)
        return relays


class DeviceInput:
    """Events that devices let arrive at cells: one generator for each cell and receptor that gets any.

    Args:
        nest: the module.
        cells: the targets.
        weights: translates to NEST's.
        grid: NEST's.
    """

    def __init__(self, nest: Any, cells: Cells, weights: Weights, grid: Grid) -> None:
        self._nest, self._cells, self._weights, self._grid = nest, cells, weights, grid
        self._generators = SpikeGenerators(nest, grid, weighted=True)
        self._numbers = np.full((len(RECEPTORS), cells.nodes.size), -1)

    def send(self, events: SynapticEvents, now_step: int) -> None:
        """Let events arrive.

        Raises:
            CapabilityError: NEST has no such synapse on a target.
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
        """Give NEST everything up to the end of a window."""
        self._generators.feed(until_step)


def _link(nest: Any, pre: IntArray, post: IntArray, weights: FloatArray, grid: Grid) -> None:
    """Connect nodes one by one with the shortest delay."""
    synapses = {"weight": weights, "delay": np.full(pre.size, grid.step_ms)}
    nest.Connect(pre, post, "one_to_one", synapses)
