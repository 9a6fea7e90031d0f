"""Components of velocity commands that the commanded drive does not use."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import Any

from nrp_core.checks.events import Call, Write
from nrp_core.checks.registry import checks_experiment
from nrp_core.checks.shapes import Instance, Known
from nrp_core.checks.static_experiment import CheckedFunction, StaticExperiment
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.drives.drive import commanded_components
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.scene.model import Scene

_HALVES = ("linear", "angular")
_AXES = ("x", "y", "z")


def drives_of(scene: Scene, experiment: Experiment) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return the robot and the used components of each topic, or alias of one, that takes a Twist."""
    found = commanded_components(scene)
    return found | {alias: found[topic] for alias, topic in experiment.aliases.items() if topic in found}


@checks_experiment(Code.NRP321)
def events_command_what_drives_use(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events that publish a velocity that the drive ignores."""
    drives = {} if static.scene is None else drives_of(static.scene, static.experiment)
    for name, event in static.experiment.events.items():
        for said in event.publish:
            if said.topic in drives and isinstance(said.value, Mapping):
                for component in _components(said.value):
                    message = _ignored(component, *drives[said.topic])
                    if message:
                        place = static.experiment.place("events", name, "publish")
                        yield place.finding(Code.NRP321, message, Level.WARNING)


@checks_experiment(Code.NRP321)
def functions_command_what_drives_use(static: StaticExperiment) -> Iterator[Finding]:
    """Look for functions that send a velocity that the drive ignores."""
    drives = {} if static.scene is None else drives_of(static.scene, static.experiment)
    for function in static.functions:
        published = (static.topics.get(topic.name) for topic in function.function.published)
        commanded = {drives.get(info.name) for info in published if info is not None and info.type is Twist}
        if len(commanded) != 1 or None in commanded:
            continue  # the function may build a command for another drive
        (drive,) = commanded
        assert drive is not None
        for component, node in _set_in(function):
            message = _ignored(component, *drive)
            if message:
                yield function.declared.finding(Code.NRP321, node, message, Level.WARNING)


def _ignored(component: str, robot: str, used: tuple[str, ...]) -> str:
    """Return that a drive ignores a component; empty if it does not."""
    if component in used:
        return ""
    return f"'{component}' of the command has no effect: the drive of '{robot}' uses {', '.join(used)}"


def _components(value: Mapping[str, Any]) -> Iterator[str]:
    """Yield the components of a velocity in a file that are not 0."""
    for half in _HALVES:
        given = value.get(half)
        if isinstance(given, Mapping):
            yield from (f"{half}.{axis}" for axis in _AXES if given.get(axis))


def _set_in(function: CheckedFunction) -> Iterator[tuple[str, ast.AST]]:
    """Yield the components of a Twist that a body sets to another value than 0, each with its place."""
    vectors = {id(one.node): one.node for one in function.events if _makes(one, Vector3)}
    named = {
        target.id: value
        for statement in function.declared.own
        if isinstance(statement, ast.Assign) and id(value := statement.value) in vectors
        for target in statement.targets
        if isinstance(target, ast.Name)
    }
    for event in function.events:
        if isinstance(event, Call) and _makes(event, Twist):
            for half, given in _arguments(event.node, _HALVES).items():
                made = named.get(given.id) if isinstance(given, ast.Name) else given
                if isinstance(made, ast.Call) and id(made) in vectors:
                    for axis, value in _arguments(made, _AXES).items():
                        if not _is_zero(value):
                            yield f"{half}.{axis}", value
        match event:
            case Write(ast.Attribute(ast.Attribute(_, half)) as node, Instance(cls), axis, True, set_to):
                if cls is Vector3 and half in _HALVES and set_to != Known(0):
                    yield f"{half}.{axis}", node


def _makes(event: object, cls: type) -> bool:
    return isinstance(event, Call) and event.callee == Known(cls)


def _arguments(call: ast.Call, names: tuple[str, ...]) -> dict[str, ast.expr]:
    given = dict(zip(names, call.args, strict=False))
    return given | {one.arg: one.value for one in call.keywords if one.arg in names}


def _is_zero(value: ast.expr) -> bool:
    return isinstance(value, ast.Constant) and value.value == 0
