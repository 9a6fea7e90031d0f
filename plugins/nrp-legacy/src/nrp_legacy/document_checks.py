"""Checks of the documents: ignored values, elements that contradict an earlier one, misspelt parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from typing import Final

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code, Finding, Level
from nrp_core.xml import Element
from nrp_legacy.documents import (
    DURATION_S,
    ROBOT,
    Bibi,
    Experiment,
    FileNamed,
    attribute,
    children,
    local,
    number,
    text,
)

_PARTS: Final = {
    "environmentModel": Code.NRP256,
    "bodyModel": Code.NRP256,
    "brainModel": Code.NRP269,
    "transferFunction": Code.NRP272,
    "experimentControl": Code.NRP272,
    "experimentEvaluation": Code.NRP272,
}
"""Elements of documents, and what a run lacks where one is misspelt."""
_ENGINES: Final = ("ode", "bullet", "simbody", "dart", "opensim")
_TRUTH: Final = ("true", "false", "1", "0")
_CLOCKS: Final = ("simulation", "real")
_SELECTORS: Final = ("Range", "List", "Population", "Index")
_ONCE_IN_EXC: Final = ("bibiConf", "environmentModel", "timeout", "rngSeed", "physicsEngine")
_ONCE_IN_BIBI: Final = ("brainModel", "timestep", "mode")
_POSE_ATTRIBUTES: Final = ("x", "y", "z", "roll", "pitch", "yaw", "ux", "uy", "uz", "theta", "robotId")


def check_documents(exc: Experiment, bibi: Bibi) -> Iterator[Finding]:
    """Yield a finding for each ignored value."""
    yield from _repeated(exc.element, _ONCE_IN_EXC)
    yield from _repeated(bibi.element, _ONCE_IN_BIBI)
    for brain in children(bibi.element, "brainModel"):
        yield from _repeated(brain, ("file",))
    for root in dict.fromkeys((exc.element, bibi.element)):
        yield from _misspelt_parts(root)
    yield from _settings(exc)
    yield from _places(exc, bibi)
    yield from _selectors(bibi.populations)
    yield from _populations(bibi)
    yield from _functions(bibi)
    yield from _robots_left_out(bibi)
    yield from _machines_left_out(exc)
    for timestep in children(bibi.element, "timestep")[:1]:
        if not timestep.text:
            yield _warning(timestep, "the <timestep> is empty: the default is used")


def _warning(element: Element, message: str) -> Finding:
    return Finding(Code.NRP216, message, Level.WARNING, element.path, element.line)


def _misspelt_parts(root: Element) -> Iterator[Finding]:
    """Yield the elements that nearly have the name of one that is read; documents may have others."""
    known = {name.lower(): name for name in _PARTS}
    for element in root.children:
        tag = local(element.tag)
        near = get_close_matches(tag.lower(), known, n=1, cutoff=0.8)
        if near and not tag.startswith(meant := known[near[0]]):
            message = f"<{tag}> is ignored; did you mean <{meant}>?"
            yield Finding(_PARTS[meant], message, Level.WARNING, element.path, element.line)


def _repeated(root: Element, tags: tuple[str, ...]) -> Iterator[Finding]:
    for tag in tags:
        first, *others = children(root, tag) or [root]
        for other in others:
            if (other.text, other.attributes) != (first.text, first.attributes):
                yield _warning(other, f"a second <{tag}> is ignored: the one of line {first.line} is used")


def _machines_left_out(exc: Experiment) -> Iterator[Finding]:
    """Yield the state machines without a file, and those with the id of an earlier one."""
    lines: dict[str, int] = {}
    for place in children(exc.element, "experimentControl", "experimentEvaluation"):
        for machine in children(place, "stateMachine"):
            name = attribute(machine, "id") or ""
            if not FileNamed.of(machine).name:
                message = f"the state machine '{name}' is left out: it names no file"
                yield Finding(Code.NRP272, message, Level.WARNING, machine.path, machine.line)
            if name and lines.setdefault(name, machine.line) != machine.line:
                yield _warning(machine, f"the state machine in line {lines[name]} has the same id, '{name}'")


def _settings(exc: Experiment) -> Iterator[Finding]:
    for timeout in children(exc.element, "timeout"):
        kind = attribute(timeout, "time")
        if not timeout.text.strip():
            yield _warning(timeout, f"the <timeout> is empty: the run lasts {DURATION_S:g} s")
        if kind and kind not in _CLOCKS:
            hint = did_you_mean(kind, _CLOCKS)
            yield _warning(timeout, f"the time of a <timeout> is '{kind}'{hint}: simulated time is used")
    for engine in children(exc.element, "physicsEngine"):
        name = engine.text.strip().lower()
        if name and name not in _ENGINES:
            yield _warning(
                engine, f"there is no physics engine '{name}'{did_you_mean(name, _ENGINES)}: ignored"
            )
    for seed in children(exc.element, "rngSeed"):
        if not text(exc.element, "rngSeed").isdecimal():
            yield _warning(seed, f"the <rngSeed> must be a whole number, not '{seed.text}': the seed is 0")


def _places(exc: Experiment, bibi: Bibi) -> Iterator[Finding]:
    """Yield the start poses of robots that do not exist, and those of robots that have two."""
    given = [
        one for place in (exc.element, *children(exc.element, "environmentModel")) for one in place.children
    ]
    poses = [one for one in given if local(one.tag) == "robotPose"]
    last = {attribute(pose, "robotId") or ROBOT: pose for pose in poses}
    for pose in poses:
        name = attribute(pose, "robotId") or ROBOT
        if last[name] is not pose:
            yield _warning(pose, f"'{name}' has two start poses: that of line {last[name].line} is used")
        elif name not in bibi.bodies and attribute(pose, "robotId") and bibi.bodies:
            hint = did_you_mean(name, bibi.bodies)
            yield _warning(pose, f"there is no robot '{name}', whose start pose this is{hint}")
        yield from _orientation(pose)
        for key, value in pose.attributes.items():
            if local(key) not in _POSE_ATTRIBUTES:
                yield _warning(
                    pose, f"a start pose has no '{local(key)}'{did_you_mean(local(key), _POSE_ATTRIBUTES)}"
                )
            elif not value.strip():
                yield _warning(pose, f"'{local(key)}' of a start pose is empty: not used")


def _orientation(pose: Element) -> Iterator[Finding]:
    """Yield that a quaternion has no direction."""
    said = [attribute(pose, name) for name in ("ux", "uy", "uz", "theta")]
    try:
        parts = [float(part) for part in said if part is not None]
    except ValueError:
        return  # reported where it is read
    if len(parts) < len(said) or any(attribute(pose, name) for name in ("roll", "pitch", "yaw")):
        return
    if not any(parts):
        yield _warning(
            pose, "the quaternion of a start pose is 0 0 0 0, which is not an orientation: none is used"
        )


def _selectors(populations: Mapping[str, Element]) -> Iterator[Finding]:
    for name, selector in populations.items():
        kind = local(attribute(selector, "type") or "")
        if kind and kind not in _SELECTORS:
            hint = did_you_mean(kind, _SELECTORS)
            yield _warning(selector, f"the population '{name}' is of an unknown type '{kind}'{hint}")
        for setting in ("from", "to", "step"):
            if not selector.attributes.get(setting, "0").strip():
                yield _warning(selector, f"'{setting}' of the population '{name}' is empty: not used")
            try:
                value = number(selector, setting)
            except ExperimentError:
                continue  # reported where it is read
            least = 1 if setting == "step" else 0
            if value is not None and (value != int(value) or value < least):
                yield _warning(
                    selector,
                    f"'{setting}' of the population '{name}' must be a whole number of {least} or more, "
                    f"not {value:g}",
                )


def _populations(bibi: Bibi) -> Iterator[Finding]:
    """Yield the populations that another one of the same name replaces, and those of no brain."""
    for brain in children(bibi.element, "brainModel"):
        if bibi.populations and not FileNamed.of(brain).name:
            message = "the brain is left out: its <brainModel> has populations, and names no file"
            yield Finding(Code.NRP269, message, Level.WARNING, brain.path, brain.line)
        for selector in children(brain, "populations", "neuronGroup"):
            name = attribute(selector, "population")
            used = bibi.populations.get(name or "", selector)
            if (used.attributes, used.line) != (selector.attributes, selector.line):
                yield _warning(
                    selector, f"a population '{name}' stands again in line {used.line}: that one is used"
                )


def _robots_left_out(bibi: Bibi) -> Iterator[Finding]:
    """Yield the robots without a file, and those that another one of the same name replaces."""
    bodies = children(bibi.element, "bodyModel")
    last = {attribute(body, "robotId") or ROBOT: body for body in bodies}
    for body in bodies:
        name = attribute(body, "robotId") or ROBOT
        if not FileNamed.of(body).name:
            message = f"the robot '{name}' is left out: its <bodyModel> names no file"
            yield Finding(Code.NRP256, message, Level.WARNING, body.path, body.line)
        if last[name] is not body:
            message = f"a robot '{name}' stands again in line {last[name].line}: this one is left out"
            yield Finding(Code.NRP256, message, Level.WARNING, body.path, body.line)


def _functions(bibi: Bibi) -> Iterator[Finding]:
    for function in bibi.functions:
        if not (FileNamed.of(function).name or function.children):
            message = "the transfer function is left out: it names no file and holds no code"
            yield Finding(Code.NRP272, message, Level.WARNING, function.path, function.line)
        active, priority = attribute(function, "active"), attribute(function, "priority")
        if active and active.lower() not in _TRUTH:
            hint = did_you_mean(active, _TRUTH)
            yield _warning(function, f"active of a transfer function is '{active}'{hint}: it runs")
        if priority and not priority.lstrip("+-").isdecimal():
            yield _warning(
                function, f"priority of a transfer function is '{priority}', not a whole number: it is 0"
            )
