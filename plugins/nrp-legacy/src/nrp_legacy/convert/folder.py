"""Write an experiment of the platform as a folder in our own format.

Rooms and robots come with the models that they refer to. State machines that only wait for times and change
colours become events.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from ruamel.yaml import YAML

from nrp_core.clock import milliseconds, seconds
from nrp_core.dsl.testing import MockWorld
from nrp_core.errors import ExperimentError
from nrp_core.experiment import (
    BackendSection,
    Experiment,
    Maker,
    Plan,
    load_functions,
    make_parts,
    prepare,
    read_yaml,
)
from nrp_core.world import JointController, Mesh, Model, Scene, TrajectoryController
from nrp_legacy.code import Source, ignore_note
from nrp_legacy.convert.brain import copy_neighbours, links_to_elsewhere, write_brain
from nrp_legacy.convert.functions import Functions, write_texts
from nrp_legacy.convert.python import modern
from nrp_legacy.files import Library
from nrp_legacy.imported import RESOURCES
from nrp_legacy.maker import LegacyMaker
from nrp_legacy.namespace import Namespace
from nrp_legacy.reader import read_exc
from nrp_legacy.shims.service_states import SetMaterialColorServiceState
from nrp_legacy.shims.smach import StateMachine
from nrp_legacy.shims.states import ClientLogState, ClockDelayState, PollingState, WaitToClockState
from nrp_legacy.state_machines import machine_in
from nrp_legacy.topics import plain_name

_PACKAGE = Path(__file__).resolve().parents[1]
"""The folder of the rooms and robots that stand in for missing ones."""
MODELS, _MANIFEST = "models", "model.config"
_REFERENCE = re.compile(r"(?:model|package)://([\w.-]+)")
_TEXTS = (".sdf", ".urdf", ".world", ".xacro")


class Models:
    """Copies models into a folder, each once.

    Of a folder that is not a model of Gazebo only files that the scene shows are copied, and nothing from
    outside the folders of the experiment and of models.

    Args:
        library: the search path for models.
        folder: the folder of the imported experiment.
        scene: the scene of the experiment.
    """

    def __init__(self, library: Library, folder: Path, scene: Scene) -> None:
        self._library, self._folder = library, folder
        self._shown = {path.resolve() for path in _shown_files(scene)}
        self._copied: set[Path] = set()

    def copy(self, path: Path) -> str:
        """Copy a room or robot and the files that it uses; return its file, relative to the folder.

        Raises:
            ExperimentError: it is outside the folders of the experiment and of models.
        """
        allowed = [_PACKAGE, *(root.resolve() for root in self._library.roots())]
        if not any(path.resolve().is_relative_to(root) for root in allowed):
            raise ExperimentError(
                f"{path} is not imported, because it is outside the folders of the experiment and of models; "
                "copy it into the experiment's folder, or name the folder with --models"
            )
        self._shown.add(path.resolve())
        if path.parent in (self._library.folder, self._library.folder.parent):
            shutil.copy(path, self._folder / path.name)
            self._follow(path)
            return path.name
        self._copy_folder(path.parent)
        return f"{MODELS}/{path.parent.name}/{path.name}"

    def _copy_folder(self, source: Path) -> None:
        if source in self._copied:
            return
        self._copied.add(source)
        target = self._folder / MODELS / source.name
        for path in sorted(source.rglob("*")):
            is_own = (source / _MANIFEST).is_file() and path.resolve().is_relative_to(source.resolve())
            if not path.is_file() or not (is_own or path.resolve() in self._shown):
                continue
            copied = target / path.relative_to(source)
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copied)
            if path.suffix in _TEXTS:
                self._follow(path)

    def _follow(self, path: Path) -> None:
        for name in dict.fromkeys(_REFERENCE.findall(path.read_text("utf-8", "replace"))):
            found = (root / name for root in self._library.roots())
            folder = next((folder for folder in found if folder.is_dir()), None)
            if folder is not None:
                self._copy_folder(folder.resolve())


def _shown_files(scene: Scene) -> Iterator[Path]:
    """Yield the files of meshes and images of a scene."""
    for _, link in scene.links():
        shapes = [visual.geometry for visual in link.visuals]
        shapes += [collision.geometry for collision in link.collisions]
        yield from (shape.path for shape in shapes if isinstance(shape, Mesh))
        yield from (visual.texture.image for visual in link.visuals if visual.texture is not None)


def add_controllers(
    path: Path, controllers: list[JointController], followers: list[TrajectoryController]
) -> bool:
    """Write controllers of joints into the file of a robot; return whether this succeeded."""
    text = path.read_text("utf-8")
    before, end, after = text.rpartition("</model>")
    if not end:
        return False
    lines = [
        f"    <controller joint_name={quoteattr(one.joint)}><type>{one.kind}</type>"
        f"<topic>{one.topic}</topic></controller>"
        for one in controllers
    ]
    plugin = [
        '<plugin name="commanded_joints" filename="libgeneric_controller_plugin.so">',
        *lines,
        "  </plugin>",
    ]
    added = [*(plugin if lines else []), *map(_plugin, followers)]
    path.write_text(before + "  " + "\n".join(added) + "\n  " + end + after, encoding="utf-8")
    return True


def _plugin(follower: TrajectoryController) -> str:
    joints = "".join(f"<joint_name>{joint}</joint_name>" for joint in follower.joints)
    return (
        f'<plugin name={quoteattr(follower.name)} filename="gz-sim-joint-trajectory-controller-system">'
        f"<topic>{follower.command_topic}</topic>{joints}</plugin>"
    )


def events_of(path: Path, names: Namespace) -> dict[str, Any] | None:
    """Return a machine as events by name; None if events cannot express it.

    Args:
        path: its file.
        names: its initial names and imports.
    """
    module = names.fresh()
    try:
        names.scope.run(path, module, Source.of_file(path).compiled(ignore_note))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
        raise names.scope.located(error, ExperimentError, path) from None
    machine = machine_in(module)
    return _events(machine, path.stem) if isinstance(machine, StateMachine) else None


def _events(machine: StateMachine, stem: str) -> dict[str, Any] | None:
    states: Mapping[str, Any] = machine._states
    label, now_ns, seen = machine._initial, 0, set[str]()
    events: dict[str, Any] = {}
    while label in states and label is not None:
        state, ways = states[label], machine._transitions[label]
        if label in seen:
            return None
        seen.add(label)
        if isinstance(state, WaitToClockState):
            now_ns, outcome = max(now_ns, state.end_ns), "invalid"
        elif isinstance(state, ClockDelayState):
            now_ns, outcome = now_ns + state.delay_ns, "invalid"
        elif isinstance(state, SetMaterialColorServiceState):
            model, link, visual, _, color = state.values
            topic = f"/{model}/{link}/{visual}/color"
            name = f"{stem}_{label}".replace("-", "_").replace(" ", "_")
            events[name] = {"at": f"{seconds(now_ns):g} s", "publish": {"topic": topic, "value": color}}
            outcome = "succeeded"
        elif isinstance(state, ClientLogState):
            outcome = "succeeded"
        else:
            return events if _only_look(machine, label) else None
        label = ways.get(outcome)
    return events


def _only_look(machine: StateMachine, label: str) -> bool:
    """Return whether all states that can follow a state have no effect."""
    waiting, seen = [label], set[str]()
    while waiting:
        one = waiting.pop()
        if one in machine._states and one not in seen:
            seen.add(one)
            waiting += machine._transitions[one].values()
    return all(isinstance(machine._states[one], (PollingState, ClientLogState)) for one in seen)


FILE, FUNCTIONS, MACHINES, REPORT = "experiment.yaml", "transfer_functions", "state_machines", "import.md"
PLATFORM = "hbp_nrp"


@dataclass
class Report:
    """The differences from the original.

    Attributes:
        changed: parts that are written differently but mean the same.
        kept: parts that are unchanged because they need the platform; a comment in the experiment names them.
        left_out: parts without a counterpart.
        noted: parts that a run of the original also leaves out or replaces.
    """

    changed: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)


def write_folder(experiment: Experiment, folder: Path) -> Report:
    """Write an experiment into a folder.

    Args:
        experiment: the experiment, from :func:`nrp_legacy.reader.read_exc`.
        folder: the target folder, which is created.

    Raises:
        ExperimentError: it cannot be read.
    """
    maker = experiment.maker
    assert isinstance(maker, LegacyMaker)
    plan = prepare(experiment)
    folder.mkdir(parents=True, exist_ok=True)
    kept: dict[str, str] = {}
    while True:
        writing = _Import(experiment, maker, plan, folder, kept)
        missing = writing.done()
        if not missing.keys() - kept.keys():
            return writing.finished(missing)
        kept |= missing
        for written in (FUNCTIONS, MACHINES):
            shutil.rmtree(folder / written, ignore_errors=True)


def import_exc(path: Path, folder: Path, overrides: Sequence[str] = ()) -> Mapping[str, object]:
    """Write the experiment of an ``.exc`` file into a folder, and return lists of notes by title."""
    return vars(write_folder(read_exc(path, overrides), folder))


def _chosen(section: BackendSection) -> dict[str, Any]:
    """Return the section of an experiment file for a backend."""
    options = {key: str(value) if isinstance(value, str) else value for key, value in section.options.items()}
    return {"backend": section.backend, **({"options": options} if options else {})}


class _Import:
    """One attempt at writing the experiment.

    Args:
        experiment: the original.
        maker: makes its parts.
        plan: its parts.
        folder: the target folder.
        kept: functions that need the platform, with the reasons.
    """

    def __init__(
        self,
        experiment: Experiment,
        maker: LegacyMaker,
        plan: Plan,
        folder: Path,
        kept: Mapping[str, str],
    ) -> None:
        self._experiment, self._maker, self._folder, self._plan = experiment, maker, folder, plan
        self._report = Report(noted=[str(one.message) for one in plan.warnings])
        self._functions = Functions(maker, plan.functions, kept)

    def done(self) -> dict[str, str]:
        """Write the experiment; return the functions that are missing from it, with the reasons."""
        exp, report = self._experiment, self._report
        brain, world = self._brain(), self._world()
        events = self._events()
        report.kept += [*self._functions.needs, *self._conversations()]
        on_platform = bool(report.kept)
        document: dict[str, Any] = {"name": exp.name}
        if exp.description:
            document["description"] = exp.description
        document |= {
            "timestep": f"{milliseconds(exp.timestep):g} ms",
            "duration": f"{milliseconds(exp.duration) / 1000:.10g} s",
            "seed": exp.seed,
            "brain": {**_chosen(exp.brain), **brain},
            "world": {**_chosen(exp.world), **world},
            "transfer_functions": self._written_functions(on_platform),
            "tf_time": exp.tf_time, "on_error": exp.on_error, "strict": False, "csv_folder": "csv",
        }  # fmt: skip
        if on_platform:
            document["compatibility"] = {"platform": PLATFORM, "options": self._options(events is None)}
        elif aliases := self._aliases():
            document["aliases"] = aliases
        if (self._folder / "models").is_dir():
            document["models"] = ["models"]
        if events:
            document["events"] = events
        with (self._folder / FILE).open("w", encoding="utf-8") as file:
            YAML().dump(document, file)
        return self._missing()

    def finished(self, missing: Mapping[str, str]) -> Report:
        """Write the report and return it."""
        self._report.left_out += [f"{name}: {reason}" for name, reason in missing.items()]
        self._write_report()
        return self._report

    # -- brain and world

    def _brain(self) -> dict[str, Any]:
        network = self._plan.network
        assert network is not None
        names, exp = list(self._maker.bibi.populations), self._experiment
        brain = write_brain(exp.brain.files[""], network, names, exp.seed, self._folder, self._beside)
        self._report.changed += brain.changes
        self._report.kept += [brain.need] if brain.need else []
        return brain.section

    def _world(self) -> dict[str, Any]:
        models = Models(self._maker.library, self._folder, self._scene)
        world = self._experiment.world
        robots: dict[str, Any] = {}
        assert world.scene is not None, "an experiment of that platform always has a room"
        scene = models.copy(world.scene)
        for name, robot in world.robots.items():
            assert robot.model is not None, "each robot of that platform has a file"
            robots[name] = {"model": models.copy(robot.model)}
            plain = Maker().robot(self._experiment, name)
            model = next((one for one in self._scene.models if one.name == name), None)
            if robot.pose is not None:
                lift = 0.0 if model is None else model.pose.position[2] - plain.pose.position[2]
                x, y, z, *turns = robot.pose
                robots[name]["pose"] = [x, y, z + lift, *turns]
            if model is not None:
                self._commanded(model, plain, self._folder / robots[name]["model"])
        return {"scene": scene, **({"robots": robots} if robots else {})}

    def _commanded(self, model: Model, robot: Model, path: Path) -> None:
        """Add the controllers that were inferred from commands to the file of a robot.

        Args:
            model: the robot as it takes part.
            robot: the robot as its file describes it.
            path: the file.
        """
        of_file = {(one.joint, one.kind) for one in robot.controllers}
        topics = {one.command_topic for one in robot.trajectory_controllers}
        commanded = [one for one in model.controllers if one.initial is None]
        added = [one for one in commanded if (one.joint, one.kind) not in of_file]
        if model.drives != robot.drives:
            topic = model.drives[0].command_topic
            self._report.kept.append(
                f"{path.name}: the body slides on {topic}; the file needs a drive for it"
            )
        followers = [one for one in model.trajectory_controllers if one.command_topic not in topics]
        names = [*(one.joint for one in added), *(joint for one in followers for joint in one.joints)]
        if not names:
            return
        joints = ", ".join(dict.fromkeys(names))
        what = f"{path.name}: controllers for commanded joints: {joints}"
        (self._report.changed if add_controllers(path, added, followers) else self._report.kept).append(what)

    @property
    def _scene(self) -> Scene:
        return self._plan.scene

    def _aliases(self) -> dict[str, str]:
        return self._maker.aliases(MockWorld(scene=self._scene), self._plan.functions)

    # -- transfer functions and state machines

    def _conversations(self) -> list[str]:
        """Return the topics that only the platform allows: used in both directions, or by several parts."""
        functions = self._plan.functions
        topics = {topic for one in functions for topic in (*one.published, *one.subscribed)}
        names = sorted({plain_name(topic) for topic in topics if topic.name != plain_name(topic)})
        shared = [
            f"{name}: shared by several parts of the scene"
            for name in dict.fromkeys(self._maker.shared_topics.names)
        ]
        return [*(f"{name}: used with another direction or type" for name in names), *shared]

    def _written_functions(self, on_platform: bool) -> list[str]:
        folder, library = self._folder / FUNCTIONS, self._maker.library
        functions = self._functions
        texts = functions.texts(on_platform=on_platform)
        write_texts(texts, folder)
        self._report.changed += functions.changes
        if functions.shared and not on_platform:
            shared = ", ".join(sorted(functions.shared))
            self._report.changed.append(
                f"all transfer functions are in one file, because they share {shared}"
            )
        resources = library.folder / RESOURCES
        if resources.is_dir():
            shutil.copytree(resources, folder / RESOURCES, dirs_exist_ok=True, ignore=links_to_elsewhere)
        beside = [library.folder] if on_platform else [resources, library.folder]
        copy_neighbours(texts.values(), [*beside, *self._maker.names.import_path], folder)
        return [f"{FUNCTIONS}/{stem}.py" for stem in texts]

    def _events(self) -> dict[str, Any] | None:
        """Return the state machines as events; None if they stay unchanged."""
        events: dict[str, Any] = {}
        changed, kept = list[str](), list[str]()
        for path in self._maker.machines:
            try:
                found = events_of(path, self._maker.names)
            except ExperimentError as error:
                kept.append(f"the state machine {path.name}: {error.message}")
                continue
            if found is None:
                kept.append(f"the state machine {path.name}: it does more than set colours at fixed times")
            else:
                changed.append(f"{path.name}: events")
                events |= found
        self._report.changed += [] if kept else changed
        self._report.kept += kept
        return None if kept else events

    def _options(self, with_machines: bool) -> dict[str, Any]:
        """Return the platform's options in the experiment file."""
        machines = self._maker.machines if with_machines else []
        options: dict[str, Any] = {"nest_units": True} if self._maker.bibi.nest_units else {}
        if machines:
            folder = self._folder / MACHINES
            folder.mkdir()
            texts = {path.name: self._modern(path) for path in machines}
            for name, text in texts.items():
                (folder / name).write_text(text, encoding="utf-8")
            copy_neighbours(texts.values(), self._beside, folder)
            options["state_machines"] = [f"{MACHINES}/{path.name}" for path in machines]
        return options

    def _modern(self, machine: Path) -> str:
        """Return a state machine in Python 3; text that is not Python stays unchanged."""
        source = Source.of_file(machine)
        with suppress(ExperimentError):
            text, changes = modern(source)
            self._report.changed += [f"{machine.name}: {change}" for change in changes]
            return text
        return source.text

    @property
    def _beside(self) -> list[Path]:
        folder = self._maker.library.folder
        return [folder / RESOURCES, folder]

    # -- the result

    def _missing(self) -> dict[str, str]:
        """Return every function that is missing from the written experiment, with the reason."""
        again = make_parts(read_yaml(self._folder / FILE))
        written = {function.name for function in load_functions(again)}
        reasons: dict[str, list[str]] = {}
        for found in again.collector.findings:
            for name in {found.subject or "", found.path.stem if found.path else ""}:
                reasons.setdefault(name, []).append(str(found))
        return {
            one.name: "; ".join(reasons.get(one.name, ["cannot be bound"]))
            for one in self._plan.functions
            if one.name not in written
        }

    def _write_report(self) -> None:
        lines = [f"# Import of {self._experiment.name}", ""]
        report = self._report
        sections = (
            ("Changed", report.changed),
            (
                f"Kept, with `compatibility: {{platform: {PLATFORM}}}`, because it needs the platform",
                report.kept,
            ),
            ("Left out", report.left_out),
            ("Also left out or replaced in a run of the original", report.noted),
        )
        for title, items in sections:
            lines += [f"## {title}", "", *(f"- {item}" for item in items or ["nothing"]), ""]
        (self._folder / REPORT).write_text("\n".join(lines), encoding="utf-8")
