"""Recordings with the times of a machine.

A machine labels the events of a time step with its beginning: a cell that fires in the step from 4 ms to 5 ms
fires at 4 ms, and sources fire at the beginning of a step. A run of 10 steps has 10 samples.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import from_milliseconds
from nrp_core.pynn.recording import Recorder


class LabelledRecorder(Recorder):
    """PyNN's recorder, with the times of a machine."""

    def _get_spiketimes(self, ids: Iterable[Any], clear: bool = False) -> tuple[IntArray, FloatArray]:
        neurons, times = super()._get_spiketimes(ids, clear)
        state = self._simulator.state
        if self.population.celltype.receptor_types:
            return neurons, (np.rint(times / state.dt) - 1) * state.dt
        step_us = round(state.dt * 1000)
        steps = -(np.floor(times * 1000).astype(np.int64) // -step_us)  # as sPyNNaker does
        begun = steps < round(state.t / state.dt)  # the others are of the next step
        return neurons[begun], np.multiply(steps[begun], float(state.dt))

    def _get_all_signals(
        self, variable: Any, ids: Iterable[Any], clear: bool = False
    ) -> tuple[FloatArray, None]:
        signals, _ = super()._get_all_signals(variable, ids, clear)
        lasted_ns = from_milliseconds(self._simulator.state.t) - self._begin_ns
        return signals[: -(-lasted_ns // from_milliseconds(self.sampling_interval))], None
