"""A network on a grid of times."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from nrp_brain_event.backend import EventOptions
from nrp_brain_event.cell_types import diverged, require_variable
from nrp_brain_event.grid.advance import run, set_currents
from nrp_brain_event.grid.loader import build_grid, changing, enlarged
from nrp_brain_event.grid.poisson import drawable
from nrp_brain_event.grid.readout import lost_row, read
from nrp_brain_event.grid.records import Grid
from nrp_brain_event.grid.runs import input_lines
from nrp_brain_event.records import DIVERGED, FULL
from nrp_core.brain.grid import Grid as TimeGrid
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.limits import distinct
from nrp_core.brain.network import FloatArray, IntArray, Network, Population
from nrp_core.brain.spikes import Spikes, SynapticEvents

_PATIENCE_NS: Final = 20_000_000
_EXACT_MS: Final = 1e-6


class GridBrain(Brain):
    """See :class:`~nrp_core.brain.interface.Brain`."""

    _grid: Grid
    _fired: IntArray
    """Steps and global ids of source spikes to come, shape ``(2, n)``."""
    _inputs: IntArray
    """Steps and lines of what devices send, shape ``(2, n)``; its weights are apart."""
    _weights: FloatArray

    def __init__(
        self,
        network: Network,
        seed: int,
        capabilities: BrainCapabilities,
        options: EventOptions,
        resolution_ns: int,
    ) -> None:
        self._drawn = drawable(network) if options.poisson == "grid" else frozenset()
        self._times = TimeGrid(resolution_ns, "the grid")
        identity = f"event:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        self._initial, self._row_of = build_grid(network, options.tolerance, self._times, self._drawn)
        self._lines = input_lines(self._initial.runs, self._initial.state)
        self._warn_of_rounding()
        self._start()

    def _do_run_until(self, t_ns: int) -> None:
        until, stop = self._times.number_of(t_ns), int(self._grid.clock["step"][0])
        patience = -(-_PATIENCE_NS // self._times.step_ns)
        self._listen_to_noise()
        with np.errstate(over="ignore", invalid="ignore"):  # of hashes; of the voltage of refractory cells
            while stop < until:  # compiled code cannot be interrupted, so it comes back now and then
                stop = min(stop + patience, until)
                while (status := run(self._grid, self._fired, self._inputs, self._weights, stop)) == FULL:
                    self._grid = enlarged(self._grid)
                if status == DIVERGED:
                    raise diverged(self.network, int(self._grid.clock["failed"][0]), t_ns)
        self._drop_used()
        lost = lost_row(self._grid)
        if lost >= 0:
            raise diverged(self.network, int(self._grid.ids[lost]), t_ns)

    def _do_take_spikes(self) -> Spikes:
        clock = self._grid.clock
        steps, neurons = self._grid.spikes[:, : int(clock["n_spikes"][0])]
        clock["n_spikes"] = 0
        return Spikes(neurons.copy(), self._times.time_ms(steps))

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        fired = np.concatenate([self._fired, np.stack([self._times.first_at(times_ms), neurons])], axis=1)
        self._fired = fired.take(np.lexsort((fired[1], fired[0])), axis=1)

    def _do_inject(self, events: SynapticEvents) -> None:
        lines = self._lines[int(events.receptor == "inhibitory"), self._row_of[events.neurons]]
        steps = np.maximum(self._times.first_at(events.times_ms), self._grid.clock["step"] + 1)
        inputs = np.concatenate([self._inputs, np.stack([steps, lines])], axis=1)
        weights = np.concatenate([self._weights, events.weights])
        order = np.lexsort((weights, inputs[1], inputs[0]))  # so that sums are the same however it came
        self._inputs, self._weights = inputs.take(order, axis=1), weights[order]

    def _do_set_current(self, currents_na: FloatArray) -> None:
        if not set_currents(self._grid, self._offsets + currents_na[self._grid.ids]):
            raise diverged(self.network, int(self._grid.clock["failed"][0]), self.now_ns)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        require_variable(self.network, variable, neurons)
        return read(self._grid, self._row_of[neurons], variable)

    def _do_reset(self, seed: int) -> None:
        self._start()

    def _start(self) -> None:
        self._grid = self._initial._replace(**changing(self._initial))
        self._offsets = np.where(self._grid.cell_rows < 0, self._grid.drive, 0.0)
        self._fired = np.empty((2, 0), np.int64)
        self._inputs = np.empty((2, 0), np.int64)
        self._weights = np.empty(0)
        for noise in self._grid.noise:
            label, _ = self.network.label_of(int(self._grid.noise_ids[noise["first"]]))
            noise["key"] = self._seeds.integer(f"population/{label}", 62)

    def _do_save(self) -> object:
        return changing(self._grid), self._fired, self._inputs, self._weights

    def _do_restore(self, saved: Any) -> None:
        arrays, self._fired, self._inputs, self._weights = saved
        self._grid = self._initial._replace(**arrays)

    def _do_close(self) -> None:
        del self._grid, self._initial

    def _emits(self, population: Population) -> bool:
        return population.label in self._drawn

    def _drop_used(self) -> None:
        """Forget the spikes and inputs that have been used."""
        clock = self._grid.clock
        n_fired, n_inputs = int(clock["n_sources"][0]), int(clock["n_inputs"][0])
        clock["n_sources"] = clock["n_inputs"] = 0
        if n_fired:
            self._fired = self._fired[:, n_fired:].copy()
        if n_inputs:
            self._inputs, self._weights = self._inputs[:, n_inputs:].copy(), self._weights[n_inputs:].copy()

    def _listen_to_noise(self) -> None:
        """Let the spikes of Poisson cells that the grid draws be reported where somebody listens."""
        for noise in self._grid.noise:
            own = self._grid.noise_ids[noise["first"] : noise["last"]]
            low, high = own.min(), own.max()
            heard = (sink.neurons for sink in self._sinks)
            noise["heard"] = any(((ids >= low) & (ids <= high)).any() for ids in heard)

    def _warn_of_rounding(self) -> None:
        for projection in self.network.projections:
            delays = distinct(projection.delay_ms)
            if (abs(self._times.time_ms(self._times.delays(delays)) - delays) > _EXACT_MS).any():
                self.warnings.append(
                    f"delays of projection '{projection.label}' are rounded to the grid of "
                    f"{self._times.step_ms:g} ms, to at least one step"
                )
