"""A network in NEST."""

from __future__ import annotations

from typing import Final

import numpy as np
from nrp_core.brain import (
    Brain,
    BrainCapabilities,
    Findings,
    FloatArray,
    Grid,
    IntArray,
    Network,
    ParameterChange,
    Projection,
    Spikes,
    SynapticEvents,
    flushing_subnormals,
)
from nrp_core.clock import milliseconds

from nrp_brain_nest.cells import Cells
from nrp_brain_nest.inputs import DeviceInput, SourceCells
from nrp_brain_nest.kernel import NAME, Kernel
from nrp_brain_nest.options import NestOptions
from nrp_brain_nest.recorder import Recorder
from nrp_brain_nest.synapses import Wiring
from nrp_brain_nest.weights import Weights

_TIME_CONSTANTS: Final = frozenset({"tau_syn_E", "tau_syn_I"})


class NestBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`.

    Spikes are on the grid, at the end of the step in which the threshold was crossed.

    Raises:
        LifecycleError: another brain of this process uses NEST.
        CapabilityError, NetworkError: NEST cannot simulate the network.
    """

    def __init__(
        self, network: Network, seed: int, capabilities: BrainCapabilities, options: NestOptions
    ) -> None:
        identity = f"nest:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._grid = Grid(options.resolution, NAME)
        self._kernel = Kernel(self._grid, options.threads)
        try:
            self.warnings += self._build()
        except BaseException:
            self._kernel.release()
            raise

    def _build(self) -> Findings:
        """Build the network in an empty kernel; return warnings about NEST's deviations from it."""
        network, grid = self.network, self._grid
        self._reached_ns = 0
        delays = [grid.delays(p.delay_ms).max() for p in network.projections if p.size]
        self._nest = nest = self._kernel.start(float(grid.time_ms(np.max(delays, initial=0))))
        self._cells, weights = Cells(nest, network), Weights(network)
        self._source_cells = SourceCells(nest, network, grid)
        self._device_input = DeviceInput(nest, self._cells, weights, grid)
        self._weights = weights
        self._wiring = wiring = Wiring(nest, network, self._cells, self._source_cells, weights, grid)
        for projection in network.projections:
            wiring.connect(projection)
        self._recorder = Recorder(nest, self._cells.nodes, grid)
        self._recorder.listen(self._cells.nodes[self._cells.nodes > 0])
        return wiring.warnings

    def _do_run_until(self, t_ns: int) -> None:
        until = self._grid.number_of(t_ns)
        self._source_cells.feed(until)
        self._device_input.feed(until)
        # not Prepare and Run: between those a recorder cannot be emptied
        with flushing_subnormals():  # silent cells decay to such numbers, and the kernel's threads inherit it
            self._nest.Simulate(milliseconds(t_ns - self._reached_ns))
        self._reached_ns = t_ns

    def _do_take_spikes(self) -> Spikes:
        return self._recorder.take()

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        self._source_cells.fire(neurons, times_ms)

    def _do_inject(self, events: SynapticEvents) -> None:
        self._device_input.send(events, self._grid.number_of(self.now_ns))

    def _do_set_current(self, currents_na: FloatArray) -> None:
        self._cells.set_currents(currents_na)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        return self._cells.read(variable, neurons)

    def _do_set_parameters(self, change: ParameterChange) -> None:
        now = self._cells.changed(change)
        self._weights.check_receptors(change.label, now)
        self._cells.set_parameters(change)
        if not _TIME_CONSTANTS.isdisjoint(change.values):
            self._wiring.renew_decay(change.label, now)

    def _do_read_weights(self, projection: Projection) -> FloatArray:
        return self._wiring.read_weights(projection)

    def _do_reward(self, population: str, amount: float) -> None:
        self._wiring.reward(population, amount, self._reached_ns)

    def _do_hold_reward(self, population: str, value: float) -> None:
        self._wiring.hold_reward(population, value, self._reached_ns)

    def _do_read_synapse_state(self, projection: Projection, variable: str) -> FloatArray:
        return self._wiring.read_state(projection, variable)

    def _do_set_weights(self, projection: Projection, weights: FloatArray) -> None:
        self._wiring.set_weights(projection, weights)

    def _do_reset(self, seed: int) -> None:
        self._build()

    def _do_close(self) -> None:
        self._kernel.release()
