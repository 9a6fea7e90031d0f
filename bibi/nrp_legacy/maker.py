"""Make the parts of an experiment of the platform, generously: what cannot be made is left out and named."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from nrp_core.brain.network import Network
from nrp_core.dsl.function import Flow, TransferFunction
from nrp_core.errors import NrpError
from nrp_core.experiment.collector import Collector
from nrp_core.experiment.making import Maker
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.run import Run
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.interface import World
from nrp_legacy.aliases import find_alias
from nrp_legacy.brains import load_brain
from nrp_legacy.documents import Bibi
from nrp_legacy.eavesdrop import let_all_talk, plain_name
from nrp_legacy.files import Library
from nrp_legacy.functions import load
from nrp_legacy.machines import StateMachines
from nrp_legacy.namespace import Namespace


class LegacyMaker(Maker):
    """Makes one experiment.

    Args:
        bibi: its document.
        library: where files are.
        machines: its state machines.
        notes: what was found while it was read.
    """

    def __init__(self, bibi: Bibi, library: Library, machines: list[Path], notes: list[Finding]) -> None:
        self._bibi, self._library, self._machines, self._notes = bibi, library, machines, notes
        self._names = self._namespace()

    def _namespace(self) -> Namespace:
        folder = self._library.folder
        return Namespace(self._note, (folder / "resources", folder))

    def network(self, experiment: Experiment) -> Network:
        try:
            return load_brain(experiment.brain.model, self._bibi.populations, experiment.seed, self._note)
        except NrpError as error:
            self._note(f"the brain is left out: {error}")
            return Network({})

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        self._names = self._namespace()
        loaded: list[TransferFunction] = []
        for element in self._bibi.functions:
            with collector.during(Code.NRP210, "transfer_functions", level=Level.WARNING):
                loaded += load(element, self._bibi.element, self._library, self._names, self._note)
        collector.findings += dict.fromkeys(self._notes)
        # of equal priority, those to the robot ran before those to the brain
        yield from sorted(loaded, key=lambda function: function.flow is Flow.ROBOT_TO_NEURON)

    def furnish(self, world: World, functions: Sequence[TransferFunction]) -> None:
        topics = [topic for function in functions for topic in (*function.published, *function.subscribed)]
        wanted = {**self._names.graph.wanted, **{plain_name(topic): topic.topic_type for topic in topics}}
        aliases = {name: served for name, kind in wanted.items() if (served := find_alias(name, kind, world))}
        for name, served in aliases.items():
            world.add_alias(name, served)
        for name, kind in self._names.graph.wanted.items():
            if name not in world.topics:
                world.declare(name, kind)
        let_all_talk(functions, world, aliases)

    def begin(self, run: Run) -> None:
        self._names.graph.begin(run)
        machines = StateMachines(self._machines, self._names, run)
        run.on_close.append(machines.close)

    def _note(self, message: str) -> None:
        self._notes.append(Finding(Code.NRP210, message, Level.WARNING, self._bibi.element.path))
