"""The data that populations record while the network runs."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from pyNN import recording

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SpikeRecorder, SpikeRecorderPort
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds, milliseconds
from nrp_core.errors import NetworkError

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
        self._begin_ns = 0

    # -- called by the running simulation

    @property
    def rhythm_ns(self) -> tuple[int, int] | None:
        """Time of the first sample and sampling interval; None if nothing is sampled."""
        sampled = self.recorded.keys() - {SPIKES}
        return (self._begin_ns, from_milliseconds(self.sampling_interval)) if sampled else None

    def start(self, brain: Brain) -> None:
        """Connect to a brain that was just opened."""
        self._ports = []
        self._listen(self.recorded.get(SPIKES, ()))

    def sample(self, brain: Brain) -> None:
        """Sample the state variables now."""
        for variable in self.recorded.keys() - {SPIKES}:
            ids = np.array(sorted(self.recorded[variable]), dtype=np.int64)
            self._rows.setdefault(variable.name, []).append((ids, brain.read_state(variable.name, ids)))

    def restart(self) -> None:
        """Discard the recorded data: the simulation is back at time 0."""
        self._rows, self._begin_ns = {}, 0
        if self._simulator.state.brain is None:
            self._ports = []

    def get(self, *arguments: Any, **options: Any) -> Any:
        """Return the recorded data as a block of Neo.

        Raises:
            NetworkError: there are no data before a run.
        """
        if not self._simulator.state.running and not list(self.cache):
            raise NetworkError(f"population '{self.population.label}' has no data yet; run first")
        return super().get(*arguments, **options)

    # -- what PyNN's recorder calls

    def _check_sampling_interval(self, sampling_interval: float | None) -> None:
        if sampling_interval is not None and not milliseconds(1) <= sampling_interval < inf:
            raise NetworkError(
                f"population '{self.population.label}': sampling_interval is {sampling_interval} ms; it must "
                "be at least 1 ns, and finite"
            )
        super()._check_sampling_interval(sampling_interval)

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
        lasted_ns = from_milliseconds(self._simulator.state.t) - self._begin_ns
        expected = lasted_ns // from_milliseconds(self.sampling_interval) + 1
        signals = np.full((max(expected, len(rows)), len(wanted)), np.nan)
        for row, (sampled, values) in zip(signals[-len(rows) :], rows, strict=bool(rows)):
            known = np.isin(wanted, sampled)
            row[known] = values[np.searchsorted(sampled, wanted[known])]
        return signals, None

    def _clear_simulator(self) -> None:
        self._stop_listening()
        self._listen(self.recorded.get(SPIKES, ()))
        state = self._simulator.state
        self._rows, self._begin_ns = {}, from_milliseconds(state.t)
        if state.running and state.brain is not None:  # in PyNN the next recording starts now
            self.sample(state.brain)

    def _reset(self) -> None:
        self._stop_listening()
        self._rows = {}

    def _stop_listening(self) -> None:
        brain = self._simulator.state.brain
        for port in self._ports if brain is not None else ():
            brain.remove(port)
        self._ports = []
