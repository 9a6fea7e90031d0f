"""Angles in degrees and radians."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from math import radians

from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.experiment.model.tree import Key
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.rigid import ROUNDED_TURN_RAD


@checks_experiment(Code.NRP249)
def angles_have_units(static: StaticExperiment) -> Iterator[Finding]:
    """Look for angles of poses given in degrees instead of radians."""
    experiment = static.experiment
    owners: dict[tuple[Key, ...], str] = {}
    for name, robot in experiment.world.robots.items():
        owners["world", "robots", name] = f"'{name}'"
        for number, sensor in enumerate(robot.add_sensors):
            owners["world", "robots", name, "add_sensors", number] = f"the sensor on '{name}/{sensor.link}'"
    for place, owner in owners.items():
        for i, what in enumerate(("roll", "pitch", "yaw"), start=3):
            keys = (*place, "pose", i)
            written, reached = experiment.source.nearest(keys)
            value = written.value
            if reached == keys and isinstance(value, (int, float)) and abs(value) > ROUNDED_TURN_RAD:
                message = (
                    f"the {what} of {owner} is {value:g} rad, more than a turn; {value:g} degrees are "
                    f"{radians(value):.4g} rad"
                )
                yield written.place.finding(Code.NRP249, message, Level.WARNING)


def single_values(function: CheckedFunction) -> dict[str, ast.expr]:
    """Return the names to which a body assigns one expression, alone or in a row, and that expression."""
    nodes = function.declared.own
    stores = Counter(one.id for one in nodes if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store))
    pairs: list[tuple[ast.expr, ast.expr]] = []
    for node in nodes:
        match node:
            case ast.Assign([ast.Tuple(names)], ast.Tuple(values)) if len(names) == len(values):
                pairs += zip(names, values, strict=True)
            case ast.Assign([name], value):
                pairs.append((name, value))
    return {name.id: value for name, value in pairs if isinstance(name, ast.Name) and stores[name.id] == 1}
