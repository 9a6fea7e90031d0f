"""Distances of a scanner that are compared with more than it measures, and beams that it does not have."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from nrp_core._support.dotted import last_name
from nrp_core.checks.checks.sensors import read_sensors
from nrp_core.checks.quoting import excerpt, number_of
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.shapes import Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.dsl.functions.mappings import MapRobotSubscriber
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.raycast.beams import Beams

_OF_MANY: Final = ("min", "max", "nanmin", "nanmax", "median", "nanmedian", "percentile", "float")
"""Functions whose result is one of the distances that they take, or is between them."""


@checks_experiment(Code.NRP359)
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
                            yield function.declared.finding(Code.NRP359, node, message, Level.WARNING)


@checks_experiment(Code.NRP252)
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
                        yield function.declared.finding(Code.NRP252, node, message)


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
