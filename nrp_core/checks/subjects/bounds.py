"""Constants in functions that are in another unit or range than what they are compared or used with."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from math import isclose
from typing import Final

from nrp_core.checks.code.syntax import names_in
from nrp_core.checks.code.values import value_of
from nrp_core.checks.static_experiment import (
    CheckedFunction,
    StaticExperiment,
    checks_experiment,
    checks_function,
)
from nrp_core.checks.subjects.sensor_visibility import read_sensors
from nrp_core.clock import seconds
from nrp_core.dsl.mappings import MapRobotSubscriber
from nrp_core.dsl.parameters import SubscribedTopic
from nrp_core.dsl.tf_lib import find_centroid_hsv, wrong_bounds
from nrp_core.findings import Code, Finding
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
            case ast.Call(func, [_, low, high], []):
                lower, upper = _numbers(function, low), _numbers(function, high)
            case _:
                continue
        wrong = ""
        if lower is None or upper is None:
            continue
        if value_of(function.body.shape(func)) is find_centroid_hsv:
            wrong = wrong_bounds(lower, upper)
        elif last_name(func) == "inRange" and len(lower) == len(upper):
            wrong = _wrong_bytes(lower, upper)
        if wrong:
            yield function.warning(Code.NRP358, node, f"no colour is found: {wrong}")


def _numbers(function: CheckedFunction, node: ast.expr) -> Sequence[float] | None:
    """Return the numbers of a row of constants, perhaps as an array; None for anything else."""
    match _assigned_value(function, node):
        case ast.Call(func, [row, *_]) if last_name(func) in ("array", "asarray", "list", "tuple"):
            return _numbers(function, row)
        case row:
            values = value_of(function.body.shape(row), list | tuple)
            is_row = values is not None and all(type(one) in (int, float) for one in values)
            return values if is_row else None


def _wrong_bytes(low: Sequence[float], high: Sequence[float]) -> str:
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
    own = function.declared.own
    own_steps = [node for node in own if isinstance(node, _LOOPS) or _divides_step(node)]
    skipped = {name for node in own_steps for name in names_in(node)}
    for node in own:
        if not isinstance(node, ast.Name) or node.id.lower() not in _STEPS or node.id in skipped:
            continue
        value = function.body.constant(node) or 0.0
        if value > 0 and not any(isclose(value, factor * one) for one in periods_s for factor in (1, 1000)):
            message = (
                f"'{node.id}' is {value:g}, and the function runs every {step_s:g} s; is the time since its "
                "last call meant? It is known from 't'"
            )
            yield function.warning(Code.NRP379, node, message)
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
                            yield function.warning(Code.NRP380, node, message)


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
