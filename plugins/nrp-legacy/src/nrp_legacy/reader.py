"""Read an ``.exc`` file and the files that it names as one of our experiments."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial, reduce
from math import ceil
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from nrp_pynest.cerebellum import CEREBELLAR
from nrp_pynest.equations import EQUATIONS

from nrp_core.clock import NS_PER_MS, NS_PER_S, from_milliseconds
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Experiment, Place, Tree, experiment_of, overridden
from nrp_core.findings import Code, Finding, InvalidExperimentError, Level
from nrp_core.paths import MissingFileError, existing_folder
from nrp_core.xml import Element
from nrp_legacy import documents
from nrp_legacy.code import Source
from nrp_legacy.document_checks import check_documents
from nrp_legacy.documents import local, milliseconds_of, pose_of, seconds_of
from nrp_legacy.files import EMPTY_ROOM, NO_BRAIN, Library, installed_models, models_beside
from nrp_legacy.functions import code_of
from nrp_legacy.launch_files import spawned_models
from nrp_legacy.maker import LegacyMaker
from nrp_legacy.state_machines import check_machine_file

TIMESTEP_MS = 20.0
"""The default period of a loop."""

WORLD_STEP_NS = 2 * NS_PER_MS
"""Step of the worlds here, unless an experiment sets it."""

_IN_EQUATIONS = (*CEREBELLAR, *EQUATIONS)
_PLAIN_ROOM = "empty_world"
"""A room of the platform that has only a floor and a sun."""
_LIGHT = re.compile(r"<light\b|model://sun\b")
_IMAGE = re.compile(r"\bsensor_msgs\b.*\bImage\b")
"""The type of a topic that a function reads."""

Read = TypeVar("Read")


def read_exc(path: Path, overrides: Sequence[str] = ()) -> Experiment:
    """Read an experiment of the platform, to run it unchanged.

    Args:
        path: the ``.exc`` file; ``..`` and the library of models are relative to its folder.
        overrides: ``dotted.key=value`` of our own format; ``models=[DIR]`` sets the folders of models.

    Raises:
        InvalidExperimentError: the files are not XML, or no file connects brain and body.
    """
    return _read(lambda: _Reading(path.resolve(), overrides).experiment())


def read_described(path: Path, overrides: Sequence[str] = ()) -> Experiment | None:
    """Return the experiment of a ``.bibi`` file: that of the one ``.exc`` file that names it, else it alone.

    Args:
        path: the file; only a ``.bibi`` file that names a brain or a body describes an experiment.
        overrides: as for :func:`read_exc`.

    Raises:
        InvalidExperimentError: it is not XML.
    """
    path = path.resolve()
    if path.suffix != ".bibi":
        return None
    bibi = _read(lambda: documents.read_bibi(path))
    if bibi.brain is None and not bibi.bodies:
        return None
    for exc in sorted(path.parent.glob("*.exc")):
        with suppress(ExperimentError, MissingFileError):
            reading = _Reading(exc, overrides)
            if reading.bibi_path == path:
                return _read(reading.experiment)
    return _read(_Reading(path, overrides, documents.experiment_of(bibi)).experiment)


def _read(read: Callable[[], Read]) -> Read:
    try:
        return read()
    except InvalidExperimentError:
        raise
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error
    except MissingFileError as error:
        raise InvalidExperimentError([Finding(Code.NRP204, str(error))]) from error


class _Reading:
    def __init__(self, path: Path, overrides: Sequence[str], exc: documents.Experiment | None = None) -> None:
        self._path, self._overrides = path, overrides
        self._exc = exc or documents.read_experiment(path)
        self._chosen = [one for one in overrides if one.partition("=")[0].strip().startswith("models")]
        models = reduce(overridden, self._chosen, Tree({})).plain().get("models", [])
        given, beside = [existing_folder(folder) for folder in models], models_beside(path.parent)
        self._library = Library(path.parent, [*given, *beside] if given else [*beside, *installed_models()])
        self._notes: list[Finding] = []
        self._lacks_model = False
        self.bibi_path = self._bibi_file().resolve()
        self._bibi = documents.read_bibi(self.bibi_path)
        self._launches = [one for one in self._exc.ignored if local(one.tag) == "rosLaunch"]

    def experiment(self) -> Experiment:
        exc, bibi = self._exc, self._bibi
        for element in (*exc.ignored, *bibi.ignored):
            if element not in self._launches:
                self._note(element, Code.NRP216, f"<{local(element.tag)}> is not supported: ignored")
        self._notes += check_documents(exc, bibi)
        timestep_ns = from_milliseconds(self._time(bibi.timestep, TIMESTEP_MS, milliseconds_of))
        duration_ns = (
            ceil(self._time(exc.timeout, documents.DURATION_S) * NS_PER_S / timestep_ns) * timestep_ns
        )
        tree = self._tree({
            "name": exc.name, "description": exc.description, "seed": exc.seed or 0,
            "timestep": f"{timestep_ns} ns", "duration": f"{duration_ns} ns",
            "brain": self._brain(), "world": self._world(timestep_ns),
            "tf_time": "summed", "on_error": "quarantine", "strict": False,
            "models": self._tree([self._tree(str(folder)) for folder in self._library.roots()]),
        })  # fmt: skip
        experiment = experiment_of(tree, [one for one in self._overrides if one not in self._chosen])
        if self._lacks_model and not self._library.has_models:
            message = "there is no folder of models: name it by --models or NRP_MODELS"
            self._note(exc.element, Code.NRP204, message)
        machines = [file for one in exc.machines if (file := self._machine(one))]
        launch = next((one for one in self._launches if not experiment.world.robots), None)
        maker = LegacyMaker(bibi, self._library, machines, self._notes, launch)
        experiment = experiment.with_maker(maker).with_overrides(self._overrides)
        return experiment.with_csv_folder(self._path.parent / "csv")

    # -- the parts

    def _bibi_file(self) -> Path:
        named = self._exc.bibi
        path = None if named is None else self._library.find(named)
        if path is not None:
            return path
        element = self._exc.element if named is None else named.element
        said = (
            "does not name a <bibiConf>" if named is None else f"names '{named.name}', which does not exist"
        )
        beside = sorted(self._path.parent.glob("*.bibi"))
        if len(beside) != 1:
            raise element.error(f"the experiment {said}")
        self._note(element, Code.NRP204, f"the experiment {said}: {beside[0].name} in its folder is used")
        return beside[0]

    def _brain(self) -> Tree:
        brain = self._bibi.brain
        found = None if brain is None else self._read(partial(self._library.find_brain, brain))
        if brain is not None and found is None:
            self._lacks_model = True
            self._note(
                brain.element,
                Code.NRP269,
                f"brain '{brain.name}' not found: the experiment runs without neurons",
            )
        backend = "spinnaker" if "spinnaker" in self._bibi.mode.lower() else "event"
        model = found or NO_BRAIN
        content = {
            "backend": backend,
            "model": str(model),
            **(self._grid(model) if backend == "event" else {}),
        }
        return self._tree(content, brain.element if brain else None)

    def _grid(self, model: Path) -> dict[str, Any]:
        """Return the time grid for a script with cells that only exist as equations."""
        chosen = [one.partition("=")[2].strip() for one in self._overrides if one.startswith("brain.backend")]
        if model.suffix != ".py" or chosen[-1:] not in ([], ["event"]):
            return {}
        text = Source.of_file(model).text
        return {"options": {"resolution": "0.1 ms"}} if any(name in text for name in _IN_EQUATIONS) else {}

    def _world(self, timestep_ns: int) -> Tree:
        environment = self._exc.environment
        is_named = environment is not None and environment.name
        scene = self._read(partial(self._library.find_sdf, environment)) if environment and is_named else None
        if scene is None:
            self._note_plain_floor(environment)
        bodies = self._bibi.bodies.items()
        robots = {_identifier(name): robot for name, body in bodies if (robot := self._robot(name, body))}
        robots = dict(self._launched()) | robots
        element = environment.element if environment else None
        options: dict[str, Any] = {**_physics(timestep_ns), **self._light(scene or EMPTY_ROOM)}
        content: dict[str, Any] = {"backend": "mujoco", "scene": str(scene or EMPTY_ROOM)}
        content |= {"options": options} if options else {}
        return self._tree({**content, "robots": self._tree(robots)}, element)

    def _note_plain_floor(self, environment: documents.FileNamed | None) -> None:
        """Report that a plain floor replaces the room, which is a part less unless the room is one itself."""
        if environment is None or not environment.name:
            code, said = Code.NRP256, "the experiment does not name a room"
        else:
            is_plain = PurePosixPath(environment.name).stem == _PLAIN_ROOM
            code, said = (Code.NRP204 if is_plain else Code.NRP256), f"room '{environment.name}' not found"
            self._lacks_model = self._lacks_model or not is_plain
        self._note(
            environment.element if environment else self._exc.element, code, f"{said}: a plain floor is used"
        )

    def _light(self, room: Path) -> dict[str, str]:
        """Return the renderer with Gazebo's light if functions read images, for which they were tuned in it.

        A room without a light has the flat one, and so have engines that draw by themselves.
        """
        chosen = [one.partition("=")[2].strip() for one in self._overrides if one.startswith("world.backend")]
        is_ours = not chosen or chosen[-1] in ("mujoco", "pybullet")
        is_lit = is_ours and _LIGHT.search(room.read_text("utf-8", "replace")) is not None
        codes: list[str] = []
        for element in self._bibi.functions:
            with suppress(ExperimentError):
                codes.append(code_of(element, self._library))
        reads = any(_IMAGE.search(one) for one in codes)
        return {"renderer": "realistic"} if is_lit and reads else {}

    def _robot(self, name: str, body: documents.FileNamed) -> Tree | None:
        model = self._read(partial(self._library.find_sdf, body))
        if model is None:
            self._lacks_model = True
            self._note(body.element, Code.NRP256, f"robot '{body.name}' not found: left out", subject=name)
            return None
        poses = self._exc.poses
        only = next(iter(poses.values())) if len(poses) == len(self._bibi.bodies) == 1 else None
        pose = poses.get(name, only)
        numbers = None if pose is None else self._read(partial(pose_of, pose))
        place = (
            {} if numbers is None else {"pose": self._tree([self._tree(one, pose) for one in numbers], pose)}
        )
        return self._tree({"model": str(model), **place}, body.element)

    def _launched(self) -> Iterator[tuple[str, Tree]]:
        """Yield the robots that launch files spawn."""
        for element in self._launches:
            named = documents.FileNamed.of(element)
            path = self._library.find(named)
            spawned = self._read(partial(spawned_models, path, self._library)) if path else None
            said = "only the models that it spawns take part" if spawned else "it is not supported: ignored"
            self._note(element, Code.NRP216, f"<rosLaunch> '{named.name}': {said if path else 'not found'}")
            for one in spawned or []:
                if one.file is None:
                    message = f"robot '{one.name}', which '{named.name}' spawns, not found: left out"
                    self._note(one.element, Code.NRP256, message, subject=one.name)
                else:
                    pose = self._tree([self._tree(number) for number in one.pose], one.element)
                    yield (
                        _identifier(one.name),
                        self._tree({"model": str(one.file), "pose": pose}, one.element),
                    )

    def _time(
        self, element: Element | None, default: float, read: Callable[[Element], float] = seconds_of
    ) -> float:
        """Return the time in an element, or the default."""
        said = None if element is None else self._read(partial(read, element))
        if said == 0 and element is not None:
            unit = "s" if read is seconds_of else "ms"
            self._note(element, Code.NRP216, f"the <{local(element.tag)}> is 0: {default:g} {unit} are used")
        return said or default

    def _read(self, read: Callable[[], Read]) -> Read | None:
        """Return the result of a reader, None if it fails."""
        try:
            return read()
        except ExperimentError as error:
            note = f"{error.message}: not used"
            self._notes.append(Finding(Code.NRP216, note, Level.WARNING, error.path, error.line))
            return None

    # -- notes and options

    def _machine(self, named: documents.FileNamed) -> Path | None:
        path = self._library.find(named)
        if path is None:
            message = f"state machine '{named.name}' not found: left out"
            self._note(named.element, Code.NRP272, message, subject=named.name)
        else:
            self._notes += check_machine_file(path)
        return path

    def _note(self, element: Element, code: Code, message: str, *, subject: str | None = None) -> None:
        where = element.path, element.line
        self._notes.append(Finding(code, message, Level.WARNING, *where, subject=subject))

    def _tree(self, value: Any, element: Element | None = None) -> Tree:
        """Return a value, and the values of a mapping, with the place of an element."""
        at = element or self._exc.element
        place = Place(at.path, at.line)
        if isinstance(value, dict):
            value = {key: one if isinstance(one, Tree) else self._tree(one, at) for key, one in value.items()}
        return Tree(value, place, place)


def _physics(timestep_ns: int) -> dict[str, Any]:
    """Return the options of a world if its default step does not divide that of the loop."""
    parts = ceil(timestep_ns / WORLD_STEP_NS)
    while timestep_ns % parts:
        parts += 1
    step_ns = timestep_ns // parts
    return {} if timestep_ns % WORLD_STEP_NS == 0 else {"timestep": f"{step_ns} ns"}


def _identifier(name: str) -> str:
    """Return the name of a robot, reduced to letters, digits and ``_``."""
    plain = re.sub(r"\W", "_", name)
    return plain if plain.isidentifier() else f"_{plain}"
