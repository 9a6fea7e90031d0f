"""All findings about a run: from before it, from its engines, about failures, and from its observers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

from nrp_core.cle.loop import Failure
from nrp_core.clock import seconds
from nrp_core.dsl.devices import DeviceGroup, SpikeGenerator
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import Variable
from nrp_core.dsl.proprioception import AfferentRates
from nrp_core.experiment.events.events import Times
from nrp_core.experiment.model.event_schema import causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Place, Tree
from nrp_core.experiment.running.result import INTERRUPTED, interruption, state_of
from nrp_core.findings import Code, Finding, Findings, Level
from nrp_core.findings.problems import ordered
from nrp_core.network.data import Network

_HIGHEST_HZ: Final = 1e4
"""The largest rate into a cell; sources of transfer functions seldom stand for all of its synapses."""
_LOWEST_HZ: Final = 1.0
"""The largest rate of a source that hardly drives its cells."""
_OFTEN: Final = 0.2
"""How often a source is in use, as a share of the times that it is set; others wait for something rare."""
_FASTEST_HZ: Final = 2000.0
"""A mean rate of the cells of a population; the fastest neurons fire at 1 kHz (electric fish: M. A. Moortgat
et al., J. Neurophysiol. 79:1158, 1998)."""
_SHORTEST_S: Final = 0.02


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

    Events that wait for one that did not happen are named with it. An event of which that was reported before
    the run is not named again.

    Args:
        experiment: the experiment.
        times: times of the events that happened, ns.
        now_ns: the time reached.
        functions: its transfer functions.
        found: the findings before the run.
        is_over: whether the run has reached the end of the experiment.
    """
    functions = list(functions)
    yield from _find_nan(functions, now_ns)
    yield from _unlikely_rates(functions, is_over=is_over)
    if not is_over:
        return
    yield from _limited_afferents(functions)
    if now_ns > experiment.duration:
        message = (
            f"the run went on to {seconds(now_ns):g} s, and the duration of the experiment is "
            f"{seconds(experiment.duration):g} s"
        )
        yield experiment.place("duration").finding(Code.NRP279, message, Level.WARNING)
    missed = {name: causes_of(name, experiment.events) for name in experiment.events if name not in times}
    reported = [name for name in missed if _is_reported(name, experiment, found)]
    for name, causes in missed.items():
        if missed.keys() & causes and name not in causes:
            continue
        waiting = [other for other, waits in missed.items() if name in waits and other != name]
        after = [f"'{other}'" for other in waiting if other not in reported]
        if name in reported and not after:
            continue
        message = f"the event '{name}' never happened" + (f", and so not {', '.join(after)}" if after else "")
        yield experiment.place("events", name).finding(Code.NRP248, message, Level.WARNING)


def _is_reported(name: str, experiment: Experiment, found: Iterable[Finding]) -> bool:
    """Return whether a finding at one of an event's keys said before the run that it never happens."""
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


def _limited_afferents(functions: Iterable[TransferFunction]) -> Iterator[Finding]:
    """Yield a finding for each group of muscles with afferents whose rate was at a limit almost always."""
    for function in functions:
        for adapter in function.adapters.values():
            rates = adapter.value if isinstance(adapter, Variable) else None
            limited = rates.limited() if isinstance(rates, AfferentRates) else {}
            if rates is not None and limited:
                first, others = next(iter(limited)), len(limited) - 1
                also = f" (at a limit: {others} more of {len(rates.muscles)} muscles)" if others else ""
                message = f"the {rates.kind} rate of '{first}' was {limited[first]} almost all the time{also}"
                yield Finding(Code.NRP297, message, Level.NOTE, subject=function.name)


def _find_nan(functions: Iterable[TransferFunction], now_ns: int) -> Iterator[Finding]:
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
                yield Finding(Code.NRP277, message, Level.WARNING, path, line, subject=function.name)


def too_fast(
    experiment: Experiment, network: Network, spikes: Mapping[str, int], now_s: float
) -> Iterator[Finding]:
    """Yield a finding for each population that fires too often; a source may represent many neurons.

    Args:
        experiment: the experiment that runs.
        network: its network.
        spikes: the number of spikes of each population so far.
        now_s: the simulated time reached, s.
    """
    if now_s < _SHORTEST_S:
        return
    for label, population in network.populations.items():
        rate_hz = spikes.get(label, 0) / population.size / now_s
        if rate_hz > _FASTEST_HZ and not population.is_source:
            message = (
                f"each cell of the population '{label}' fired {rate_hz:.3g} times a second; is a weight or a "
                "current in another unit?"
            )
            place = experiment.place("brain", "model")
            yield place.finding(Code.NRP297, message, Level.WARNING)


Reporter = Callable[[], Iterable[Finding]]
"""Returns findings about a run."""


def problems_of(
    found: Iterable[Finding],
    engines: Iterable[Finding | str],
    ends: Iterable[Finding],
    reporters: Iterable[Reporter],
) -> tuple[Finding, ...]:
    """Return the findings about a run so far, each once, by weight, then by place.

    Args:
        found: findings before the run.
        engines: reports of the engines, which often repeat those before the run, without a place.
        ends: errors that stopped functions or the run; see :func:`ends_of`.
        reporters: other sources of findings.
    """
    all_found = Findings(found)
    known = {(finding.code, finding.message) for finding in all_found}
    all_found += [report for report in Findings(engines) if (report.code, report.message) not in known]
    all_found += ends
    for reporter in reporters:
        all_found += reporter()
    return ordered(all_found)


def not_failed(found: Iterable[Finding], failures: Iterable[Failure]) -> Iterator[Finding]:
    """Yield the findings before a run, except warnings about a line that raised an error."""
    failed = {(failure.path, failure.line) for failure in failures}
    for finding in found:
        if (finding.path, finding.line) not in failed:
            yield finding


def ends_of(failures: Iterable[Failure], error: BaseException | None, now_s: float) -> Iterator[Finding]:
    """Yield a finding for each function that was stopped by an error, and for the end of a run by an error.

    Args:
        failures: the failures of functions.
        error: the error that ended the run, if any; the failure of a function may be its cause.
        now_s: the simulated time reached, s.
    """
    cause = None if error is None else error.__cause__
    for failure in failures:
        yield _quarantine(failure) if failure.error is not cause else _stop(failure)
    if error is not None and not any(failure.error is cause for failure in failures):
        yield _end(error, now_s)


def _quarantine(failure: Failure) -> Finding:
    message = (
        f"the transfer function '{failure.function}' {failure.reason} at {seconds(failure.t_ns):g} s and was "
        f"not called any more{failure.notes}"
    )
    return Finding(
        Code.NRP272, message, Level.WARNING, Path(failure.path), failure.line, subject=failure.function
    )


def _stop(failure: Failure) -> Finding:
    message = f"transfer function '{failure.function}' {failure.reason}{failure.notes}"
    return Finding(
        Code.NRP276, message, Level.WARNING, Path(failure.path), failure.line, subject=failure.function
    )


def _end(error: BaseException, now_s: float) -> Finding:
    if state_of(error) == INTERRUPTED:
        return interruption("interrupted at", now_s)
    text = next(iter(str(error).splitlines()), type(error).__name__)
    return Finding(Code.NRP276, text, Level.WARNING)
