"""Rates and delays."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.analysis.registry import checks_experiment, checks_function
from nrp_core.analysis.study import Examined, Study
from nrp_core.cle.latency import paths
from nrp_core.clock import NS_PER_S, milliseconds, seconds
from nrp_core.dsl.parameters.topics import SubscribedTopic
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP234)
def throttling_has_an_effect(function: Examined) -> Iterator[Finding]:
    """Look for rate limits above the rate of the loop."""
    rate_hz, timestep_ns = function.function.throttle.rate_hz, function.experiment.timestep
    if rate_hz is not None and rate_hz > NS_PER_S / timestep_ns * (1 + 1e-9):
        message = (
            f"throttling_rate is {rate_hz:g} Hz, but with steps of {milliseconds(timestep_ns):g} ms "
            f"the loop runs at {NS_PER_S / timestep_ns:g} Hz"
        )
        node = function.declared.nodes.get("")
        yield function.declared.finding(Code.NRP234, node, message, Level.WARNING)
    if rate_hz is not None and rate_hz * function.experiment.duration < NS_PER_S:
        message = f"throttling_rate is {rate_hz:g} Hz: it runs only once in the experiment"
        node = function.declared.nodes.get("")
        yield function.declared.finding(Code.NRP234, node, message, Level.WARNING)


@checks_function(Code.NRP248)
def measurements_come_during_the_run(function: Examined) -> Iterator[Finding]:
    """Look for topics that are published more rarely than once in the run."""
    duration_ns = function.experiment.duration
    for name, adapter in function.adapters.items():
        if not isinstance(adapter, SubscribedTopic):
            continue
        topic = adapter.info
        if topic.rate_hz and topic.rate_hz * duration_ns < NS_PER_S:
            message = (
                f"no message comes on '{topic.name}' in a run of {seconds(duration_ns):g} s: "
                f"there is one every {1 / topic.rate_hz:.3g} s"
            )
            node = function.declared.nodes.get(name)
            yield function.declared.finding(Code.NRP248, node, message, Level.WARNING)


@checks_experiment(Code.NRP238)
def paths_take_time(study: Study) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(study.experiment.timestep)
    for path in paths([one.function for one in study.examined if one.function.active]):
        last = next(e.declared for e in study.examined if e.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, last.nodes.get(""), message, Level.NOTE)
