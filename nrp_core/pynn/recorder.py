"""The data that populations record while the network runs."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from neo import Segment
from pyNN import recording

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.checked_arguments import is_number
from nrp_core.brain.devices.sinks import SpikeRecorder, SpikeRecorderPort, StateRecorder, StateRecorderPort
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds, milliseconds, nanoseconds
from nrp_core.errors import NetworkError
from nrp_core.network.pynn.models import own_name
from nrp_core.pynn.spike_trains import SpikeTrains

if TYPE_CHECKING:
    from nrp_core.network.pynn.simulator import Simulator


SPIKES = recording.Variable(name="spikes", location=None, label=None)


class Recorder(recording.Recorder):
    """PyNN's recorder over a brain: devices record spikes, and state variables at intervals."""

    _simulator: Simulator

    def __init__(self, population: Any, file: Any = None) -> None:
        super().__init__(population, file)
        self._ports: list[SpikeRecorderPort] = []
        self._traces: list[StateRecorderPort] = []
        self._begin_ns = 0
        self._since_ms: dict[str, float] = {}

    # -- called by the running simulation

    def start(self, brain: Brain) -> None:
        """Connect to a brain that was just opened."""
        self._ports, self._traces = [], []
        self._warn_of_times_between_steps(brain)
        self._listen_to_all()

    def _warn_of_times_between_steps(self, brain: Brain) -> None:
        step_ns, interval_ns = brain.capabilities.resolution_ns, from_milliseconds(self.sampling_interval)
        has_state = any(variable != SPIKES.name for variable in self._names())
        if has_state and step_ns is not None and interval_ns % step_ns:
            self._simulator.state.warn([
                f"sampling_interval of '{self.population.label}' is {milliseconds(interval_ns):g} ms, and "
                f"there are values every {milliseconds(step_ns):g} ms: the others are NaN"
            ])  # fmt: skip

    def _names(self) -> set[str]:
        return {variable.name for variable in self.recorded}

    def restart(self) -> None:
        """Discard the recorded data: the simulation is back at time 0."""
        self._begin_ns = 0
        self._since_ms.clear()
        if self._simulator.state.brain is None:
            self._ports, self._traces = [], []

    def get(self, variables: Any, *arguments: Any, **options: Any) -> Any:
        """Return the recorded data as a block of Neo.

        Raises:
            NetworkError: the network has not run, so it has no data.
        """
        if not self._simulator.state.running and not list(self.cache):
            raise NetworkError(f"population '{self.population.label}' has no data yet; run first")
        self._simulator.state.warn(self._missing(variables))
        if variables == "all" or not list(self.cache):
            return super().get(variables, *arguments, **options)
        names = {one.name for one in self._localize_variables(variables, None)}
        block = super().get("all", *arguments, **options)
        block.segments = [_only(names, segment, block) for segment in block.segments]
        return block

    def count(self, variable: str, *arguments: Any, **options: Any) -> Any:
        """Return the number of data of each recorded cell."""
        self._simulator.state.warn(self._missing([variable]))
        return super().count(variable, *arguments, **options)

    # -- what PyNN's recorder calls

    def _check_sampling_interval(self, sampling_interval: float | None) -> None:
        if sampling_interval is not None and not (
            is_number(sampling_interval) and milliseconds(1) <= sampling_interval < inf
        ):
            raise NetworkError(
                f"'{self.population.label}': sampling_interval is {sampling_interval!r} ms; it must "
                "be at least 1 ns, and finite"
            )
        super()._check_sampling_interval(sampling_interval)

    def _missing(self, variables: Any) -> Iterator[str]:
        """Yield a sentence for each variable without data: not recorded, or only since the last run."""
        owner, now_ms = f"population '{self.population.label}'", self._simulator.state.t
        recorded = {one.name for one in self.recorded if self.recorded[one]}
        asked = (
            {variables} if isinstance(variables, str) else {getattr(one, "name", one) for one in variables}
        )
        if "all" in asked and not recorded:
            yield f"{owner}: nothing is recorded, so there are no data: call record('spikes') before run()"
        asked = recorded if "all" in asked else {str(one).rpartition(".")[2] for one in asked}
        for name in sorted(asked):
            if name not in recorded:
                yield f"{owner}: '{name}' is not recorded, so there are no data of it: call record('{name}')"
            elif now_ms > 0 and from_milliseconds(self._since_ms.get(name, 0.0)) == from_milliseconds(now_ms):
                yield (
                    f"{owner}: '{name}' is recorded from {now_ms:g} ms on, and nothing has run since: call "
                    "record() before run()"
                )

    def _record(self, variable: Any, new_ids: Iterable[Any], sampling_interval: float | None = None) -> None:
        self._since_ms.setdefault(variable.name, self._simulator.state.t)
        if sampling_interval is not None:
            self.sampling_interval = sampling_interval
        self._listen(variable, new_ids)

    def _listen_to_all(self) -> None:
        for variable, ids in self.recorded.items():
            self._listen(variable, ids)

    def _listen(self, variable: Any, ids: Iterable[Any]) -> None:
        brain = self._simulator.state.brain
        chosen = np.array(sorted(ids), dtype=np.int64)
        if brain is None or not len(chosen):
            return
        name = f"recorder/{self.population.label}/{len(self._ports) + len(self._traces)}"
        if variable == SPIKES:
            self._ports.append(brain.add_sink(SpikeRecorder(), chosen, name=name))
        else:
            begin_ms, dt_ms = milliseconds(self._begin_ns), float(self.sampling_interval)
            spec = StateRecorder(own_name(variable.name), dt_ms, begin=begin_ms)
            self._traces.append(brain.add_sink(spec, chosen, name=name))

    def _spikes(self) -> tuple[IntArray, FloatArray]:
        parts = [port.spikes() for port in self._ports]
        neurons = np.concatenate([np.empty(0, np.int64), *(part.neurons for part in parts)])
        return neurons, np.concatenate([np.empty(0), *(part.times_ms for part in parts)])

    def _get_current_segment(
        self, filter_ids: Any = None, variables: Any = "all", clear: bool = False
    ) -> Any:
        chosen = set(self.recorded) if variables == "all" else set(self.recorded) & set(variables)
        if self._simulator.state.brain is None and not (self._ports or self._traces):
            chosen = set()  # the population is younger than the last run
        segment = super()._get_current_segment(filter_ids, chosen, clear)
        if len(segment.spiketrains):
            ids = np.array(sorted(self.filter_recorded(SPIKES, filter_ids)), dtype=np.int64)
            segment.spiketrains = SpikeTrains(segment.spiketrains, ids)
        for signal in segment.analogsignals:  # as the trains, with PyNN's name until 0.9
            signal.annotate(source_ids=signal.annotations["channel_ids"])
        if not len(segment.analogsignals):
            names = sorted(one.name for one in self.recorded if self.recorded[one])
            segment.description += f"\nThere are no signals here; recorded: {', '.join(names) or 'nothing'}."
        return segment

    def _get_spiketimes(self, ids: Iterable[Any], clear: bool = False) -> tuple[IntArray, FloatArray]:
        neurons, times = self._spikes()
        wanted = np.array([int(cell) for cell in ids], dtype=np.int64)
        chosen = np.isin(neurons, wanted)
        neurons, times = neurons[chosen], times[chosen]
        order = np.lexsort((times, neurons))
        return neurons[order], times[order]

    def _local_count(self, variable: Any, filter_ids: Any = None) -> dict[int, int]:
        cells = sorted(self.filter_recorded(SPIKES, filter_ids))
        owners, _ = self._get_spiketimes(cells)
        first, last = (
            np.searchsorted(owners, np.array(cells, dtype=np.int64), side=s) for s in ("left", "right")
        )
        return dict(zip(map(int, cells), (last - first).tolist(), strict=True))

    def _get_all_signals(
        self, variable: Any, ids: Iterable[Any], clear: bool = False
    ) -> tuple[FloatArray, None]:
        wanted = np.array(list(ids), dtype=np.int64)
        interval_ns = from_milliseconds(self.sampling_interval)
        lasted_ns = from_milliseconds(self._simulator.state.t) - self._begin_ns
        signals = np.full((lasted_ns // interval_ns + 1, len(wanted)), np.nan)
        for port in self._traces:
            if port.variable == own_name(variable.name):
                self._add(port, signals, wanted, interval_ns)
        return signals, None

    def _add(self, port: StateRecorderPort, signals: FloatArray, wanted: IntArray, interval_ns: int) -> None:
        """Copy the samples of a device to the columns of its cells."""
        columns = np.flatnonzero(np.isin(wanted, port.neurons))
        own = np.searchsorted(port.neurons, wanted[columns])
        every = len(columns) == len(wanted) == len(port.neurons)
        for times_ms, values in port.parts():
            since_ns = nanoseconds(times_ms) - self._begin_ns
            regular = since_ns % interval_ns == 0  # a device begins with a sample at any time
            rows = since_ns[regular] // interval_ns
            if every and regular.all() and (np.diff(rows) == 1).all():
                signals[rows[0] : rows[-1] + 1] = values
            else:
                signals[np.ix_(rows, columns)] = values[np.ix_(np.flatnonzero(regular), own)]

    def _clear_simulator(self) -> None:
        self._stop_listening()
        self._begin_ns = from_milliseconds(self._simulator.state.t)  # in PyNN the next recording starts now
        self._listen_to_all()

    def _reset(self) -> None:
        self._stop_listening()

    def _stop_listening(self) -> None:
        brain = self._simulator.state.brain
        for port in (*self._ports, *self._traces) if brain is not None else ():
            brain.remove(port)
        self._ports, self._traces = [], []


def _only(names: set[str], segment: Any, block: Any) -> Any:
    """Return a segment with the data of some variables.

    PyNN 0.13 does so for segments before a reset, but keeps no signal, and empties the segments themselves.
    """
    chosen = Segment(
        name=segment.name,
        description=segment.description,
        rec_datetime=segment.rec_datetime,
        **segment.annotations,
    )
    chosen.block = block
    chosen.analogsignals = [signal for signal in segment.analogsignals if signal.name in names]
    if SPIKES.name in names:
        chosen.spiketrains = segment.spiketrains
    chosen.events = [event for event in segment.events if event.name.partition("_")[0] in names]
    return chosen
