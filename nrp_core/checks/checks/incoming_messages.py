"""Received messages that are asked for what they do not have: joints, distances, beams, colours."""

from __future__ import annotations

import ast
import operator
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from nrp_core.checks.checks.sensor_visibility import read_sensors
from nrp_core.checks.code.declarations import found_in
from nrp_core.checks.code.shapes import Call, Known
from nrp_core.checks.code.syntax import excerpt, number_of, own_nodes
from nrp_core.checks.registry import checks_experiment, checks_function
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.mappings import MapRobotSubscriber
from nrp_core.dsl.tf_lib import find_centroid_hsv, wrong_bounds
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.scripts import last_name
from nrp_core.world.raycast.beams import Beams

_OF_MANY: Final = ("min", "max", "nanmin", "nanmax", "median", "nanmedian", "percentile", "float")
"""Functions whose result is one of the distances that they take, or is between them."""


@checks_experiment(Code.NRP358)
def distances_are_within_reach(static: StaticExperiment) -> Iterator[Finding]:
    """Look for comparisons of a distance with a number that only 'inf', the distance of nothing, exceeds."""
    for function, readings in _readers(static):
        for node in function.declared.own:
            match node:
                case ast.Compare(one, [ast.Gt() | ast.GtE() | ast.Lt() | ast.LtE()], [other]):
                    for distance, bound in ((one, other), (other, one)):
                        beams, limit_m = readings.distance(distance), _number(bound, function)
                        if beams is not None and limit_m is not None and limit_m > beams.reach[1]:
                            message = (
                                f"'{excerpt(node)}' compares a distance with {limit_m:g} m, and the scanner "
                                f"measures up to {beams.reach[1]:g} m: only a beam that reaches nothing, "
                                "which is 'inf', is beyond"
                            )
                            yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


@checks_experiment(Code.NRP240)
def beams_exist(static: StaticExperiment) -> Iterator[Finding]:
    """Look for the number of a beam that a scanner does not have."""
    for function, readings in _readers(static):
        for node in function.declared.own:
            match node:
                case ast.Subscript(whole, index) if not isinstance(index, ast.Slice):
                    beams, number = readings.all_distances(whole), _number(index, function)
                    if (
                        beams is not None
                        and number is not None
                        and not -beams.samples <= number < beams.samples
                    ):
                        message = (
                            f"'{excerpt(node)}' is out of range: the scanner has {beams.samples} beams, "
                            f"0..{beams.samples - 1}"
                        )
                        yield function.declared.finding(Code.NRP240, node, message)


@dataclass(frozen=True, slots=True)
class _Readings:
    """The scanners that a function reads, by its parameters, and the names that it gives to what it read."""

    scanners: Mapping[str, Beams]
    named: Mapping[str, ast.expr]

    def distance(self, node: ast.expr) -> Beams | None:
        """Return the scanner that measured a distance; None if it is not known to be one."""
        match self._meant(node):
            case ast.Call(ast.Attribute(whole, "min" | "max"), [], []):
                return self.distances(whole)
            case ast.Call(func, [whole, *_], []) if last_name(func) in _OF_MANY:
                return self.distances(whole) or self.distance(whole)
            case ast.Subscript(whole, index) if not isinstance(index, ast.Slice):
                return self.distances(whole)
        return None

    def distances(self, node: ast.expr) -> Beams | None:
        """Return the scanner whose distances these are, ``scan.value.ranges`` or a part of them."""
        match self._meant(node):
            case ast.Subscript(whole, ast.Slice()):
                return self.distances(whole)
            case ast.Attribute(message, "ranges"):
                return self._message(message)
        return None

    def all_distances(self, node: ast.expr) -> Beams | None:
        """Return the scanner all whose distances these are."""
        match self._meant(node):
            case ast.Attribute(message, "ranges"):
                return self._message(message)
        return None

    def _message(self, node: ast.expr) -> Beams | None:
        match self._meant(node):
            case ast.Attribute(ast.Name(name), "value"):
                return self.scanners.get(name)
        return None

    def _meant(self, node: ast.expr) -> ast.expr:
        """Return what a name stands for, if it is not a parameter and is set once."""
        for _ in self.named:
            if not isinstance(node, ast.Name) or node.id not in self.named:
                break
            node = self.named[node.id]
        return node


def _readers(static: StaticExperiment) -> Iterator[tuple[CheckedFunction, _Readings]]:
    """Yield the functions that read scanners."""
    of_topics = {
        topic: beams
        for _, sensor in read_sensors(static)
        if isinstance(beams := getattr(sensor, "beams", None), Beams)
        for topic in sensor.topics
    }
    aliases = static.experiment.aliases
    for function in static.functions:
        scanners = {
            name: of_topics[topic]
            for name, mapping in function.function.mappings.items()
            if isinstance(mapping, MapRobotSubscriber)
            if (topic := aliases.get(mapping.reads.name, mapping.reads.name)) in of_topics
        }
        if scanners:
            yield function, _Readings(scanners, _named_once(function))


def _named_once(function: CheckedFunction) -> dict[str, ast.expr]:
    """Return the expressions that names stand for which are set once, and not by a loop."""
    nodes = function.declared.own
    stored = Counter(one.id for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store))
    named = {}
    for node in nodes:
        match node:
            case ast.Assign([ast.Name(name)], value) if stored[name] == 1:
                named[name] = value
    return named


def _number(node: ast.expr, function: CheckedFunction) -> float | None:
    """Return a number that is written, or that a name of the file has."""
    if isinstance(node, ast.Name):
        match function.declared.names.get(node.id):
            case Known(int() | float() as value):
                return value
    return number_of(node)


_ARITHMETIC: Final = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
}  # fmt: skip
_COPIES: Final = ("array", "asarray", "list", "tuple")
"""Functions that return the numbers they are given."""
_LARGEST_BYTE: Final = 255


@checks_function(Code.NRP358)
def colors_can_be_found(function: CheckedFunction) -> Iterator[Finding]:
    """Look for HSV bounds that no pixel meets, or that are in another scale than OpenCV's."""
    for event in function.events:
        match event:
            case Call(node, Known(callee)) if callee is find_centroid_hsv:
                bounds = [_numbers(function, one) for one in node.args[1:]]
                if len(bounds) == 1 and isinstance(node.args[1], ast.Starred):
                    bounds = bounds[0] or []
                if len(bounds) != 2 or not all(_is_triple(one) for one in bounds):
                    continue
                wrong = wrong_bounds(*bounds)
                if wrong:
                    message = f"no colour is found: {wrong}"
                    yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


@checks_function(Code.NRP358)
def bounds_of_bytes_can_be_met(function: CheckedFunction) -> Iterator[Finding]:
    """Look for bounds of ``cv2.inRange`` that exclude all bytes, or that no byte reaches."""
    for node in function.declared.own:
        match node:
            case ast.Call(func, [_, low, high], []) if last_name(func) == "inRange":
                lower, upper = _numbers(function, low), _numbers(function, high)
                if not (_is_triple(lower) and _is_triple(upper) and len(lower) == len(upper)):
                    continue
                wrong = next((f"{one:g} is above {other:g}" for one, other in zip(lower, upper, strict=True)
                              if one > other), "")  # fmt: skip
                if wrong:
                    message = f"no colour is found: the lower bound {wrong}, the upper one"
                elif max(upper) > _LARGEST_BYTE:
                    message = f"{max(upper):g} bounds nothing: bytes end at 255, and a hue of OpenCV at 179"
                else:
                    continue
                yield function.declared.finding(Code.NRP358, node, message, Level.WARNING)


def _numbers(function: CheckedFunction, node: ast.expr) -> Any:
    """Return the value of constants, of names for them and of arithmetic with them; None for others."""
    try:
        return _value(function, node.value if isinstance(node, ast.Starred) else node)
    except (TypeError, ArithmeticError):
        return None


def _value(function: CheckedFunction, node: ast.expr) -> Any:
    match node:
        case ast.Constant(value) if isinstance(value, (int, float)):
            return value
        case ast.Name(name):
            shape = function.declared.names.get(name)
            given = _assigned(function, name)
            if given is None:
                return shape.value if isinstance(shape, Known) else None
            return _value(function, given)
        case ast.Tuple(items) | ast.List(items):
            return [_value(function, one) for one in items]
        case ast.Call(func, [items, *_]) if last_name(func) in _COPIES:
            return _value(function, items)
        case ast.UnaryOp(ast.USub(), operand):
            return -_value(function, operand)
        case ast.BinOp(left, op, right) if type(op) in _ARITHMETIC:
            numbers = _value(function, left), _value(function, right)
            if all(type(one) in (int, float) for one in numbers):
                return _ARITHMETIC[type(op)](*numbers)
    return None


def _assigned(function: CheckedFunction, name: str) -> ast.expr | None:
    """Return what a function assigns to a name of its own, if it does so once and in one place."""
    given: list[ast.expr | None] = []
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Name(target)], value) if target == name:
                given.append(value)
            case ast.Name(target, ast.Store()) if target == name:
                given.append(None)
    known = [value for value in given if value is not None]
    return known[0] if len(known) == 1 and len(given) == 2 else None


def _is_triple(value: Any) -> bool:
    return isinstance(value, tuple | list) and all(type(one) in (int, float) for one in value)


@checks_experiment(Code.NRP240)
def joints_of_messages_exist(static: StaticExperiment) -> Iterator[Finding]:
    """Look for names of joints that the messages of a robot do not have."""
    if static.scene is None:
        return
    joints = {
        one.joint_states_topic: [
            *(joint.name for joint in one.joints),
            *(pair.name for pair in one.pair_controllers),
        ]
        for one in static.scene.models
        if one.joint_states_topic is not None
    }
    aliases = static.experiment.aliases
    for function in static.functions:
        received = _received(function)
        for node in function.declared.own:
            match node:
                case ast.Call(
                    ast.Attribute(ast.Attribute(owner, "name"), "index"), [ast.Constant(str() as name)]
                ) | ast.Compare(
                    ast.Constant(str() as name), [ast.In() | ast.NotIn()], [ast.Attribute(owner, "name")]
                ):
                    topic = received.get(ast.unparse(owner), "")
                    known = joints.get(aliases.get(topic, topic))
                    if known is not None and name not in known:
                        message = f"'{topic}' has no joint '{name}'{did_you_mean(name, known)}"
                        yield function.declared.finding(Code.NRP240, node, message, Level.WARNING)


@checks_experiment(Code.NRP356)
def preprocessed_messages_are_returned(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions of preprocessed topics that return nothing, so that ``value`` is None."""
    for source in [source for listing in static.listings for source in listing.sources]:
        defined = {one.name: one for one in ast.walk(source.tree) if isinstance(one, ast.FunctionDef)}
        for node in ast.walk(source.tree):
            match node:
                case ast.Call(func, [_, _, ast.Name(name), *_]) if name in defined:
                    returned = [one for one in own_nodes(defined[name].body) if isinstance(one, ast.Return)]
                    if ast.unparse(func).endswith("PreprocessedTopic") and not any(
                        one.value is not None for one in returned
                    ):
                        message = (
                            f"'{name}' returns nothing, and its result is the message: it is always None"
                        )
                        yield found_in(source, Code.NRP356, node, message, Level.WARNING)


def _received(function: CheckedFunction) -> dict[str, str]:
    """Return the topics of the expressions that are received messages: ``camera.value`` and its aliases."""
    mappings = function.function.mappings
    found = {
        f"{name}.value": one.reads.name
        for name, one in mappings.items()
        if isinstance(one, MapRobotSubscriber)
    }
    for node in function.declared.own:
        match node:
            case ast.Assign([ast.Name(alias)], ast.Attribute() as value) if ast.unparse(value) in found:
                found[alias] = found[ast.unparse(value)]
    return found
