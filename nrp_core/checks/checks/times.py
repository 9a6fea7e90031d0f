"""Rates and delays."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from math import isclose
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.cle.latency import paths
from nrp_core.clock import NS_PER_S, milliseconds, seconds
from nrp_core.dsl.parameters.topics import SubscribedTopic
from nrp_core.findings import Code, Finding, Level

_STEPS: Final = ("dt", "delta_t", "timestep", "time_step", "dt_s", "timestep_s")
"""Names of the time between two calls of a function."""
_LOOPS: Final = (ast.For, ast.While, ast.comprehension)
_COUNTING: Final = ("int", "round", "range", "ceil", "arange", "linspace")
"""Functions that count steps, or list their times."""


@checks_function(Code.NRP234)
def throttling_has_an_effect(function: CheckedFunction) -> Iterator[Finding]:
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


@checks_function(Code.NRP320)
def steps_are_those_of_the_loop(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a constant ``DT`` that is not how often the function runs."""
    step_s = seconds(function.experiment.timestep)
    rates_hz = [function.function.throttle.rate_hz]
    rates_hz += [one.info.rate_hz for one in function.adapters.values() if isinstance(one, SubscribedTopic)]
    periods_s = [step_s, *(1 / rate_hz for rate_hz in rates_hz if rate_hz)]
    nodes = function.declared.own
    repeated = {id(one) for loop in nodes if isinstance(loop, _LOOPS) for one in ast.walk(loop)}
    own = {
        one.id for node in nodes if _is_own_step(node) for one in ast.walk(node) if isinstance(one, ast.Name)
    }
    for node in nodes:
        name = node.id if isinstance(node, ast.Name) and node.id not in own else ""
        given = function.declared.names.get(name)
        if not isinstance(given, Known) or not isinstance(given.value, int | float) or id(node) in repeated:
            continue  # loops take smaller steps of their own
        fits = any(isclose(given.value, factor * one) for one in periods_s for factor in (1, 1000))
        if name.lower() in _STEPS and given.value > 0 and not fits:
            message = (
                f"'{name}' is {given.value:g}, and the function runs every {step_s:g} s; is the time since "
                "its last call meant? It is known from 't'"
            )
            yield function.declared.finding(Code.NRP320, node, message, Level.WARNING)
            return


def _is_own_step(node: ast.AST) -> bool:
    """Return whether a function waits for a time by itself, or divides its step into smaller ones."""
    match node:
        case ast.Compare():
            return True
        case ast.Call(func):
            return last_name(func) in _COUNTING
    return False


@checks_function(Code.NRP248)
def measurements_come_during_the_run(function: CheckedFunction) -> Iterator[Finding]:
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


@checks_function(Code.NRP233)
def stamps_are_read_whole(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the nanoseconds of a stamp next to ``t``, which are those since its last whole second."""
    for node in function.declared.own:
        match node:
            case (
                ast.BinOp(ast.Name("t"), ast.Add() | ast.Sub(), ast.Attribute(_, "nanosec" | "nsecs" as name))
                | ast.BinOp(ast.Attribute(_, "nanosec" | "nsecs" as name), ast.Sub(), ast.Name("t"))
                | ast.Compare(ast.Attribute(_, "nanosec" | "nsecs" as name), [_], [ast.Name("t")])
                | ast.Compare(ast.Name("t"), [_], [ast.Attribute(_, "nanosec" | "nsecs" as name)])
            ):
                message = (
                    f"'t' is in seconds, and '{name}' are the nanoseconds since the last whole second; "
                    "stamp.to_sec() is the time in seconds"
                )
                yield function.declared.finding(Code.NRP233, node, message, Level.WARNING)


@checks_experiment(Code.NRP238)
def paths_take_time(static: StaticExperiment) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(static.experiment.timestep)
    for path in paths([one.function for one in static.functions if one.function.active]):
        last = next(e.declared for e in static.functions if e.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, last.nodes.get(""), message, Level.NOTE)
