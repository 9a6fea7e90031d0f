"""Findings about where a run got to: lost numbers, events that never happened, time beyond its duration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from nrp_core.clock import seconds
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.variables import Variable
from nrp_core.experiment.events.conditions import Times
from nrp_core.experiment.model.event_schema import causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level


def at_the_end(
    experiment: Experiment,
    times: Times,
    now_ns: int,
    functions: Iterable[TransferFunction],
    *,
    is_over: bool,
) -> Iterator[Finding]:
    """Yield a finding for each variable that is NaN by now, and for events that cannot happen any more.

    Events that wait for one that did not happen are named with it.

    Args:
        experiment: the experiment.
        times: times of the events that happened, ns.
        now_ns: the time reached.
        functions: its transfer functions.
        is_over: whether the run has reached the end of the experiment.
    """
    yield from _lost_numbers(functions, now_ns)
    if not is_over:
        return
    if now_ns > experiment.duration:
        message = (
            f"the run went on to {seconds(now_ns):g} s, and the duration of the experiment is "
            f"{seconds(experiment.duration):g} s"
        )
        yield experiment.place("duration").finding(Code.NRP353, message, Level.WARNING)
    missed = {name: causes_of(name, experiment.events) for name in experiment.events if name not in times}
    for name, causes in missed.items():
        if missed.keys() & causes and name not in causes:
            continue
        after = [f"'{other}'" for other, waits in missed.items() if name in waits and other != name]
        message = f"the event '{name}' never happened" + (f", and so not {', '.join(after)}" if after else "")
        yield experiment.place("events", name).finding(Code.NRP322, message, Level.WARNING)


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
