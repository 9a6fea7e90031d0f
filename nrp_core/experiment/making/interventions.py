"""Interventions in the brain of an experiment, and controls of its wiring."""

from __future__ import annotations

from collections.abc import Container
from contextlib import suppress
from functools import partial
from math import inf
from operator import is_
from typing import Final

import numpy as np

from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError, NetworkError, NeuronSelectionError
from nrp_core.experiment.events.events import Action, At, Events, Times
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.variant_schema import ActivateSection
from nrp_core.findings import Code, Level
from nrp_core.network.changes import WEIGHTS
from nrp_core.network.data import Network
from nrp_core.network.interventions import Intervention, Synapses
from nrp_core.scene.bodies import free_name
from nrp_core.seeds import Seeds

_KEYS: Final = ("brain", "interventions")
_PERCENT: Final = 20.0
"""A factor for weights that is more likely a percentage."""


def with_variants(network: Network, experiment: Experiment, collector: Collector) -> Network:
    """Return the network after an experiment's controls and its interventions from the start.

    Errors go to the collector, including those in later interventions.
    """
    has_synapses = any(projection.size for projection in network.projections)  # before a run it has none
    whole = network = _with_controls(network, experiment, collector)
    for i, intervention in enumerate(experiment.brain.interventions):
        with collector.during(Code.NRP202, *_KEYS, i, always=True):
            change, idle = intervention.change, intervention.idle(experiment.duration)
            if idle:
                message = f"'{intervention.name}' has no effect: it {idle}"
                collector.add(Code.NRP279, message, *_KEYS, i, level=Level.WARNING)
            if change is None:
                assert intervention.activate is not None
                continue
            if change.factor >= _PERCENT:
                message = f"'{intervention.name}' multiplies weights by {change.factor:g}; is it in percent?"
                collector.add(Code.NRP297, message, *_KEYS, i, level=Level.WARNING)
            synapses = change.synapses(network)
            if not synapses and has_synapses and not idle:
                message = f"'{intervention.name}' affects no synapse"
                collector.add(Code.NRP279, message, *_KEYS, i, level=Level.WARNING)
            if intervention.at == 0:
                network = change.of(network, synapses)
            else:
                _require_lasting(network, synapses, intervention.name)
    _report_cut(whole, network, experiment, collector)
    return network


def _with_controls(network: Network, experiment: Experiment, collector: Collector) -> Network:
    """Return the network after an experiment's controls."""
    seeds = Seeds(experiment.seed).child("controls")
    for i, section in enumerate(experiment.brain.controls):
        keys = ("brain", "controls", i)
        with collector.during(Code.NRP202, *keys, always=True):
            before, network = network, section.control(network, seeds.child(str(i)))
            same = map(is_, before.projections, network.projections)
            if any(projection.size for projection in before.projections) and all(same):
                raise NetworkError(f"'{section.name}' changes nothing: every synapse stays the same")
    return network


def _report_cut(whole: Network, network: Network, experiment: Experiment, collector: Collector) -> None:
    """Report interventions that act only where others have cut all synapses.

    Args:
        whole: the network before the interventions.
        network: the network after those from the start.
        experiment: the experiment.
        collector: receives the findings.
    """
    cut: dict[str, Synapses] = {}
    for i, intervention in sorted(enumerate(experiment.brain.interventions), key=lambda one: one[1].at):
        selected: dict[str, Synapses] = {}
        left: dict[str, Synapses] = {}
        change = intervention.change or Intervention(intervention.driven, None)
        with suppress(NeuronSelectionError):  # already reported
            if intervention.change is None or intervention.at > 0:
                left = change.synapses(network)
                selected = change.synapses(whole) if intervention.change is None else left
        if selected and all(cut.get(label, ~mask)[mask].all() for label, mask in left.items()):
            message = f"'{intervention.name}' has no effect: other interventions have cut all these synapses"
            collector.add(Code.NRP279, message, *_KEYS, i, level=Level.WARNING)
        elif intervention.change is not None and change.factor == 0:
            cut |= {label: cut.get(label, mask) | mask for label, mask in selected.items()}


def _driven(network: Network, section: ActivateSection) -> list[str]:
    """Return the labels of the populations with cells that are activated."""
    neurons = network.neurons(section.cells)
    return [label for label in network.populations if np.isin(network.ids_of(label), neurons).any()]


def check_capabilities(experiment: Experiment, capabilities: BrainCapabilities, collector: Collector) -> None:
    """Check that a brain can change weights during a run, if the experiment needs it."""
    for i, intervention in enumerate(experiment.brain.interventions):
        if intervention.at and intervention.change and WEIGHTS not in capabilities.changes:
            with collector.during(Code.NRP202, *_KEYS, i):
                raise CapabilityError(
                    f"'{experiment.brain.backend}' cannot change weights during a run, so "
                    f"'{intervention.name}' can act only from the start: leave out 'at'"
                )


class Interventions:
    """The interventions of a run: devices that drive cells, and events that change weights.

    Args:
        experiment: the experiment.
        brain: its brain.
        events: receives an event for each change during the run.
    """

    def __init__(self, experiment: Experiment, brain: Brain, events: Events) -> None:
        self._actions: dict[str, Action] = {}
        taken = set(experiment.events)
        for intervention in experiment.brain.interventions:
            name = free_name(intervention.name, taken)
            taken.add(name)
            change = intervention.change
            if intervention.activate is not None:
                _drive(brain, intervention.activate, intervention.at, name)
            elif change is not None and intervention.at > 0:
                action = partial(_apply, change, brain)
                self._actions[name] = action
                events.add(name, At(intervention.at), (action,))

    def reset(self, times: Times) -> None:
        """Apply the changes of past events again to a brain that was reset alone."""
        for name, action in self._actions.items():
            if name in times:
                action()


def _drive(brain: Brain, section: ActivateSection, at_ns: int, name: str) -> None:
    network = brain.network
    neurons = network.neurons(section.cells)
    receptor = "excitatory" if section.weight >= 0 else "inhibitory"
    driven = [network.populations[label] for label in _driven(network, section)]
    source = PoissonSource(
        rate=section.rate,
        weight=abs(section.weight) if all(one.is_conductance_based for one in driven) else section.weight,
        receptor_type=receptor,
        start=milliseconds(at_ns),
        duration=inf if section.duration is None else milliseconds(section.duration),
    )
    brain.add_source(source, neurons, name=f"intervention/{name}")


def _apply(change: Intervention, brain: Brain) -> None:
    for label, synapses in change.synapses(brain.network).items():
        weights = brain.read_weights(label)
        weights[synapses] *= change.factor
        brain.set_weights(label, weights)


def _require_lasting(network: Network, affected: Container[str], name: str) -> None:
    for projection in (one for one in network.projections if one.label in affected):
        why = ""
        if projection.rewiring is not None:
            why = "has synapses that form and vanish"
        elif projection.neuromodulation is not None:
            why = f"has the constant weights of a {projection.receptor}"
        elif projection.is_plastic:
            why = "is plastic and would recover"
        if why:
            raise NetworkError(
                f"'{name}' changes weights during the run, but projection '{projection.label}' {why}; "
                "leave out 'at'"
            )
