"""A PyNN simulator's state that runs its network in a brain backend."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from math import isfinite
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError
from pyNN.common.control import DEFAULT_MIN_DELAY, DEFAULT_TIMESTEP

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.backends import brains
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS, from_milliseconds, nanoseconds
from nrp_core.errors import CapabilityError, ExperimentError, LifecycleError, NetworkError, did_you_mean
from nrp_core.findings import Findings
from nrp_core.network.changes import Synapses
from nrp_core.network.data import Network
from nrp_core.network.pynn.arguments import require_kind
from nrp_core.network.pynn.export import network_of, unique
from nrp_core.network.pynn.populations import SPIKE_TIMES, ids_of, parts_of
from nrp_core.network.pynn.simulator import State
from nrp_core.network.synapses import PLASTIC
from nrp_core.pynn.currents import Current, Currents, Waveform
from nrp_core.pynn.grid_simulators import ReplacedSimulators
from nrp_core.seeds import Seeds, require_seed

DEFAULT_BACKEND = "event"
_AHEAD = 1_000_000
"""Changes of currents that are computed in advance."""
_SHORTEST_MS = 1.0
"""The shortest run in which something can be seen: cells fire less often, and synapses take about as long."""
_logger = logging.getLogger(__name__)


class Shares:
    """The projections of the network that the projections of a script became.

    A projection between assemblies becomes one for each pair of populations.

    Args:
        state: the state of the script.
        network: the network that runs.
    """

    def __init__(self, state: State, network: Network) -> None:
        self._network = network
        parts = iter(network.projections)
        self._parts = {
            projection: list(islice(parts, len(_owners(projection.pre)) * len(_owners(projection.post))))
            for projection in state.projections
        }
        self._found: dict[Any, list[tuple[str, Any]]] = {}

    def __contains__(self, projection: Any) -> bool:
        return projection in self._parts

    def of(self, projection: Any) -> list[tuple[str, Any]]:
        """Return the label of each share of a script's projection, and the index of its synapses in that."""
        if projection not in self._found:
            self._found[projection] = list(self._split(projection))
        return self._found[projection]

    def _split(self, projection: Any) -> Iterator[tuple[str, Any]]:
        parts = self._parts[projection]
        if len(parts) == 1:  # all of them; a list of these would be larger than the network
            yield parts[0].label, slice(None)
            return
        pre = ids_of(projection.pre)[projection.pre_index]
        post = ids_of(projection.post)[projection.post_index]
        for part in parts:
            inside = _of(self._network, part.pre, pre) & _of(self._network, part.post, post)
            yield part.label, np.flatnonzero(inside)


def _owners(cells: Any) -> set[Any]:
    return {part._owner() for part in parts_of(cells)}


def _of(network: Network, label: str, ids: IntArray) -> npt.NDArray[np.bool_]:
    first = network.offsets[label]
    inside: npt.NDArray[np.bool_] = (ids >= first) & (ids < first + network.populations[label].size)
    return inside


class RunningState(State):
    """The network of a script, and the brain in which it runs.

    The brain is opened when the network first runs. Before that, and after a reset, the network may change;
    while it runs, parameters, spike times and weights may change if the backend supports it.

    Attributes:
        brain: the running brain, or None.
        replaced: the simulators whose place this one takes.
    """

    brain: Brain | None = None

    def __init__(self) -> None:
        self.replaced = ReplacedSimulators()
        self._currents: list[Current] = []
        self._driven: list[Currents] = []
        self._changed = self._is_outgrown = False
        super().__init__(Seeds(0).child("network"))
        self.use(DEFAULT_BACKEND, {}, 0)

    def use(
        self, backend: str, options: Mapping[str, Any], seed: int, *, follows: bool = False, **extra: Any
    ) -> None:
        """Choose where the network runs.

        Args:
            backend: name of an installed brain backend.
            options: its options.
            seed: seed of all random numbers that the script does not seed itself.
            follows: whether a backend's own time step, unless it is among the options, is that of the script.
            extra: arguments of ``setup`` that other simulators take.
        """
        self._setup = extra
        self._backend, self._options, self._seed, self._follows = backend, dict(options), seed, follows
        self._reported, self._warned = Findings(), set[str]()
        self._seeds = Seeds(seed).child("network")
        self._unnamed_streams = 0

    def clear(self) -> None:
        self.close()
        self._currents.clear()
        self._is_outgrown = False
        self._longest_ms = 0.0
        self._retimed: set[str] = set()
        super().clear()

    def close(self) -> None:
        """Release the brain."""
        if self.brain is not None:
            self.brain.close()
        self.brain = None

    def end(self) -> None:
        """Release the brain, and warn of a run too short for anything, or for some of its sources."""
        populations = self.brain.network.populations.values() if self.brain is not None else ()
        for population in (one for one in populations if one.label not in self._retimed):
            first_ms = min((times[0] for times in population.spike_times_ms if len(times)), default=0.0)
            if nanoseconds(first_ms) > from_milliseconds(self._longest_ms):
                late = f"its spike_times begin at {first_ms:g} ms"
                ended = f"the longest run ended at {self._longest_ms:g} ms"
                self.warn([f"no cell of '{population.label}' fired: {late}, and {ended}"])
        if 0.0 < self._longest_ms < _SHORTEST_MS:
            self.warn(
                [f"the longest run ended at {self._longest_ms:g} ms: times are in ms, is it meant in s?"]
            )
        self.warn(self.remarks)
        self.close()

    def before_change(self) -> None:
        if self.brain is None:
            return
        self._is_outgrown = self.t > 0
        self.close()

    def _require_whole(self) -> None:
        """Check that the network was not extended since its last run, except after a reset."""
        if self._is_outgrown:
            raise CapabilityError(
                f"the network cannot change at {self.t:g} ms, while it runs in '{self._backend}'; reset() "
                "first"
            )

    def before_parameters(self, population: Any, index: IntArray, values: Mapping[str, Any]) -> None:
        if SPIKE_TIMES in values and self._longest_ms > 0.0:
            self._retimed.add(population.label)
        brain = self._changing()
        if brain is None:
            return
        ids = int(population.first_id) + index
        if SPIKE_TIMES in values:
            trains = [train.value for train in values[SPIKE_TIMES]]
            brain.set_spike_times(brain.network.label_of(int(population.first_id))[0], trains, index)
        else:
            brain.set_parameters(ids, values)

    def before_synapses(self, projection: Any, values: Mapping[str, FloatArray]) -> None:
        brain = self._changing()
        if brain is None:
            return
        own = getattr(projection.synapse_type, "equations", None)
        of_law = set() if own is None else values.keys() & own.model.parameters.keys()
        fixed = ", ".join(sorted(values.keys() - {"weight"} - of_law))
        if fixed:
            raise CapabilityError(
                f"projection '{projection.label}': {fixed} cannot change at {self.t:g} ms, while the network "
                f"runs in '{self._backend}'; reset() first"
            )
        for label, chosen in self._shares.of(projection):
            if of_law:
                brain.set_synapse_parameters(label, {name: values[name][chosen] for name in of_law})
            if "weight" in values:
                brain.set_weights(label, values["weight"][chosen])

    def weights_of(self, projection: Any) -> FloatArray:
        own = getattr(projection.synapse_type, "equations", None)
        plastic = own.model.is_plastic if own is not None else projection.synapse_type.kind in PLASTIC
        if plastic:
            self._require_whole()
        if self.brain is None or not plastic or projection not in self._shares:
            return super().weights_of(projection)
        weights = np.empty(len(projection))
        for label, chosen in self._shares.of(projection):
            weights[chosen] = self.brain.read_weights(label)
        return weights

    def synapse_state_of(self, projection: Any, name: str) -> FloatArray:
        state = super().synapse_state_of(projection, name)
        if self.brain is not None and projection in self._shares:
            for label, chosen in self._shares.of(projection):
                state[chosen] = self.brain.read_synapse_state(label, name)
        return state

    def synapses_of(self, projection: Any) -> Synapses | None:
        if self.brain is None or projection not in self._shares:
            return None
        ((label, _),) = self._shares.of(projection)
        return self.brain.read_synapses(label)

    def _changing(self) -> Brain | None:
        """Return the brain in which something is about to change, or None if it will be opened again."""
        if self.t == 0:
            self.close()
        self._changed = self.brain is not None
        return self.brain

    def inject(self, source: Any, cells: IntArray) -> None:
        name = f"current/{len(self._currents)}"
        waveforms = (current.waveform for current in self._currents if current.source is source)
        waveform = next(waveforms, None) or Waveform(source, self.stream(name), self.dt)
        current = Current(source, waveform, cells)
        self._currents.append(current)
        if self.brain is not None:
            self._drive([current], name)

    def injected(self) -> list[Any]:
        return [current.source for current in self._currents]

    def current_data(self, source: Any) -> tuple[FloatArray, FloatArray]:
        step_ns, lasted_ns = from_milliseconds(self.dt), from_milliseconds(self.t)
        times_ns = step_ns * np.arange(lasted_ns // step_ns + 1)
        found = (current.sampled_na(times_ns) for current in self._currents if current.source is source)
        return times_ns / NS_PER_MS, next(found, np.zeros(len(times_ns)))

    def reset(self) -> None:
        super().reset()
        if self.brain is not None or self._is_outgrown:
            self._is_outgrown = False
            if (
                self._changed or self.brain is None
            ):  # a reset brain would have its initial parameters; PyNN keeps the changed ones
                self.close()
            else:
                self.brain.reset()
            for device in (*self.recorders, *self._currents):
                device.restart()

    def run_until(self, t_ms: float) -> None:
        """Run the network to ``t_ms``; set currents on the way."""
        if not isfinite(t_ms):
            raise NetworkError(f"run: the time must be finite, not {t_ms:g} ms")
        self._require_whole()
        self._require_network()
        brain = self.brain or self._open()
        until_ns = from_milliseconds(t_ms)
        self.running = True
        self._run_under_currents(brain, until_ns)
        self.t = t_ms
        self._longest_ms = max(self._longest_ms, t_ms)

    def _with_place(self, error: NetworkError) -> NetworkError:
        """Return the error of a backend at the line of the projection that it names, if it names one."""
        names = unique(projection.label for projection in self.projections)
        for name, projection in zip(names, self.projections, strict=True):
            is_named = f"'{name}'" in error.message or f"'{name} (" in error.message  # of assemblies
            if is_named and error.path is None and projection.made_at:
                path, line = projection.made_at
                return NetworkError(error.message, path=path, line=line)
        return error

    def _require_network(self) -> None:
        if self.brain is None and self.t > 0:
            raise LifecycleError("run: end() has released the network; call setup() to start again")

    def _open(self) -> Brain:
        backend = brains().load(self._backend)
        network = network_of(self)
        own: dict[str, str] = {}
        on_grid = any(population.equations is not None for population in network.populations.values())
        on_grid |= any(projection.is_continuous for projection in network.projections)
        if "resolution" in backend.options.model_fields:
            network, own = self.replaced.adapted(network, self.dt, self._setup, self._options)
            if on_grid:
                own = {"resolution": f"{self.dt!r} ms"}
        if self._follows and "timestep" in backend.options.model_fields:
            own["timestep"] = f"{self.dt!r} ms"
            self.replaced.report(f"in steps of {self.dt:g} ms")
        try:
            options = backend.options.model_validate({**own, **self._options})
        except ValidationError as error:
            wrong = [_unknown_option(found, backend.options.model_fields) for found in error.errors()]
            raise ExperimentError(f"options of brain backend '{self._backend}': {'; '.join(wrong)}") from None
        try:
            self.brain = backend.open(network, seed=self._seed, options=options)
        except NetworkError as error:
            raise self._with_place(error) from None
        for warning in self.brain.warnings:
            if warning not in self._reported:  # a reset may open the brain again
                self._reported.append(warning)
                _logger.warning("%s: %s", self._backend, warning.text)
        self.warn(network.remarks)
        self._changed = False
        self._shares = Shares(self, self.brain.network)
        for recorder in self.recorders:
            recorder.start(self.brain)
        self._driven = []
        if self._currents:
            self._drive(self._currents, "currents")
        return self.brain

    def _drive(self, currents: Sequence[Current], name: str) -> None:
        """Let currents drive the cells of the open brain."""
        assert self.brain is not None
        self._driven.append(Currents(currents, name))
        self._driven[-1].start(self.brain)

    def warn(self, sentences: Iterable[str]) -> None:
        """Log warnings, each sentence once."""
        for text in sentences:
            if text not in self._warned:
                self._warned.add(text)
                _logger.warning("%s", text)

    def _run_under_currents(self, brain: Brain, until_ns: int) -> None:
        """Run to ``until``, halting where currents change; these are computed for a while in advance."""
        for currents in self._driven:
            currents.begin(brain.now_ns)
        since_ns = brain.now_ns
        ahead_ns = from_milliseconds(max(self.dt, self.dt * _AHEAD / max(1, len(self._currents))))
        while since_ns < until_ns:
            end_ns = min(until_ns, since_ns + ahead_ns)
            halts = [currents.prepare(since_ns, end_ns) for currents in self._driven]
            last = [until_ns] if end_ns == until_ns else []
            for stop_ns in np.unique(np.concatenate([np.array(last, np.int64), *halts])).tolist():
                brain.run_until(stop_ns)
                for currents in self._driven:
                    currents.update(stop_ns)
            since_ns = end_ns


def _unknown_option(found: Mapping[str, Any], known: Iterable[str]) -> str:
    """Return the mistake in an option, and the option that may be meant."""
    name = ".".join(map(str, found["loc"]))
    unknown = f"'{name}' is not an option{did_you_mean(name, known)}"
    return unknown if found["type"] == "extra_forbidden" else f"{name}: {found['msg']}"


def control(api: ModuleType, state: RunningState) -> Mapping[str, Any]:
    """Return ``setup`` and ``end`` of a simulator that runs its network."""
    begin = api.setup

    def setup(
        timestep: float | None = None,
        min_delay: float | str = DEFAULT_MIN_DELAY,
        *,
        backend: str = DEFAULT_BACKEND,
        options: Mapping[str, Any] | None = None,
        seed: int = 0,
        **extra: Any,
    ) -> int:
        """Discard the network and start again.

        Args:
            timestep: ms; the interval at which state is sampled, and the smallest delay; 0.1 by default. If
                it is given, it is also the step of a backend that has the option ``timestep``.
            min_delay: ms, or ``auto``: the time step.
            backend: name of an installed brain backend.
            options: options of the backend.
            seed: seed of all random numbers that the script does not seed itself.
            extra: ``max_delay``; arguments of other simulators are ignored, as PyNN requires.
        """
        rank: int = begin(DEFAULT_TIMESTEP if timestep is None else timestep, min_delay, **extra)
        require_kind("setup", "backend", backend, str, "the name of a brain backend, such as 'event'")
        require_kind(
            "setup", "options", options, (Mapping, type(None)), "a dictionary such as {'threads': 2}"
        )
        require_seed(seed)
        brains().provider(backend)
        state.use(backend, options or {}, seed, follows=timestep is not None, **extra)
        return rank

    def end(**_: Any) -> None:
        """Write the requested data, and release the brain."""
        for population, variables, filename in state.write_on_end:
            population.write_data(filename, variables)
        state.write_on_end = []
        state.end()

    return {"setup": setup, "end": end}
