"""Read an experiment without starting a simulator or executing a transfer function."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import brains
from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.interface import Brain
from nrp_core.brain.network.data import Network
from nrp_core.checks.declarations import Declarations
from nrp_core.checks.declared import Declared, found_in
from nrp_core.checks.evaluation import UnreadableError
from nrp_core.checks.events import Event
from nrp_core.checks.function_body import FunctionBody
from nrp_core.checks.network import ChildBuilder
from nrp_core.checks.scripts import scripts_from
from nrp_core.checks.shapes import UNKNOWN, Known, Number, Shape
from nrp_core.checks.silence import Silence
from nrp_core.checks.skeleton import Ends
from nrp_core.cle.wiring import declare_topics
from nrp_core.clock import seconds
from nrp_core.dsl.functions.function import TIME, TransferFunction
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.loading.listing import Listing, PythonSource
from nrp_core.dsl.loading.loader import DECLARES_NOTHING
from nrp_core.dsl.parameters import binding
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.binding import Binding
from nrp_core.dsl.parameters.topics import PreprocessedTopic, Topic
from nrp_core.dsl.selection.selection import BrainRoot, Selection
from nrp_core.dsl.selection.selectors import Selector, evaluate
from nrp_core.dsl.testing.mocks import MockBrain
from nrp_core.errors import BackendError, ExperimentError, NrpError, TopicError
from nrp_core.experiment.backends import load_backend
from nrp_core.experiment.making.doubtful_mappings import doubtful_mappings
from nrp_core.experiment.making.maker import Maker, maker_of
from nrp_core.experiment.making.prepare import Examination, ProgressCallback
from nrp_core.experiment.making.watch import warn_of_missing_topics
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment, PartMaker
from nrp_core.findings import Code, Finding, Level, has_errors
from nrp_core.findings.error_codes import code_of
from nrp_core.parameters import Declared as Parameters
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World


@dataclass(frozen=True, slots=True)
class Examined:
    """A transfer function and the operations of its body.

    Args:
        declared: the function as it is written.
        adapters: the adapter of each parameter that could be bound.
        events: the operations of its body.
        experiment: the experiment that it belongs to.
        world: the world with the topics.
    """

    declared: Declared
    adapters: dict[str, Adapter]
    events: list[Event]
    experiment: Experiment
    world: World

    @property
    def function(self) -> TransferFunction:
        """The function, with an empty body."""
        return self.declared.function

    @property
    def returns_to(self) -> TopicInfo | None:
        """The topic of its return value, if there is one."""
        topic = self.function.topic
        return None if topic is None or _is_changed(topic) else self.world.topics.get(topic.name)

    def parameter_of(self, shape: Shape) -> str | None:
        """Return the parameter with an adapter, if there is one."""
        found = shape.value if isinstance(shape, Known) else None
        return next((name for name, adapter in self.adapters.items() if adapter is found), None)


class _Reading(Maker):
    """Makes the parts of an experiment without executing them.

    Args:
        maker: makes the parts for a run.
        build: builds networks.
    """

    def __init__(self, maker: PartMaker, build: ChildBuilder) -> None:
        self._maker, self._build = maker, build
        self.read: list[Listing] = []
        self.neighbours: dict[Path, PythonSource] = {}
        self.slices: list[tuple[PythonSource, ast.expr, Selector, slice]] = []
        self.declared: list[Declared] = []
        self.is_complete = True

    def room(self, experiment: Experiment) -> Any:
        return self._maker.room(experiment)

    def robot(self, experiment: Experiment, name: str) -> Any:
        return self._maker.robot(experiment, name)

    def network(self, experiment: Experiment, build: Any = None) -> Network:
        return self._maker.network(experiment, self._build)

    def brain_parameters(self, experiment: Experiment) -> Parameters:
        return self._maker.brain_parameters(experiment)

    def function_parameters(self, experiment: Experiment) -> Parameters:
        return self._maker.function_parameters(experiment)

    def functions(self, experiment: Experiment, collector: Collector) -> Iterator[TransferFunction]:
        level = Level.ERROR if experiment.strict else Level.WARNING
        before = len(collector.findings)
        for listing in self._maker.listings(experiment, collector):
            declarations = Declarations(listing)
            self.read.append(listing)
            self.slices += declarations.slices
            self.neighbours |= {source.path: source for source in declarations.neighbours}
            collector.findings += (at_most(finding, level) for finding in declarations.findings)
            self.declared += declarations.functions
            if not (declarations.functions or declarations.neighbours or experiment.compatibility):
                collector.findings += _declares_nothing(listing)
            self.is_complete &= declarations.is_complete
            yield from (declared.function for declared in declarations.functions)
        # the functions of a file that could not be read are unknown
        self.is_complete &= not has_errors(collector.findings[before:])

    def declare_missing_topics(self, world: World, functions: Any) -> None:
        self._maker.declare_missing_topics(world, functions)


class Study(Examination):
    """An experiment as it is read, without starting or executing anything.

    Args:
        experiment: the experiment.
        progress: called with the name of each task as it begins.
        build: makes its network; by default in a confined process.

    Attributes:
        examined: its transfer functions, in the order in which they run.
        topics: the topics of its world, as far as it could be read.
    """

    def __init__(
        self, experiment: Experiment, progress: ProgressCallback, build: ChildBuilder | None = None
    ) -> None:
        self.examined: list[Examined] = []
        self.topics: Mapping[str, TopicInfo] = {}
        self.devices: Sequence[SourcePort | SinkPort] = ()
        self._build = build or ChildBuilder(*_brain_of(experiment), _limit_s(experiment))
        self._reading = _Reading(maker_of(experiment), self._build)
        super().__init__(experiment.with_maker(self._reading), progress)

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self._experiment

    @property
    def declared(self) -> list[Declared]:
        """Its transfer functions, in the order of the files."""
        return self._reading.declared

    @property
    def is_complete(self) -> bool:
        """Whether all functions are known: every file and all its declarations could be read."""
        return self._reading.is_complete

    @property
    def listings(self) -> list[Listing]:
        """The files of its transfer functions."""
        return self._reading.read

    @property
    def joined(self) -> list[tuple[str, str]]:
        """The pairs of populations of its brain that have synapses, source first."""
        return self._build.joined

    @property
    def linked(self) -> dict[str, Ends]:
        """Which cells of each population have synapses onto them, and which have some onto others."""
        return self._build.linked

    @property
    def mute(self) -> list[str]:
        """The populations of its brain that cannot fire unless a device drives them."""
        return self._build.mute

    @property
    def silent(self) -> list[Silence]:
        """The parts of its brain that are without spikes at first."""
        return self._build.silent

    @property
    def neighbours(self) -> list[PythonSource]:
        """The modules beside them that they import."""
        return list(self._reading.neighbours.values())

    @cached_property
    def scripts(self) -> list[PythonSource]:
        """Its brain script and the modules beside it that it imports, as far as they are plain Python."""
        known = {source.path for source in self._of_functions}
        return [one for one in scripts_from(self.experiment.brain.model) if one.path not in known]

    @property
    def sources(self) -> list[PythonSource]:
        """The files of its transfer functions, those of its brain, and the modules beside them."""
        return [*self._of_functions, *self.scripts]

    @property
    def _of_functions(self) -> list[PythonSource]:
        return [*(source for listing in self.listings for source in listing.sources), *self.neighbours]

    def _brain_fits(self) -> bool:
        if self.brain is None or self.network is None:
            return False
        before = len(self.collector.findings)
        with self.collector.during(Code.NRP216, "brain", "backend"):
            self.brain.capabilities.require(self.network, self._experiment.brain.backend)
            with self.collector.during(Code.NRP350, "brain", "model"):
                if self._build.refusal is not None:
                    raise self._build.refusal
        self.collector.place(self._build.warnings, "brain", "model")
        return not has_errors(self.collector.findings[before:])

    def _check_functions(self, network: Network, world: World) -> None:
        fits = self.brain is not None and self._fits
        brain = MockBrain(network, capabilities=self.brain.capabilities if fits and self.brain else None)
        warn_of_missing_topics(self.collector, self._experiment, world, self.functions)
        ordered = sorted(self._reading.declared, key=lambda declared: -declared.function.priority)
        declare_topics([declared.function for declared in ordered], world)
        self.topics = world.topics
        self.collector.findings += _beyond(self._reading.slices, BrainRoot(network))
        variables: dict[str, Any] = {}
        for declared in ordered:
            self.collector.findings += doubtful_mappings(declared.function, network)
            adapters = self._bound(declared, brain, world, variables)
            events = _events(declared, adapters)
            self.examined.append(Examined(declared, adapters, events, self._experiment, world))
        self.devices = brain.devices

    def _bound(
        self, declared: Declared, brain: Brain, world: World, variables: dict[str, Any]
    ) -> dict[str, Adapter]:
        """Return the adapters of a function's parameters; one that cannot be bound is a finding."""
        function = declared.function
        try:
            bound = function.bind(brain, world, variables=variables).adapters
            return {name: bound[name] for name in function.mappings}
        except (NrpError, ValueError, TypeError) as error:
            whole = error
        before = len(self.collector.findings)
        binding, adapters = Binding(function.name, brain, world, variables), {}
        for name, mapping in function.mappings.items():
            try:
                adapters[name] = mapping.bind(binding)
            except (NrpError, ValueError, TypeError) as error:
                self._refuse(declared, name, error)
        is_mapped = all(name in function.mappings for name in function.parameters)
        if is_mapped and len(self.collector.findings) == before:
            self._refuse(declared, "", whole)
        return adapters

    def _refuse(self, declared: Declared, name: str, error: Exception) -> None:
        """Add the finding that a parameter, or without a name the function, cannot be bound."""
        node = declared.nodes.get(name, declared.node)
        if isinstance(error, UnreadableError):
            message = f"the mapping of '{name or declared.function.name}' is known only when it runs"
            finding = declared.finding(Code.NRP239, node, message, Level.NOTE)
        else:
            level = self._lapse
            if isinstance(error, TopicError) and not self._reading.is_complete:
                level = Level.WARNING  # a file that could not be read may publish it
            code = _code_of(error, declared.function.mappings.get(name))
            message, instead = getattr(error, "message", str(error)), getattr(error, "instead", None)
            finding = declared.finding(code, node, message, level, instead)
        self.collector.findings.append(finding)


_DECORATOR = re.compile(r"Neuron2Robot|Robot2Neuron|NeuronMonitor|import \*|exec|__import__|import_module")
"""Code with which a file may declare functions."""


def _declares_nothing(listing: Listing) -> Iterator[Finding]:
    """Yield a finding if a Python file names no decorator, so that it cannot declare functions."""
    paths = [source.path for source in listing.sources]
    names = {name for source in listing.sources for name in _DECORATOR.findall(ast.unparse(source.tree))}
    if len(paths) == 1 and paths[0].suffix == ".py" and not names:
        yield Finding(Code.NRP210, DECLARES_NOTHING, path=paths[0], line=1)


def _beyond(
    slices: list[tuple[PythonSource, ast.expr, Selector, slice]], root: BrainRoot
) -> Iterator[Finding]:
    """Yield slices beyond the end of a population, which Python silently shortens."""
    for source, node, neurons, index in slices:
        try:
            of, bounds = evaluate(neurons, root), evaluate([index.start, index.stop], root)
        except NrpError:  # reported where it is used
            continue
        beyond = [
            one for one in bounds if isinstance(one, int) and isinstance(of, Selection) and one > of.size
        ]
        if beyond:
            message = f"{neurons!r} has {of.size} neurons, 0..{of.size - 1}; {beyond[-1]} is beyond them"
            yield found_in(source, Code.NRP211, node, message, Level.WARNING)


def _code_of(error: Exception, mapping: binding.Mapping | None) -> Code:
    is_device = isinstance(mapping, (MapSpikeSink, MapSpikeSource))
    return code_of(error, Code.NRP225 if is_device else Code.NRP210)


def _events(declared: Declared, adapters: dict[str, Adapter]) -> list[Event]:
    """Return the operations of a function's body."""
    names: dict[str, Shape] = {**declared.names, TIME: Number("s")}
    names |= dict.fromkeys(declared.function.parameters, UNKNOWN)
    names |= {
        name: Known(adapter)
        for name, adapter in adapters.items()
        if type(adapter) is not Adapter and not _is_changed(declared.function.mappings[name].reads)
    }
    path = declared.source.path
    return FunctionBody(names, declared.node.body, lambda node: declared.imports(node, path)).events


def _is_changed(topic: Topic | None) -> bool:
    """Return whether the messages of a topic are converted."""
    return isinstance(topic, PreprocessedTopic)


def _brain_of(experiment: Experiment) -> tuple[BrainBackend | None, Any]:
    """Return the brain backend of an experiment and its options, if it has one."""
    section = experiment.brain
    try:
        return load_backend(brains(), "brain", section.backend, section.options, experiment.source)
    except (BackendError, ExperimentError):  # reported where it is needed
        return None, None


def _limit_s(experiment: Experiment) -> float | None:
    limit_ns = experiment.brain.time_limit
    return None if limit_ns is None else seconds(limit_ns)


def at_most(finding: Finding, level: Level) -> Finding:
    """Return a finding with its level lowered to a limit."""
    is_worse = finding.level is Level.ERROR and level is not Level.ERROR
    return replace(finding, level=level) if is_worse else finding
