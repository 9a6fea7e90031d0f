"""An experiment as it is read: its parts, and the code of its transfer functions, which is not executed."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.checks.code.body import FunctionBody
from nrp_core.checks.code.declarations import Declarations, Declared
from nrp_core.checks.code.values import NUMBER, Known, Shape, adapter_of
from nrp_core.checks.network_summary import NetworkSummary
from nrp_core.cle.wiring import declare_topics
from nrp_core.dsl.functions import TIME, TransferFunction
from nrp_core.dsl.loading import DECLARES_NOTHING, Listing, PythonSource
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import (
    Adapter,
    Binding,
    PreprocessedTopic,
    PublishedTopic,
)
from nrp_core.dsl.testing import MockBrain
from nrp_core.errors import NrpError, TopicError, UnreadableError
from nrp_core.experiment.making.maker import maker_of
from nrp_core.experiment.making.plan import Plan, PlanParts, Side
from nrp_core.experiment.making.prepare import name_cause
from nrp_core.experiment.making.watch import warn_of_missing_topics
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Key
from nrp_core.experiment.running.observation import bodies_fall
from nrp_core.findings import Code, Finding, Level, has_errors
from nrp_core.findings.error_codes import code_of
from nrp_core.network.data import Network
from nrp_core.scene.model import Model, Scene
from nrp_core.world.backend import WorldBackend
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World

Checkable: TypeAlias = Plan | PlanParts
"""The parts of an experiment, some of which may be missing."""


@dataclass(frozen=True, slots=True)
class CheckedFunction:
    """A transfer function and what is known of the values in its body.

    Args:
        declared: the function as it is written.
        adapters: the adapter of each parameter that could be bound.
        body: its body.
        experiment: the experiment that it belongs to.
        world: the world with the topics.
    """

    declared: Declared
    adapters: dict[str, Adapter]
    body: FunctionBody
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
        is_changed = isinstance(topic, PreprocessedTopic)
        return None if topic is None or is_changed else self.world.topics.get(topic.name)

    def warning(self, code: Code, node: ast.AST | None, message: str) -> Finding:
        """Return a warning about a node of it, or about the function."""
        return self.declared.finding(code, node, message, Level.WARNING)

    def parameter_of(self, shape: Shape) -> str | None:
        """Return the parameter with an adapter, if there is one."""
        found = adapter_of(shape)
        return next((name for name, adapter in self.adapters.items() if adapter is found), None)


def sent_value(function: CheckedFunction, node: ast.AST) -> tuple[TopicInfo, ast.expr] | None:
    """Return the topic and the value of a statement that sends a message; None of any other."""
    match node:
        case ast.Return(ast.expr() as value) if node in function.declared.own:
            return None if function.returns_to is None else (function.returns_to, value)
        case ast.Call(ast.Attribute(owner, "send_message"), [value], []):
            topic = adapter_of(function.body.shape(owner))
            return (topic.info, value) if isinstance(topic, PublishedTopic) else None
    return None


@dataclass
class StaticExperiment:
    """An experiment as it is read; made by :func:`read_experiment`.

    Args:
        experiment: the experiment.
        brain, world: its backends; None, like all parts here, if it could not be made.
        network: the network of its brain, perhaps without synapses and parameters.
        scene: the scene of its world.
        summary: facts about all synapses and parameters of the network.
        stage: a world without an engine, with its topics.
        listings: the files of its transfer functions.
        declared: its transfer functions, in the order of the files.
        functions: the same, bound to mocks, in the order in which they run.
        devices: the devices of these functions.
        neighbours: the modules beside its files that they import.
        is_complete: whether all functions are known: every file and all its declarations could be read.
        findings: what is wrong with the declarations of its functions.
    """

    experiment: Experiment
    brain: Side[BrainBackend] | None
    world: Side[WorldBackend] | None
    network: Network | None
    scene: Scene | None
    summary: NetworkSummary
    stage: World | None = None
    listings: list[Listing] = field(default_factory=list)
    declared: list[Declared] = field(default_factory=list)
    functions: list[CheckedFunction] = field(default_factory=list)
    devices: Sequence[SourcePort | SinkPort] = ()
    neighbours: list[PythonSource] = field(default_factory=list)
    is_complete: bool = True
    findings: list[Finding] = field(default_factory=list)

    @property
    def worst(self) -> Level:
        """The level of the worst findings that are reported."""
        return Level.ERROR if self.experiment.strict else Level.WARNING

    @property
    def topics(self) -> Mapping[str, TopicInfo]:
        """The topics of its world, as far as it could be made."""
        return {} if self.stage is None else self.stage.topics

    @property
    def models(self) -> Sequence[Model]:
        """The models of its scene, as far as it could be made."""
        return () if self.scene is None else self.scene.models

    @property
    def robots(self) -> list[Model]:
        """Those of its models that are robots."""
        return [model for model in self.models if model.name in self.experiment.world.robots]

    @property
    def bodies_fall(self) -> bool:
        """Whether its world is known and has dynamics and gravity."""
        return self.world is not None and bodies_fall(self.world.capabilities)

    def warning(self, code: Code, message: str, *keys: Key) -> Finding:
        """Return a warning about a value of the experiment file, by its keys."""
        return self.experiment.place(*keys).finding(code, message, Level.WARNING)

    def keys_of(self, model: str) -> tuple[Key, ...]:
        """Return the keys of a model: those of a robot, or else those of the room."""
        is_robot = model in self.experiment.world.robots
        return ("world", "robots", model) if is_robot else ("world", "scene")


CHECKS: list[Callable[[StaticExperiment], Iterator[Finding]]] = []
"""All checks, in the order in which they run."""


def checks_experiment(
    check: Callable[[StaticExperiment], Iterator[Finding]],
) -> Callable[[StaticExperiment], Iterator[Finding]]:
    """Register a check of a whole experiment."""
    CHECKS.append(check)
    return check


def checks_function(
    check: Callable[[CheckedFunction], Iterator[Finding]],
) -> Callable[[CheckedFunction], Iterator[Finding]]:
    """Register a check of one transfer function."""
    CHECKS.append(lambda static: (found for one in static.functions for found in check(one)))
    return check


def read_experiment(parts: Checkable, summary: NetworkSummary) -> StaticExperiment:
    """Read the code of an experiment's transfer functions, and bind them to mocks.

    Args:
        parts: its other parts.
        summary: facts about its network.
    """
    scene = None if parts.stage is None else parts.scene  # its topics contradict each other
    static = StaticExperiment(
        parts.experiment, parts.brain, parts.world, parts.network, scene, summary, parts.stage
    )
    collector = Collector(static.experiment.source)
    _read_files(static, collector)
    if static.network is not None and static.stage is not None:
        before = len(collector.findings)
        with collector.during(Code.NRP216, "brain", "backend"):
            is_accepted = isinstance(parts, Plan) or parts.is_accepted
            capabilities = static.brain.capabilities if static.brain and is_accepted else None
            brain = MockBrain(static.network, capabilities=capabilities)
            _bind_functions(static, brain, static.stage, collector)
        collector.findings[before:] = name_cause(
            collector.findings[before:], static.experiment, static.network
        )
    static.findings = collector.findings
    return static


def _read_files(static: StaticExperiment, collector: Collector) -> None:
    """Read the files of transfer functions."""
    experiment = static.experiment
    neighbours: dict[Path, PythonSource] = {}
    for listing in maker_of(experiment).listings(experiment, collector):
        declarations = Declarations(listing)
        static.listings.append(listing)
        neighbours |= {source.path: source for source in declarations.neighbours}
        collector.findings += (at_most(finding, static.worst) for finding in declarations.findings)
        static.declared += declarations.functions
        if not (declarations.functions or declarations.neighbours or experiment.compatibility):
            collector.findings += _declares_nothing(listing)
        static.is_complete &= declarations.is_complete
    # the functions of a file that could not be read are unknown
    static.is_complete &= not has_errors(collector.findings)
    static.neighbours = list(neighbours.values())


def _bind_functions(static: StaticExperiment, brain: MockBrain, stage: World, collector: Collector) -> None:
    functions = [declared.function for declared in static.declared]
    warn_of_missing_topics(collector, static.experiment, stage, functions)
    ordered = sorted(static.declared, key=lambda declared: -declared.function.priority)
    declare_topics([declared.function for declared in ordered], stage)
    variables: dict[str, Any] = {}
    for declared in ordered:
        binding = Binding(declared.function.name, brain, stage, variables)
        adapters = _adapters(static, declared, binding, collector)
        body = FunctionBody(declared, _parameters(declared, adapters))
        static.functions.append(CheckedFunction(declared, adapters, body, static.experiment, stage))
    static.devices = brain.devices


def _adapters(
    static: StaticExperiment, declared: Declared, binding: Binding, collector: Collector
) -> dict[str, Adapter]:
    """Return the adapters of a function's parameters; one that cannot be bound is a finding."""
    function = declared.function
    try:
        bound = function.bind(binding.brain, binding.world, variables=binding.variables).adapters
        return {name: bound[name] for name in function.mappings}
    except (NrpError, ValueError, TypeError) as error:
        whole = error
    adapters: dict[str, Adapter] = {}
    refusals = []
    for name, mapping in function.mappings.items():
        try:
            adapters[name] = mapping.bind(binding)
        except (NrpError, ValueError, TypeError) as error:
            refusals.append(_refusal(static, declared, name, error))
    if not refusals and all(name in function.mappings for name in function.parameters):
        refusals.append(_refusal(static, declared, "", whole))
    collector.findings += refusals
    return adapters


def _refusal(static: StaticExperiment, declared: Declared, name: str, error: Exception) -> Finding:
    """Return the finding that a parameter, or without a name the function, cannot be bound."""
    node = declared.nodes.get(name, declared.node)
    if isinstance(error, UnreadableError):
        message = f"the mapping of '{name or declared.function.name}' is known only when it runs"
        return declared.finding(Code.NRP239, node, message, Level.NOTE)
    # a file that could not be read may publish a topic
    level = Level.WARNING if isinstance(error, TopicError) and not static.is_complete else static.worst
    is_device = isinstance(declared.function.mappings.get(name), (MapSpikeSink, MapSpikeSource))
    code = code_of(error, Code.NRP240 if is_device else Code.NRP210)
    message, instead = getattr(error, "message", str(error)), getattr(error, "instead", None)
    return declared.finding(code, node, message, level, instead)


_DECORATOR = re.compile(
    r"Neuron2Robot|Robot2Neuron|NeuronMonitor|map_afferents|map_motoneurons|import \*|exec|__import__|"
    r"import_module"
)
"""Code with which a file may declare functions."""


def _declares_nothing(listing: Listing) -> Iterator[Finding]:
    """Yield a finding if a Python file names no decorator, so that it cannot declare functions."""
    paths = [source.path for source in listing.sources]
    names = {name for source in listing.sources for name in _DECORATOR.findall(ast.unparse(source.tree))}
    if len(paths) == 1 and paths[0].suffix == ".py" and not names:
        yield Finding(Code.NRP210, DECLARES_NOTHING, path=paths[0], line=1)


def _parameters(declared: Declared, adapters: dict[str, Adapter]) -> dict[str, Shape]:
    """Return the shapes of a function's parameters."""
    shapes: dict[str, Shape] = dict.fromkeys(declared.function.parameters)
    for name, adapter in adapters.items():
        is_changed = isinstance(declared.function.mappings[name].reads, PreprocessedTopic)
        if type(adapter) is not Adapter and not is_changed:
            shapes[name] = Known(adapter)
    return {TIME: NUMBER, **shapes}


def at_most(finding: Finding, level: Level) -> Finding:
    """Return a finding with its level lowered to a limit."""
    is_worse = finding.level is Level.ERROR and level is not Level.ERROR
    return replace(finding, level=level) if is_worse else finding
