"""Constants in functions that are in another unit or range than what they are compared or used with."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from math import isclose
from typing import Final

from nrp_core.checks.check import checks_experiment, checks_function
from nrp_core.checks.code.values import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.checks.subjects.sensor_visibility import read_sensors
from nrp_core.clock import seconds
from nrp_core.dsl.mappings import MapRobotSubscriber
from nrp_core.dsl.parameters import SubscribedTopic
from nrp_core.dsl.tf_lib import find_centroid_hsv, wrong_bounds
from nrp_core.findings import Code, Finding, Level
from nrp_core.scripts import last_name
from nrp_core.world.raycast.beams import Beams

_LARGEST_BYTE: Final = 255
_STEPS: Final = ("dt", "delta_t", "timestep", "time_step", "dt_s", "timestep_s")
"""Names of the time between two calls of a function."""
_LOOPS: Final = (ast.For, ast.While, ast.comprehension)
_COUNTING: Final = ("int", "round", "range", "ceil", "arange", "linspace")
"""Functions that count steps, or list their times."""
_SELECTING: Final = ("min", "max", "nanmin", "nanmax", "median", "nanmedian", "percentile", "float")
"""Functions whose result is one of the distances that they take, or is between them."""


# -- colours


@checks_function
def check_colors(function: CheckedFunction) -> Iterator[Finding]:
    """Look for bounds of colours that no pixel meets, or that are in another scale than OpenCV's."""
    for node in function.declared.own:
        match node:
            case ast.Call(func, [_, low, high], []) if function.body.shape(func) == Known(find_centroid_hsv):
                numbers = _numbers(function, low), _numbers(function, high)
                wrong = "" if None in numbers else wrong_bounds(*numbers)  # type: ignore[arg-type]
            case ast.Call(func, [_, low, high], []) if last_name(func) == "inRange":
                wrong = _wrong_bytes(_numbers(function, low), _numbers(function, high))
            case _:
                continue
        if wrong:
            message = f"no colour is found: {wrong}"
            yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


def _numbers(function: CheckedFunction, node: ast.expr) -> Sequence[float] | None:
    """Return the numbers of a row of constants, perhaps as an array; None for anything else."""
    if isinstance(node, ast.Name) and (value := function.body.assigned(node.id)) is not None:
        return _numbers(function, value)
    if (
        isinstance(node, ast.Call)
        and last_name(node.func) in ("array", "asarray", "list", "tuple")
        and node.args
    ):
        return _numbers(function, node.args[0])
    found = function.body.shape(node)
    values = found.value if isinstance(found, Known) else None
    is_row = isinstance(values, list | tuple) and all(type(one) in (int, float) for one in values)
    return values if is_row else None


def _wrong_bytes(low: Sequence[float] | None, high: Sequence[float] | None) -> str:
    if low is None or high is None or len(low) != len(high):
        return ""
    for one, other in zip(low, high, strict=True):
        if one > other:
            return f"the lower bound {one:g} is above {other:g}, the upper one"
    if max(high) > _LARGEST_BYTE:
        return f"{max(high):g} bounds nothing: bytes end at 255, and a hue of OpenCV at 179"
    return ""


# -- the step of the loop


@checks_function
def check_time_step(function: CheckedFunction) -> Iterator[Finding]:
    """Look for a constant ``DT`` that is not how often the function runs."""
    step_s = seconds(function.experiment.timestep)
    rates_hz = [function.function.throttle.rate_hz]
    rates_hz += [one.info.rate_hz for one in function.adapters.values() if isinstance(one, SubscribedTopic)]
    periods_s = [step_s, *(1 / rate_hz for rate_hz in rates_hz if rate_hz)]
    nodes = function.declared.own
    own_steps = [node for node in nodes if isinstance(node, _LOOPS) or _divides_step(node)]
    skipped = {id(one) for node in own_steps for one in ast.walk(node)}
    skipped_names = {one.id for node in own_steps for one in ast.walk(node) if isinstance(one, ast.Name)}
    for node in nodes:
        if not isinstance(node, ast.Name) or node.id.lower() not in _STEPS or id(node) in skipped:
            continue
        value = function.body.constant(node)
        if value is None or value <= 0 or node.id in skipped_names:
            continue
        if not any(isclose(value, factor * one) for one in periods_s for factor in (1, 1000)):
            message = (
                f"'{node.id}' is {value:g}, and the function runs every {step_s:g} s; is the time since its "
                "last call meant? It is known from 't'"
            )
            yield function.declared.finding(Code.NRP379, node, message, Level.WARNING)
            return


def _divides_step(node: ast.AST) -> bool:
    """Return whether a function waits for a time by itself, or divides its step into smaller ones."""
    return isinstance(node, ast.Compare) or (isinstance(node, ast.Call) and last_name(node.func) in _COUNTING)


# -- distances of scanners


@checks_experiment
def check_distances(static: StaticExperiment) -> Iterator[Finding]:
    """Look for comparisons of a distance with a number that only 'inf', the distance of nothing, exceeds."""
    reaches_m = {
        topic: beams.reach[1]
        for _, sensor in read_sensors(static)
        if isinstance(beams := getattr(sensor, "beams", None), Beams)
        for topic in sensor.topics
    }
    aliases = static.experiment.aliases
    for function in static.functions:
        scanners = {
            name: reaches_m[topic]
            for name, mapping in function.function.mappings.items()
            if isinstance(mapping, MapRobotSubscriber)
            if (topic := aliases.get(mapping.reads.name, mapping.reads.name)) in reaches_m
        }
        for node in function.declared.own if scanners else ():
            match node:
                case ast.Compare(one, [ast.Gt() | ast.GtE() | ast.Lt() | ast.LtE()], [other]):
                    for distance, bound in ((one, other), (other, one)):
                        reach_m = _reach_m(function, distance, scanners)
                        limit_m = function.body.constant(bound)
                        if reach_m is not None and limit_m is not None and limit_m > reach_m:
                            message = (
                                f"'{ast.unparse(node)}' compares a distance with {limit_m:g} m; the scanner "
                                f"measures up to {reach_m:g} m: only a beam that reaches nothing, which is "
                                "'inf', is beyond"
                            )
                            yield function.declared.finding(Code.NRP380, node, message, Level.WARNING)


def _reach_m(function: CheckedFunction, node: ast.expr, scanners: dict[str, float]) -> float | None:
    """Return the reach of the scanner that measured a distance, m; None if it is not known to be one."""
    match _assigned_value(function, node):
        case ast.Attribute(message, "ranges"):
            match _assigned_value(function, message):
                case ast.Attribute(ast.Name(name), "value"):
                    return scanners.get(name)
        case ast.Subscript(ranges) | ast.Call(ast.Attribute(ranges, "min" | "max"), [], []):
            return _reach_m(function, ranges, scanners)
        case ast.Call(func, [ranges, *_]) if last_name(func) in _SELECTING:
            return _reach_m(function, ranges, scanners)
    return None


def _assigned_value(function: CheckedFunction, node: ast.expr) -> ast.expr:
    """Return the expression that a name stands for which is set once, or the node itself."""
    value = function.body.assigned(node.id) if isinstance(node, ast.Name) else None
    return node if value is None or isinstance(value, ast.Name) else value
