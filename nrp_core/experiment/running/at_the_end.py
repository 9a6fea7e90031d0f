"""Findings about a run that is over: events that never happened, and time beyond its duration."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.clock import seconds
from nrp_core.experiment.events.conditions import Times
from nrp_core.experiment.model.event_schema import causes_of
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level


def at_the_end(experiment: Experiment, times: Times, now_ns: int) -> Iterator[Finding]:
    """Yield a finding for each event that did not happen, and one if the run went on beyond its duration.

    Events that wait for one that did not happen are named with it.

    Args:
        experiment: an experiment whose run is over.
        times: times of the events that happened, ns.
        now_ns: the time reached.
    """
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
