"""The two documents of an experiment of the platform, as plain data.

XML is read leniently: by local names, in any order; other content is ignored. Poses come in every historical
form.
"""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass
from math import isfinite, nan, sqrt
from pathlib import Path

from nrp_core.errors import ExperimentError
from nrp_core.world import Pose
from nrp_core.xml import Element, read_xml

_DURATION = re.compile(
    r"P(?:(?P<days>\d+)D)?(?:T(?:(?P<hours>\d+)H)?(?:(?P<minutes>\d+)M)?(?:(?P<seconds>\d+(?:\.\d*)?)S)?)?"
)
_SHORTEST, _LONGEST = 1e-6, 1e9  # of the step, in ms: the resolution of time is 1 ns
_SECONDS = {"days": 86_400.0, "hours": 3600.0, "minutes": 60.0, "seconds": 1.0}


def local(name: str) -> str:
    """Return a name without its prefix."""
    return name.rpartition(":")[2]


def children(element: Element, *names: str) -> list[Element]:
    """Return the children of these local names, in their order."""
    return [child for child in element.children if local(child.tag) in names]


def child(element: Element, *names: str) -> Element | None:
    """Return the first child of one of these local names."""
    return next(iter(children(element, *names)), None)


def text(element: Element, *names: str) -> str:
    """Return the text of the first such child, on one line, or an empty text."""
    found = child(element, *names)
    return " ".join(found.text.split()) if found is not None else ""


def attribute(element: Element, *names: str) -> str | None:
    """Return the first of these attributes that is given, by its local name."""
    given = {local(name): value.strip() for name, value in element.attributes.items()}
    return next((given[name] for name in names if given.get(name)), None)


def number(element: Element, name: str) -> float | None:
    """Return an attribute that is a number, None if it is missing.

    Raises:
        ExperimentError: it is not a number.
    """
    value = attribute(element, name)
    try:
        found = None if value is None else float(value)
    except ValueError:
        found = nan
    if found is not None and not isfinite(found):
        raise element.error(f"'{name}' of <{element.tag}> must be a number, not '{value}'")
    return found


def flag(element: Element, name: str, default: bool) -> bool:
    """Return an attribute that is true or false; other values are ignored."""
    known = {"true": True, "1": True, "false": False, "0": False}
    return known.get((attribute(element, name) or "").lower(), default)


def milliseconds_of(element: Element) -> float:
    """Return the number of milliseconds that an element holds.

    Raises:
        ExperimentError: it is not a positive number.
    """
    try:
        found = float(element.text)
    except ValueError:
        found = nan
    if found and not _SHORTEST <= found <= _LONGEST:
        raise element.error(f"<{element.tag}> must be a number of milliseconds, not '{element.text}'")
    return found


def seconds_of(element: Element) -> float:
    """Return the duration that an element holds: ``840``, ``840.0`` or, as XML Schema writes it, ``PT14M``.

    Raises:
        ExperimentError: it is neither.
    """
    said = element.text
    match = _DURATION.fullmatch(said)
    try:
        if match is not None and any(match.groups()):
            found = sum(float(part) * _SECONDS[unit] for unit, part in match.groupdict().items() if part)
        else:
            found = float(said)
    except ValueError:
        found = nan
    if found and not _SHORTEST <= found <= _LONGEST:
        raise element.error(
            f"<{element.tag}> must be a time in seconds or a duration such as PT14M, not '{said}'"
        )
    return found


PoseNumbers = tuple[float, float, float, float, float, float]
"""x, y, z in m; roll, pitch, yaw in rad."""


def pose_of(element: Element) -> PoseNumbers:
    """Return a ``<robotPose>``: angles, or the quaternion ``ux uy uz theta``, theta its real part.

    If both are given, the angles are used; missing values are 0.

    Raises:
        ExperimentError: a value is not a number.
    """
    x, y, z = (number(element, name) or 0.0 for name in ("x", "y", "z"))
    angles = [number(element, name) for name in ("roll", "pitch", "yaw")]
    vector = [number(element, name) or 0.0 for name in ("ux", "uy", "uz")]
    real = number(element, "theta")
    if all(angle is None for angle in angles) and (real is not None or any(vector)):
        return (x, y, z, *_rpy(vector, real))
    roll, pitch, yaw = (angle or 0.0 for angle in angles)
    return (x, y, z, roll, pitch, yaw)


def _rpy(vector: list[float], real: float | None) -> tuple[float, float, float]:
    """Return the angles of a quaternion, which need not be of length 1."""
    squares = sum(part * part for part in vector)
    w = sqrt(max(0.0, 1.0 - squares)) if real is None else real
    length = sqrt(squares + w * w)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    qx, qy, qz = (part / length for part in vector)
    return Pose((0.0, 0.0, 0.0), (qx, qy, qz, w / length)).rpy


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
        name: the name in the document, or empty.
        element: the element that names it.
        folders: the folders that it may be in, here or in the library: those of its model and of its robot.
        archive: the archive that it is in, if given.
    """

    name: str
    element: Element
    folders: tuple[str, ...] = ()
    archive: str | None = None

    @classmethod
    def of(cls, element: Element) -> FileNamed:
        """Read a file name from an attribute, a child element, or the text of the element.

        ``assetPath`` is the folder of a model, or an archive with it; a model without a file is named by its
        folder.
        """
        asset = attribute(element, "assetPath") or ""
        archive = asset if asset.lower().endswith(".zip") else None
        model = attribute(element, "model") or (asset[:-4] if archive else asset)
        folders = dict.fromkeys(filter(None, (model, attribute(element, "robotId"))))
        name = attribute(element, "src") or text(element, "file", "src") or element.text.strip()
        return cls(name or archive or model, element, tuple(folders), archive)

    @property
    def names(self) -> tuple[str, ...]:
        """All possible names, the most likely one first."""
        return tuple(dict.fromkeys((self.archive or self.name, self.name)))


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
