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
from nrp_core.clock import milliseconds, seconds
from nrp_core.dsl.parameters.topics import SubscribedTopic
from nrp_core.findings import Code, Finding, Level

_STEPS: Final = ("dt", "delta_t", "timestep", "time_step", "dt_s", "timestep_s")
"""Names of the time between two calls of a function."""
_LOOPS: Final = (ast.For, ast.While, ast.comprehension)
_COUNTING: Final = ("int", "round", "range", "ceil", "arange", "linspace")
"""Functions that count steps, or list their times."""


@checks_function(Code.NRP360)
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
            yield function.declared.finding(Code.NRP360, node, message, Level.WARNING)
            return


def _is_own_step(node: ast.AST) -> bool:
    """Return whether a function waits for a time by itself, or divides its step into smaller ones."""
    match node:
        case ast.Compare():
            return True
        case ast.Call(func):
            return last_name(func) in _COUNTING
    return False


@checks_experiment(Code.NRP238)
def paths_take_time(static: StaticExperiment) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(static.experiment.timestep)
    for path in paths([one.function for one in static.functions if one.function.active]):
        last = next(e.declared for e in static.functions if e.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, last.nodes.get(""), message, Level.NOTE)
