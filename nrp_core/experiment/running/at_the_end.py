"""Findings about where a run got to: lost numbers, unlikely rates, events that never happened, its time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from nrp_core.clock import seconds
from nrp_core.dsl.devices import DeviceGroup, SpikeGenerator
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import Variable
from nrp_core.experiment.events.conditions import Times
from nrp_core.experiment.model.event_schema import causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.tree import Place, Tree
from nrp_core.findings import Code, Finding, Level

_HIGHEST_HZ: Final = 1e4
"""The largest rate into a cell; sources of transfer functions seldom stand for all of its synapses."""
_LOWEST_HZ: Final = 1.0
"""The largest rate of a source that hardly drives its cells."""
_OFTEN: Final = 0.2
"""How often a source is in use, as a share of the times that it is set; others wait for something rare."""


def at_the_end(
    experiment: Experiment,
    times: Times,
    now_ns: int,
    functions: Iterable[TransferFunction],
    found: Iterable[Finding] = (),
    *,
    is_over: bool,
) -> Iterator[Finding]:
    """Yield the variables that are NaN by now, unlikely rates, and events that cannot happen any more.

    Events that wait for one that did not happen are named with it. An event of which that was said before the
    run is not named again.

    Args:
        experiment: the experiment.
        times: times of the events that happened, ns.
        now_ns: the time reached.
        functions: its transfer functions.
        found: the findings before the run.
        is_over: whether the run has reached the end of the experiment.
    """
    functions = list(functions)
    yield from _lost_numbers(functions, now_ns)
    yield from _unlikely_rates(functions, is_over=is_over)
    if not is_over:
        return
    if now_ns > experiment.duration:
        message = (
            f"the run went on to {seconds(now_ns):g} s, and the duration of the experiment is "
            f"{seconds(experiment.duration):g} s"
        )
        yield experiment.place("duration").finding(Code.NRP353, message, Level.WARNING)
    missed = {name: causes_of(name, experiment.events) for name in experiment.events if name not in times}
    told = [name for name in missed if _is_told(name, experiment, found)]
    for name, causes in missed.items():
        if missed.keys() & causes and name not in causes:
            continue
        waiting = [other for other, waits in missed.items() if name in waits and other != name]
        after = [f"'{other}'" for other in waiting if other not in told]
        if name in told and not after:
            continue
        message = f"the event '{name}' never happened" + (f", and so not {', '.join(after)}" if after else "")
        yield experiment.place("events", name).finding(Code.NRP322, message, Level.WARNING)


def _is_told(name: str, experiment: Experiment, found: Iterable[Finding]) -> bool:
    """Return whether it was said before the run that an event never happens, at one of its keys."""
    written = experiment.source.at("events", name)
    places = [] if written is None else [*_places(written)]
    return any(one.code is Code.NRP248 and _is_at(one, place) for one in found for place in places)


def _places(tree: Tree) -> Iterator[Place]:
    yield tree.place
    for child in tree.value.values() if isinstance(tree.value, dict) else ():
        yield from _places(child)


def _is_at(finding: Finding, place: Place) -> bool:
    if place.override is not None:
        return place.finding(finding.code, "").message in finding.message
    return (finding.path, finding.line, finding.column) == (place.path, place.line, place.column)


def _unlikely_rates(functions: Iterable[TransferFunction], *, is_over: bool) -> Iterator[Finding]:
    """Yield a finding for each source whose rates are those of no neuron, and probably in another unit."""
    for function in functions:
        for name, adapter in function.adapters.items():
            devices = adapter if isinstance(adapter, DeviceGroup) else [adapter]
            asked = [one.port.asked for one in devices if isinstance(one, SpikeGenerator)]
            if not asked:
                continue
            most_hz, meant = max(one.most_hz for one in asked), ""
            is_in_use = sum(one.positive for one in asked) > _OFTEN * sum(one.count for one in asked)
            if most_hz > _HIGHEST_HZ:
                meant = f"reached {most_hz:.3g} Hz; is it meant in mHz?"
            elif is_over and is_in_use and min(one.least_hz for one in asked) < most_hz < _LOWEST_HZ:
                meant = f"changed and was never more than {most_hz:.2g} Hz; is it meant in kHz?"
            if meant:
                message = f"the rate of '{name}' in '{function.name}' {meant}"
                path, line = Path(function.place.path), function.place.line
                yield Finding(Code.NRP297, message, Level.WARNING, path, line, subject=function.name)


def _lost_numbers(functions: Iterable[TransferFunction], now_ns: int) -> Iterator[Finding]:
    """Yield a finding for each variable that has become NaN, as after ``np.mean([])``."""
    for function in functions:
        for name, adapter in function.adapters.items():
            if isinstance(adapter, Variable) and adapter.is_lost:
                message = (
                    f"the variable '{name}' of '{function.name}' is nan, not a number, at "
                    f"{seconds(now_ns):g} s: every comparison with it is false, and everything computed with "
                    "it is nan"
                )
                path, line = Path(function.place.path), function.place.line
                yield Finding(Code.NRP354, message, Level.WARNING, path, line, subject=function.name)
