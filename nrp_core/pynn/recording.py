"""What populations record while the network runs."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from pyNN import recording

from nrp_core.brain.interface import Brain
from nrp_core.brain.network import FloatArray, IntArray
from nrp_core.brain.sinks import SpikeRecorder, SpikeRecorderPort
from nrp_core.clock import from_milliseconds

if TYPE_CHECKING:
    from nrp_core.brain.pynn.simulator import Simulator

SPIKES = recording.Variable(name="spikes", location=None, label=None)


class Recorder(recording.Recorder):
    """PyNN's recorder over a brain: spikes from a device, state variables sampled at intervals."""

    _simulator: Simulator

    def __init__(self, population: Any, file: Any = None) -> None:
        super().__init__(population, file)
        self._ports: list[SpikeRecorderPort] = []
        self._rows: dict[str, list[tuple[IntArray, FloatArray]]] = {}

    # -- what the running simulation calls

    @property
    def interval_ns(self) -> int | None:
        """How often to sample, or None where nothing is sampled."""
        sampled = self.recorded.keys() - {SPIKES}
        return from_milliseconds(self.sampling_interval) if sampled else None

    def start(self, brain: Brain) -> None:
        """Listen to a brain that has just been opened."""
        self._ports = []
        self._listen(self.recorded.get(SPIKES, ()))

    def sample(self, brain: Brain) -> None:
        """Take the state variables as they are now."""
        for variable in self.recorded.keys() - {SPIKES}:
            ids = np.array(sorted(self.recorded[variable]), dtype=np.int64)
            self._rows.setdefault(variable.name, []).append((ids, brain.read_state(variable.name, ids)))

    def restart(self) -> None:
        """Forget what was recorded: the simulation is back at time 0."""
        self._rows = {}
        if self._simulator.state.brain is None:
            self._ports = []

    # -- what PyNN's recorder calls

    def _record(self, variable: Any, new_ids: Iterable[Any], sampling_interval: float | None = None) -> None:
        if sampling_interval is not None:
            self.sampling_interval = sampling_interval
        if variable == SPIKES:
            self._listen(new_ids)

    def _listen(self, ids: Iterable[Any]) -> None:
        brain = self._simulator.state.brain
        chosen = np.array(sorted(ids), dtype=np.int64)
        if brain is not None and len(chosen):
            name = f"recorder/{self.population.label}/{len(self._ports)}"
            self._ports.append(brain.add_sink(SpikeRecorder(), chosen, name=name))

    def _spikes(self) -> tuple[IntArray, FloatArray]:
        parts = [port.spikes() for port in self._ports]
        neurons = np.concatenate([np.empty(0, np.int64), *(part.neurons for part in parts)])
        return neurons, np.concatenate([np.empty(0), *(part.times_ms for part in parts)])

    def _get_spiketimes(self, ids: Iterable[Any], clear: bool = False) -> dict[int, FloatArray]:
        neurons, times = self._spikes()
        order = np.lexsort((times, neurons))
        neurons, times = neurons[order], times[order]
        cells = [int(cell) for cell in ids]
        first, last = (np.searchsorted(neurons, cells, side=side) for side in ("left", "right"))
        return {cell: times[i:j] for cell, i, j in zip(cells, first, last, strict=True)}

    def _local_count(self, variable: Any, filter_ids: Any = None) -> dict[int, int]:
        trains = self._get_spiketimes(self.filter_recorded(SPIKES, filter_ids))
        return {cell: len(times) for cell, times in trains.items()}

    def _get_all_signals(
        self, variable: Any, ids: Iterable[Any], clear: bool = False
    ) -> tuple[FloatArray, None]:
        wanted = np.array(list(ids), dtype=np.int64)
        rows = self._rows.get(variable.name, [])
        start_ms = float(self._recording_start_time.magnitude)
        expected = round((self._simulator.state.t - start_ms) / self.sampling_interval) + 1
        signals = np.full((max(expected, len(rows)), len(wanted)), np.nan)
        for row, (sampled, values) in zip(signals[-len(rows) :], rows, strict=bool(rows)):
            known = np.isin(wanted, sampled)
            row[known] = values[np.searchsorted(sampled, wanted[known])]
        return signals, None

    def _clear_simulator(self) -> None:
        self._stop_listening()
        self._listen(self.recorded.get(SPIKES, ()))
        # the state now is the first sample of what follows
        self._rows = {name: rows[-1:] for name, rows in self._rows.items()}

    def _reset(self) -> None:
        self._stop_listening()
        self._rows = {}

    def _stop_listening(self) -> None:
        brain = self._simulator.state.brain
        for port in self._ports if brain is not None else ():
            brain.remove(port)
        self._ports = []
