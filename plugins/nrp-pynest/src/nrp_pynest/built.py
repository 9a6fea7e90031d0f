"""The objects of a brain file, and the run that uses them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from types import ModuleType
from typing import Any

import numpy as np

from nrp_core.brain import (
    Brain,
    FloatArray,
    IntArray,
    Network,
    Projection,
    SpikeRecorder,
    SpikeRecorderPort,
    Spikes,
    StateRecorder,
    StateRecorderPort,
)
from nrp_core.clock import NS_PER_MS, nanoseconds
from nrp_core.errors import LifecycleError
from nrp_core.experiment import Run

_STEP_MS = 0.1
"""The time step of a script that sets none, as in PyNN."""


class BuiltBrain:
    """The variables of a brain file, and the running counterparts of their contents.

    Attributes:
        network: the network that the file has built.
        variables: variables of the file, with running cells and synapses.
        show: returns the value of a variable for transfer functions, by its value and name.
        recorded: neurons whose spikes the file records.
        recorded_states: state variables that the file records, each with neurons and the interval of
            samples, ms.
        node_of: returns the number of a neuron's node in NEST.
        nest: the module ``nest`` for this network.
        import_path: ``sys.path`` for the code of the experiment.
        on_begin: called with the run when it begins.
    """

    def __init__(self) -> None:
        self.network = Network({})
        self.variables: Mapping[str, Any] = {}
        self.show: Callable[[Any, str], Any] = lambda value, _name: value
        self.recorded: list[IntArray] = []
        self.recorded_states: list[tuple[str, IntArray, float | None]] = []
        self.node_of: Callable[[int], int] = lambda neuron: neuron + 1
        self.nest: ModuleType | None = None
        self.import_path = list(sys.path)
        self.on_begin: list[Callable[[Run], None]] = []
        self._brain: Brain | None = None
        self._now_ns: Callable[[], int] = lambda: 0
        self._parameters: dict[str, FloatArray] = {}
        self._recorders: list[SpikeRecorderPort] = []
        self._states: list[tuple[float, StateRecorderPort]] = []

    def __reduce__(self) -> tuple[type[BuiltBrain], tuple[()]]:
        """Return the pickled form, which is empty because other processes have no code of it."""
        return BuiltBrain, ()

    def __deepcopy__(self, memo: object) -> BuiltBrain:
        """Return the same object, because only one run exists."""
        return self

    def begin(self, run: Run) -> None:
        """Connect to a run."""
        self.open(run.brain, lambda: run.loop.now_ns)
        run.loop.hooks.after_reset.append(lambda _loop: self._parameters.clear())
        for begin in self.on_begin:
            begin(run)

    def open(self, brain: Brain, now_ns: Callable[[], int]) -> None:
        """Connect to a brain, and record what the file records.

        Args:
            brain: it has the network of the file.
            now_ns: returns its time.
        """
        self.network, self._brain, self._now_ns = brain.network, brain, now_ns
        self._parameters.clear()
        self._recorders.clear()
        self._states.clear()
        for cells in self.recorded:
            self.record(cells)
        for variable, cells, interval_ms in self.recorded_states:
            self.record_state(variable, cells, interval_ms)

    @property
    def is_running(self) -> bool:
        """Whether a brain has the network."""
        return self._brain is not None

    @property
    def brain(self) -> Brain:
        """The brain.

        Raises:
            LifecycleError: none exists yet.
        """
        if self._brain is None:
            raise LifecycleError("the brain can be read and changed only while the simulation runs")
        return self._brain

    @property
    def now_ms(self) -> float:
        """Simulated time."""
        return self._now_ns() / NS_PER_MS

    # -- parameters

    def parameter(self, name: str) -> FloatArray:
        """Return a parameter of all neurons; NaN for those without it."""
        if name not in self._parameters:
            values = np.full(self.network.size, np.nan)
            for label, population in self.network.populations.items():
                values[self.network.ids_of(label)] = population.parameters.get(name, np.nan)
            self._parameters[name] = values
        return self._parameters[name]

    def set_parameters(self, ids: IntArray, values: Mapping[str, Any]) -> None:
        """Change parameters of neurons; ``spike_times`` is one train or one for each."""
        others = dict(values)
        trains = others.pop("spike_times", None)
        if trains is not None:
            self._set_trains(ids, trains)
        if others:
            self.brain.set_parameters(ids, others)
        for name, value in others.items():
            self.parameter(name)[ids] = value

    def _set_trains(self, ids: IntArray, trains: Any) -> None:
        given = [getattr(one, "value", one) for one in getattr(trains, "value", trains)]
        each = given if any(map(np.ndim, given)) else [given] * len(ids)
        for cell, train in zip(ids.tolist(), each, strict=True):
            label, index = self.network.label_of(cell)
            self.brain.set_spike_times(label, [np.sort(np.asarray(train, float))], [index])

    # -- synapses

    def projection(self, label: str) -> Projection:
        """Return a projection."""
        return next(one for one in self.network.projections if one.label == label)

    # -- spikes

    def record(self, ids: IntArray) -> None:
        """Record the spikes of neurons from now on."""
        if any(np.isin(ids, port.neurons).all() for port in self._recorders):
            return
        name = f"brain/recorded/{len(self._recorders)}"
        port = self.brain.add_sink(SpikeRecorder(), ids, name=name)
        assert isinstance(port, SpikeRecorderPort)
        self._recorders.append(port)

    def spikes(self, ids: IntArray) -> Spikes:
        """Return all recorded spikes of neurons, in order; the first call starts the recording."""
        self.record(ids)
        port = next(port for port in self._recorders if np.isin(ids, port.neurons).all())
        spikes = port.spikes()
        chosen = np.isin(spikes.neurons, ids)
        return Spikes(spikes.neurons[chosen], spikes.times_ms[chosen])

    def record_state(self, variable: str, ids: IntArray, interval_ms: float | None = None) -> None:
        """Record a state variable of neurons, if the brain can read it.

        Args:
            variable: its name.
            ids: the neurons.
            interval_ms: between samples; by default the time step of the script.
        """
        every_ms = interval_ms or self.network.timestep_ms or _STEP_MS
        known = self.brain.capabilities.state_variables
        if variable not in known or any(self._covering(variable, ids, interval_ms)):
            return
        name = f"brain/recorded/{variable}/{len(self._states)}"
        port = self.brain.add_sink(StateRecorder(variable, dt=every_ms), ids, name=name)
        assert isinstance(port, StateRecorderPort)
        self._states.append((every_ms, port))

    def states(self, ids: IntArray) -> Iterator[tuple[str, FloatArray, FloatArray]]:
        """Yield each recorded variable of neurons: its name, times (ms), and values, ``(n, n_ids)``."""
        for variable in dict.fromkeys(port.variable for _, port in self._states):
            for port in islice(self._covering(variable, ids), 1):
                times_ms, values = port.samples()
                yield variable, times_ms, values[:, np.searchsorted(port.neurons, ids)]

    def samples(self, variable: str, ids: IntArray, interval_ms: float) -> tuple[FloatArray, FloatArray]:
        """Return times (ms) and samples, ``(n, n_ids)``, of a variable; the first call starts recording."""
        self.record_state(variable, ids, interval_ms)
        for port in self._covering(variable, ids, interval_ms):
            times_ms, values = port.samples()
            return times_ms, values[:, np.searchsorted(port.neurons, ids)]
        return np.empty(0), np.empty((0, len(ids)))

    def _covering(
        self, variable: str, ids: IntArray, interval_ms: float | None = None
    ) -> Iterator[StateRecorderPort]:
        """Yield the recorders of a variable that have all these neurons, in order."""
        for every_ms, port in self._states:
            fits = interval_ms is None or nanoseconds(every_ms) == nanoseconds(interval_ms)
            if fits and port.variable == variable and np.isin(ids, port.neurons).all():
                yield port

    def clear(self, ids: IntArray) -> None:
        """Delete the recordings of single neurons."""
        for port in (*self._recorders, *(port for _, port in self._states)):
            if np.isin(port.neurons, ids).all():
                port.reset()


def to_built_brain(network: Network) -> BuiltBrain:
    """Return the objects of a brain file for a network; empty if only the network exists."""
    built = getattr(network, "built", None) or BuiltBrain()
    built.network = network
    return built
