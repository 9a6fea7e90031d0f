"""Make the parts of an experiment of the platform; omit and report parts that cannot be made."""

from __future__ import annotations

import ast
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from os.path import relpath
from pathlib import Path
from types import MappingProxyType

from nrp_pynest.built import to_built_brain

from nrp_core.brain import Network
from nrp_core.dsl import Flow, Listing, PythonSource, TransferFunction, message_type
from nrp_core.errors import NrpError
from nrp_core.experiment import Build, Collector, Experiment, Maker, Omission, Participant, Run, build_here
from nrp_core.findings import Code, Finding, Level
from nrp_core.parameters import BRAIN, FUNCTIONS, Declared, read_in_groups, read_parameters
from nrp_core.world import Model, Scene, World, read_scene
from nrp_core.xml import Element
from nrp_legacy import code
from nrp_legacy.brains import inject_currents, load_brain, remark, with_variables
from nrp_legacy.code import ignore_note
from nrp_legacy.documents import Bibi
from nrp_legacy.files import EMPTY_ROOM, Library
from nrp_legacy.functions import code_of, load, sources_of
from nrp_legacy.namespace import Namespace
from nrp_legacy.python2_builtins import quotient
from nrp_legacy.robot_watch import RobotWatch
from nrp_legacy.robots import out_of_floor, with_sliding_base
from nrp_legacy.shims.times import CLOCK, declare_clock, publish_clock
from nrp_legacy.state_machines import StateMachines
from nrp_legacy.topics import SharedTopics, find_alias, plain_name, redirect_topics, with_commanded_joints

_PLATFORM = frozenset({"hbp_nrp_cle", "python_cle"})
"""Packages of the platform that have the simulator and the functions' decorators."""
_BRAIN = replace(BRAIN, packages=BRAIN.packages | _PLATFORM)
_FUNCTIONS = replace(FUNCTIONS, packages=FUNCTIONS.packages | _PLATFORM)


class ShimmedMaker(Maker, Participant[Run], ABC):
    """Makes experiments whose files find the names and modules of the platform.

    Args:
        document: the document that errors name if no nearer place is known.
        library: the search path for files.
        machines: the state machines.
        folders: the folders whose modules can be imported.
        nest_units: whether devices are set in NEST's units.
        notes: notes from reading the experiment.

    Attributes:
        names: the initial names and imports of code.
        shared_topics: the topics of the scene that was read last.
        machines: the files of the state machines.
        playing: the state machines of the run that began last.
    """

    playing: StateMachines

    def __init__(
        self,
        document: Path | None,
        library: Library,
        machines: Sequence[Path],
        folders: Sequence[Path],
        *,
        nest_units: bool,
        notes: Sequence[Finding] = (),
    ) -> None:
        self._document, self.library = document, library
        self.find_elsewhere = library.find_mesh
        self.machines, self._folders = list(machines), tuple(folders)
        self._nest_units, self._notes = nest_units, list(notes)
        self._network: Network | None = None
        self._texts: list[str] = []
        self.shared_topics = SharedTopics()
        self._room = Scene(())
        self.names = self._namespace()

    @property
    def can_be_saved(self) -> bool:
        return not self.machines

    def room(self, experiment: Experiment) -> Scene:
        self.shared_topics = SharedTopics()
        self._room = self.shared_topics.in_room(super().room(experiment))
        return self._room

    def robot(self, experiment: Experiment, name: str) -> Model:
        others = experiment.world.robots.keys() - {name}
        sources = list(self.codes(experiment))
        model = out_of_floor(super().robot(experiment, name), self._room)
        model = with_commanded_joints(model, sources, others)
        return self.shared_topics.in_model(with_sliding_base(model, sources, others))

    def codes(self, experiment: Experiment) -> Iterator[str]:
        """Yield the code of all functions and machines, unchanged."""
        yield from self._codes(experiment)
        for path in self.machines:
            yield code.Source.of_file(path).text

    @abstractmethod
    def _codes(self, experiment: Experiment) -> Iterator[str]:
        """Yield the code of all transfer functions."""

    def _namespace(self, seed: int = 0, parameters: Mapping[str, object] = MappingProxyType({})) -> Namespace:
        return Namespace(
            self._note, self.library, self._folders, nest_units=self._nest_units, seed=seed,
            network=self._network, parameters=parameters,
        )  # fmt: skip

    def _known(self, network: Network, path: Path) -> Network:
        """Return the network of a file, whose variables transfer functions can look up from now on."""
        self._network = with_variables(network, path)
        return self._network

    def _begun(self, experiment: Experiment) -> Namespace:
        """Return a new namespace with the brain."""
        self._texts = list(self._codes(experiment))
        return self._namespace(experiment.seed, experiment.function_parameters)

    def brain_parameters(self, experiment: Experiment) -> Declared:
        return read_in_groups(experiment.brain.files, lambda path: read_parameters(path, _BRAIN, _tree))

    def function_parameters(self, experiment: Experiment) -> Declared:
        declared = Declared()
        for path in experiment.transfer_functions:
            read_parameters(path, _FUNCTIONS, _tree, declared)
        return declared

    def _ready(self, loaded: Iterable[TransferFunction], collector: Collector) -> list[TransferFunction]:
        """Return functions in the order of the platform, once all notes are taken."""
        functions = list(loaded)
        collector.findings += self._all_notes()
        # of equal priority, those to the brain ran before those to the robot
        return sorted(functions, key=lambda function: function.flow is not Flow.ROBOT_TO_NEURON)

    def _all_notes(self) -> Iterator[Finding]:
        """Yield each note once, then the files that are missing at their path."""
        yield from dict.fromkeys(self._notes)
        for name, path in self.library.elsewhere.items():
            message = f"there is no '{name}': '{relpath(path, self.library.folder)}' is used"
            yield Finding(Code.NRP204, message, Level.WARNING, self._document, subject=name)

    def _listing(self, names: Namespace, sources: Iterable[PythonSource], collector: Collector) -> Listing:
        """Return pieces of code that share the names of the platform, once all notes are taken."""
        pieces = tuple(sources)
        collector.findings += self._all_notes()
        known = {name: value for name, value in vars(names.module).items() if name[:2] != "__"}
        return Listing(pieces, known, names.scope, self._folders, quotient)

    def declare_missing_topics(self, world: World, functions: Sequence[TransferFunction]) -> None:
        if CLOCK in {
            *self.names.graph.wanted,
            *(topic.name for one in functions for topic in one.subscribed),
        }:
            declare_clock(world)
        aliases = self.aliases(world, functions)
        for name, served in aliases.items():
            world.add_alias(name, served)
            if not served.endswith(name):
                message = f"no topic '{name}': '{served}' is used, the only one like it"
                world.warnings.add(Code.NRP255, message, subject=name)
        for name, kind in {**self._topics_of_rospy(functions), **self.names.graph.wanted}.items():
            if name not in world.topics:
                world.declare(name, kind)
        redirect_topics(functions, world, aliases)
        self.shared_topics.hand_on(world)

    def _topics_of_rospy(self, functions: Sequence[TransferFunction]) -> dict[str, type]:
        """Return the topics that functions read and machines name, or ``rospy`` publishes on, with types."""
        machines = [code.Source.of_file(path).text for path in self.machines]
        read = [topic for one in functions for topic in one.subscribed if topic.topic_type is not None]
        found: dict[str, type] = {}
        for topic in read:
            name = rf"""["']/?{re.escape(topic.name[1:])}["']"""
            published = any(re.search(rf"Publisher\(\s*{name}", text) for text in self._texts)
            if published or any(re.search(name, text) for text in machines):
                found[topic.name] = message_type(topic.topic_type)
        return found

    def aliases(self, world: World, functions: Sequence[TransferFunction]) -> dict[str, str]:
        """Return the topics of a world for other names."""
        topics = [topic for function in functions for topic in (*function.published, *function.subscribed)]
        wanted = {**self.names.graph.wanted, **{plain_name(topic): topic.topic_type for topic in topics}}
        return {name: served for name, kind in wanted.items() if (served := find_alias(name, kind, world))}

    def begin(self, run: Run) -> None:
        publish_clock(run)
        self.names.graph.begin(run)
        self.names.started.begin(run)
        to_built_brain(run.brain.network).begin(run)
        inject_currents(getattr(run.brain.network, "injections", ()), run.brain)
        RobotWatch(run)
        self.playing = StateMachines(self.machines, self.names, run)

    def _note(self, code: Code, message: str, *, subject: str | None = None) -> None:
        self._notes.append(Finding(code, message, Level.WARNING, self._document, subject=subject))


def _tree(path: Path) -> ast.Module:
    """Return a file as Python 3; the notes on its conversion are taken when it is executed."""
    return code.Source.of_file(path).tree(ignore_note)


def _lacking(finding: Finding) -> Finding:
    """Return a finding about a room, in which an actor is omitted, not altered."""
    if finding.subject != "actor":
        return finding
    return replace(
        finding, code=Code.NRP256, message="an <actor> of the room is left out: it is not simulated"
    )


class LegacyMaker(ShimmedMaker):
    """Makes one experiment from the documents of the platform.

    Args:
        bibi: its document.
        library: the search path for files.
        machines: its state machines.
        notes: notes from reading it.
        launch: the element with a launch file if no other element names a robot.
    """

    def __init__(
        self,
        bibi: Bibi,
        library: Library,
        machines: list[Path],
        notes: list[Finding],
        launch: Element | None = None,
    ) -> None:
        self.bibi, self._launch = bibi, launch
        folders = library.folder / "resources", library.folder
        super().__init__(
            bibi.element.path, library, machines, folders, nest_units=bibi.nest_units, notes=notes
        )

    def room(self, experiment: Experiment) -> Scene:
        try:
            scene = super().room(experiment)
        except NrpError as error:
            self._note(Code.NRP256, f"the room is left out and replaced by a plain floor: {error}")
            scene = read_scene(EMPTY_ROOM)
        has_robot = any(joint.takes_commands for model in scene.models for joint in model.joints)
        if self._launch is not None and not has_robot:
            message = "no robot takes part: the launch file brings none, and the room has none"
            at = self._launch.path, self._launch.line
            self._notes.append(Finding(Code.NRP256, message, Level.WARNING, *at))
        return replace(scene, warnings=tuple(map(_lacking, scene.warnings)))

    def _codes(self, experiment: Experiment) -> Iterator[str]:
        for element in self.bibi.functions:
            with suppress(NrpError):
                yield code_of(element, self.library)

    def network(self, experiment: Experiment, build: Build = build_here) -> Network:
        path, populations = experiment.brain.files[""], self.bibi.populations
        try:
            make = partial(
                load_brain, path, populations, experiment.seed, self._folders, self.library,
                experiment.brain.parameters,
            )  # fmt: skip
            network = build(make)
            remark(path, populations, network, self._note)
            return self._known(network, path)
        except NrpError as error:
            self._note(Code.NRP269, f"the brain is left out: {error}")
            return Network({})

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        self.names = self._begun(experiment)
        loaded: list[TransferFunction] = []
        for element in self.bibi.functions:
            omission = Omission(Code.NRP272, "transfer function")
            with collector.during(Code.NRP210, "transfer_functions", omission=omission):
                loaded += load(element, self.bibi.element, self.library, self.names, self._note)
        yield from self._ready(loaded, collector)

    def listings(self, experiment: Experiment, collector: Collector) -> Iterator[Listing]:
        names = self._begun(experiment)  # a run may use those of its functions
        sources: list[PythonSource] = []
        for element in self.bibi.functions:
            omission = Omission(Code.NRP272, "transfer function")
            with collector.during(Code.NRP210, "transfer_functions", omission=omission):
                sources += sources_of(element, self.bibi.element, self.library, self._note)
        yield self._listing(names, sources, collector)
