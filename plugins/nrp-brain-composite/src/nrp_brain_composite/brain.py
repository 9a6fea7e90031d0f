"""A brain whose parts are brains of other backends, which exchange spikes.

The loop, its devices and its recordings see one brain. Between two exchanges each part runs alone; what its
cells fired is then known to the others before it can arrive there. A part that accepts late spikes gets them
at their own times, so exact times stay exact; another one gets them later, over shorter delays.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np

from nrp_brain_composite.cut import Part, cut_network
from nrp_brain_composite.options import CompositeOptions
from nrp_core.brain import (
    Brain,
    BrainCapabilities,
    FloatArray,
    IntArray,
    Network,
    ParameterChange,
    Projection,
    RemoteBrain,
    Spikes,
    SynapticEvents,
)
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError
from nrp_core.findings.refusals import SNAPSHOTS
from nrp_core.network.changes import projection_of


def _of_projection(operation: str) -> Any:
    """Return the method that lets the part with a projection carry out an operation."""

    def forward(self: CompositeBrain, projection: Projection, *arguments: Any) -> Any:
        brain = self._with_label(projection.post)
        return getattr(brain, operation)(projection_of(brain.network, projection.label), *arguments)

    return forward


class CompositeBrain(Brain):
    """A network on several backends.

    Args:
        network: the simulated network.
        seed: the seed of the brain's random numbers; that of each part, too.
        capabilities: those that all parts have.
        options: the parts.

    Raises:
        CapabilityError, NetworkError: the network cannot be cut into these parts, or a part cannot simulate
            its own.
    """

    def __init__(
        self, network: Network, *, seed: int, capabilities: BrainCapabilities, options: CompositeOptions
    ) -> None:
        identity = f"composite:{options.model_dump_json()}"
        super().__init__(network, seed=seed, capabilities=capabilities, identity=identity)
        cut = cut_network(network, options)
        self._options, self._cut, self._reached_ns = options, cut, 0
        self._spikes: list[Spikes] = []
        with ExitStack() as opened:
            self._brains = [opened.enter_context(_open(part, seed)) for part in cut.parts]
            for part, brain in self._parts():
                self.warnings += brain.warnings
                _require_silent_sources(part, brain)
            self._elsewhere = [brain for brain in self._brains if isinstance(brain, RemoteBrain)]
            self._here = [brain for brain in self._brains if not isinstance(brain, RemoteBrain)]
            self._open = opened.pop_all()

    def _parts(self) -> Iterator[tuple[Part, Brain]]:
        return zip(self._cut.parts, self._brains, strict=True)

    # -- a window

    def _do_run_until(self, t_ns: int) -> None:
        interval_ns = self._cut.interval_ns
        while self._reached_ns < t_ns:
            stop_ns = t_ns if interval_ns is None else min(t_ns, self._reached_ns + interval_ns)
            self._run_parts(stop_ns)
            self._reached_ns = stop_ns
            self._exchange()

    def _run_parts(self, t_ns: int) -> None:
        """Run all parts to a time; those in processes of their own run at the same time as the others."""
        for remote in self._elsewhere:
            remote.begin_run(t_ns)
        for brain in self._here:
            brain._do_run_until(t_ns)
        for remote in self._elsewhere:
            remote.end_run()
        for brain in self._brains:
            brain.now_ns = t_ns

    def _exchange(self) -> None:
        """Pass the spikes of each part on to the others."""
        for part, brain in self._parts():
            spikes = brain._do_take_spikes()
            if len(spikes):
                spikes = Spikes(part.ids[spikes.neurons], spikes.times_ms)
                self._spikes.append(spikes)
                if self._cut.interval_ns is not None:
                    self._pass_on(part, spikes, milliseconds(brain.capabilities.spike_lag_ns))

    def _pass_on(self, sender: Part, spikes: Spikes, lag_ms: float) -> None:
        for part, brain in self._parts():
            if part is sender:
                continue
            neurons = part.passed_on[spikes.neurons]
            (chosen,) = (neurons >= 0).nonzero()
            if len(chosen):
                later_ms = milliseconds(part.shift_ns) if part.shift_ns else -lag_ms
                brain._do_fire(neurons[chosen], spikes.times_ms[chosen] + later_ms)

    def _do_take_spikes(self) -> Spikes:
        spikes, self._spikes = self._spikes, []
        return Spikes.merged(spikes)

    # -- input

    def _do_fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        for part, brain in self._parts():
            local = part.local[neurons]
            (chosen,) = (local >= 0).nonzero()
            if len(chosen):
                brain._do_fire(local[chosen], times_ms[chosen])

    def _do_inject(self, events: SynapticEvents) -> None:
        for part, brain in self._parts():
            local = part.local[events.neurons]
            (chosen,) = ((local >= 0) & part.is_own[local]).nonzero()
            if len(chosen):
                brain._do_inject(
                    SynapticEvents(
                        local[chosen], events.times_ms[chosen], events.weights[chosen], events.receptor
                    )
                )

    def _do_set_current(self, currents_na: FloatArray) -> None:
        for part, brain in self._parts():
            brain._do_set_current(np.where(part.is_own, currents_na[part.ids], 0.0))

    # -- state and changes

    def _with_label(self, population: str) -> Brain:
        """Return the brain with a population of cells."""
        owner = self._cut.owners[population]
        return next(brain for part, brain in self._parts() if part.name == owner)

    def _do_read_state(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.empty(len(neurons))
        for part, brain in self._parts():
            local = part.local[neurons]
            chosen = (local >= 0) & part.is_own[local]
            if chosen.any():
                values[chosen] = brain._do_read_state(variable, local[chosen])
        return values

    def _do_set_parameters(self, change: ParameterChange) -> None:
        self._with_label(change.label)._do_set_parameters(change)

    def _do_reward(self, population: str, amount: float) -> None:
        self._with_label(population)._do_reward(population, amount)

    def _do_hold_reward(self, population: str, value: float) -> None:
        self._with_label(population)._do_hold_reward(population, value)

    _do_read_weights = _of_projection("_do_read_weights")
    _do_read_synapses = _of_projection("_do_read_synapses")
    _do_read_rewirings = _of_projection("_do_read_rewirings")
    _do_set_weights = _of_projection("_do_set_weights")
    _do_set_synapse_parameters = _of_projection("_do_set_synapse_parameters")
    _do_set_plastic = _of_projection("_do_set_plastic")
    _do_read_synapse_state = _of_projection("_do_read_synapse_state")

    def _do_reset(self, seed: int) -> None:
        self._spikes, self._reached_ns = [], 0
        for brain in self._brains:
            brain._seed, brain.now_ns = seed, 0
            brain._do_reset(seed)

    def _do_save(self) -> object:
        return self._reached_ns, [brain._do_save() for brain in self._brains]

    def _do_restore(self, saved: Any) -> None:
        self._spikes = []
        self._reached_ns, states = saved
        for brain, state in zip(self._brains, states, strict=True):
            brain.now_ns = self._reached_ns
            brain._do_restore(state)

    def _do_close(self) -> None:
        self._open.close()

    # -- what a part lacks is reported with its name

    def _require_change(self, what: str) -> None:
        for name, part in self._options.parts.items():
            if what not in part.capabilities.changes:
                raise CapabilityError(f"{part.title(name)} cannot change {what} while it runs")

    def _require_snapshot(self) -> None:
        for name, part in self._options.parts.items():
            if not part.capabilities.snapshot:
                raise CapabilityError(f"{part.title(name)} {SNAPSHOTS}")


def _open(part: Part, seed: int) -> Brain:
    backend, options = part.options.loaded
    if part.options.process:
        return RemoteBrain(backend, part.network, seed=seed, options=options, python=sys.executable)
    return backend.open(part.network, seed=seed, options=options)


def _require_silent_sources(part: Part, brain: Brain) -> None:
    """Refuse a part that emits spikes of source cells itself: other parts would not get them.

    Raises:
        CapabilityError: it does.
    """
    for label, population in brain.network.populations.items():
        if population.is_source and brain._emits(population):
            raise CapabilityError(
                f"{part.title} draws the spikes of '{label}' itself; in a composite brain the core draws "
                "them: leave out the option `poisson`"
            )
