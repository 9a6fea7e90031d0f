"""The two documents of an experiment of the platform, as plain data."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from nrp_core._support.xml import Element, read_xml
from nrp_core.errors import ExperimentError
from nrp_legacy.elements import (
    attribute,
    child,
    children,
    flag,
    local,
    number,
    text,
)

DURATION_S = 600.0
"""The default duration of an experiment."""

ROBOT = "robot"
"""The name of a robot without a name."""

FUNCTION = "transferFunction"
"""How the names of elements with a transfer function begin."""

_IGNORED = ("rosLaunch", "extRobotController", "events")


@dataclass(frozen=True, slots=True)
class FileNamed:
    """A file as a document names it.

    Args:
        name: the name in the document, empty if there is none.
        element: the element that names it.
        model: the folder of the model library that it belongs to, if given.
        others: alternatives in the document: an archive and a file in it, a model.
    """

    name: str
    element: Element
    model: str | None = None
    others: tuple[str, ...] = ()

    @classmethod
    def of(cls, element: Element) -> FileNamed:
        """Read a file name from an attribute, a child element, or the text of the element."""
        model, archive = attribute(element, "model"), attribute(element, "assetPath")
        name = attribute(element, "src") or text(element, "file", "src") or element.text.strip()
        said = [one for one in dict.fromkeys((archive, name, model)) if one]
        return cls(said[0] if said else "", element, model, tuple(said[1:]))

    @property
    def names(self) -> tuple[str, ...]:
        """All possible names, the most likely one first."""
        return (self.name, *self.others)


@dataclass(frozen=True, slots=True)
class Experiment:
    """An ``.exc`` document.

    Args:
        element: its root.
        timeout: the element with the duration.
        environment: the room.
        poses: the initial poses of robots, by robot name.
        bibi: the other document.
        machines: the state machines; state machines of the evaluation come last.
        ignored: the elements that are not supported.
    """

    element: Element
    name: str
    description: str
    timeout: Element | None
    seed: int | None
    environment: FileNamed | None
    poses: dict[str, Element]
    bibi: FileNamed | None
    machines: tuple[FileNamed, ...]
    ignored: tuple[Element, ...]


@dataclass(frozen=True, slots=True)
class Bibi:
    """A ``.bibi`` document.

    Args:
        element: its root.
        timestep: the element with the time step of the loop, ms.
        mode: the kind of brain simulation.
        brain: the file of the brain, None for none.
        populations: the elements that select neurons of the brain, by population name.
        bodies: the robots by name.
        functions: the transfer functions, in order.
        ignored: the elements that are not supported.
    """

    element: Element
    timestep: Element | None
    mode: str
    brain: FileNamed | None
    populations: dict[str, Element]
    bodies: dict[str, FileNamed]
    functions: tuple[Element, ...]
    ignored: tuple[Element, ...]

    @property
    def nest_units(self) -> bool:
        """Whether devices are set in pA, nS and pF, as with NEST without PyNN."""
        return any(word in self.mode.lower() for word in ("directnest", "nestclient"))


def read_experiment(path: Path) -> Experiment:
    """Read an ``.exc`` file.

    Raises:
        ExperimentError: it is not XML.
    """
    root = read_xml(path, ExperimentError)
    environment, bibi, timeout = (child(root, tag) for tag in ("environmentModel", "bibiConf", "timeout"))
    seed = text(root, "rngSeed")
    poses = [pose for place in (environment, root) if place for pose in children(place, "robotPose")]
    machines = [
        FileNamed.of(machine)
        for place in children(root, "experimentControl", "experimentEvaluation")
        for machine in children(place, "stateMachine")
    ]
    return Experiment(
        root,
        text(root, "name") or path.stem,
        text(root, "description"),
        None if timeout is None or not timeout.text else timeout,
        int(seed) if seed.isdecimal() else None,
        None if environment is None else FileNamed.of(environment),
        {attribute(pose, "robotId") or ROBOT: pose for pose in poses},
        None if bibi is None else FileNamed.of(bibi),
        tuple(machine for machine in machines if machine.name),
        _ignored(root),
    )


def experiment_of(bibi: Bibi) -> Experiment:
    """Return a document for a ``.bibi`` file that no ``.exc`` file names."""
    path = bibi.element.path
    named = FileNamed(path.name, bibi.element)
    return Experiment(bibi.element, path.stem, "", None, None, None, {}, named, (), ())


def read_bibi(path: Path) -> Bibi:
    """Read a ``.bibi`` file.

    Raises:
        ExperimentError: it is not XML.
    """
    root = read_xml(path, ExperimentError)
    brain, timestep = child(root, "brainModel"), child(root, "timestep")
    file = None if brain is None else FileNamed.of(brain)
    chosen = [] if brain is None else children(brain, "populations", "neuronGroup")
    populations = {attribute(one, "population") or "": one for one in chosen}
    bodies = [
        (attribute(body, "robotId") or ROBOT, FileNamed.of(body)) for body in children(root, "bodyModel")
    ]
    return Bibi(
        root,
        None if timestep is None or not timestep.text else timestep,
        text(root, "mode"),
        file if file and file.name else None,
        {name: one for name, one in populations.items() if name},
        {name: body for name, body in bodies if body.name},
        tuple(child for child in root.children if local(child.tag).startswith(FUNCTION)),
        _ignored(root),
    )


def _ignored(root: Element) -> tuple[Element, ...]:
    said = [one for one in children(root, *_IGNORED) if one.text or one.children or one.attributes]
    return tuple(said + [one for one in children(root, "physicsEngine") if one.text.lower() == "opensim"])


def is_active(function: Element) -> bool:
    """Return whether a transfer function runs; ``active="false"`` switches one off."""
    return flag(function, "active", True)


def priority_of(function: Element) -> int:
    """Return the priority of a transfer function; within a step, higher priorities run first.

    A value that is not a number is ignored.
    """
    with suppress(ExperimentError):
        return int(number(function, "priority") or 0)
    return 0
