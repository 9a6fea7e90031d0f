"""An experiment as checks see it: its parts, and its transfer functions bound to mocks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.checks.network_summary import NetworkSummary
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.parameters import Adapter
from nrp_core.dsl.testing import MockBrain
from nrp_core.experiment.making.plan import Plan, PlanParts, Side
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.section import Key
from nrp_core.experiment.running.observation import bodies_fall
from nrp_core.findings import Code, Finding, Level
from nrp_core.network.data import Network
from nrp_core.scene.model import Model, Scene
from nrp_core.world.backend import WorldBackend
from nrp_core.world.topics import TopicInfo
from nrp_core.world.world import World

Checkable: TypeAlias = Plan | PlanParts
"""The parts of an experiment, some of which may be missing."""


@dataclass(frozen=True, slots=True)
class ExaminedFunction:
    """A transfer function of an experiment.

    Args:
        function: the function.
        adapters: the adapter of each parameter; empty without a brain or world to bind it to.
        experiment: the experiment.
    """

    function: TransferFunction
    adapters: Mapping[str, Adapter]
    experiment: Experiment

    @property
    def written(self) -> list[tuple[str, str]]:
        """The topics that it publishes on, each with its parameter; None for the return value."""
        mappings = self.function.mappings.items()
        written = [(mapping.writes.name, name) for name, mapping in mappings if mapping.writes is not None]
        return written if self.function.topic is None else [(self.function.topic.name, ""), *written]

    def finding(
        self, code: Code, message: str, level: Level = Level.WARNING, *, parameter: str = "", line: int = 0
    ) -> Finding:
        """Return a finding about the function.

        Args:
            code: its kind.
            message: the mistake.
            level: how bad it is.
            parameter: the parameter whose mapping the finding concerns; empty: none.
            line: the line, if it is not the function's first.
        """
        mapping = self.function.mappings.get(parameter)
        place = self.function.place if mapping is None else mapping.place
        return Finding(code, message, level, Path(place.path), line or place.line)


@dataclass(frozen=True, slots=True)
class FunctionTopics:
    """The topics of the transfer functions of an experiment.

    Args:
        read: the topics that they read.
        published: the topics that they publish on.
        is_complete: whether these are the topics of all functions.
    """

    read: frozenset[str] = frozenset()
    published: frozenset[str] = frozenset()
    is_complete: bool = False

    @classmethod
    def of(cls, functions: Iterable[TransferFunction], *, is_complete: bool = True) -> FunctionTopics:
        """Return the topics of functions."""
        given = list(functions)
        read = frozenset(topic.name for one in given for topic in one.subscribed)
        published = frozenset(topic.name for one in given for topic in one.published)
        return cls(read, published, is_complete)


@dataclass
class ExaminedExperiment:
    """An experiment and its parts.

    Args:
        experiment: the experiment.
        brain, world: its backends; None, like all parts here, if it could not be made.
        network: the network of its brain, perhaps without synapses and parameters.
        scene: the scene of its world.
        summary: facts about all synapses and parameters of the network.
        stage: a world without an engine, with its topics.
        function_topics: the topics of its transfer functions.
        functions: these functions, in the order in which they run; only for checks of functions.
        devices: the devices of these functions.
    """

    experiment: Experiment
    brain: Side[BrainBackend] | None
    world: Side[WorldBackend] | None
    network: Network | None
    scene: Scene | None
    summary: NetworkSummary
    stage: World | None
    function_topics: FunctionTopics
    functions: list[ExaminedFunction] = field(default_factory=list)
    devices: Sequence[SourcePort | SinkPort] = ()

    @classmethod
    def of(
        cls, parts: Checkable, summary: NetworkSummary, function_topics: FunctionTopics
    ) -> ExaminedExperiment:
        """Return an experiment without its functions."""
        scene = None if parts.stage is None else parts.scene  # its topics contradict each other
        return cls(
            parts.experiment, parts.brain, parts.world, parts.network, scene, summary, parts.stage,
            function_topics,
        )  # fmt: skip

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


Check: TypeAlias = Callable[[ExaminedExperiment], Iterator[Finding]]

EXPERIMENT_CHECKS: list[Check] = []
"""All checks that need no functions, in the order in which they run."""
FUNCTION_CHECKS: list[Check] = []
"""All checks of functions, which can only be made where functions are loaded."""


def checks_experiment(check: Check) -> Check:
    """Register a check of an experiment without its functions."""
    EXPERIMENT_CHECKS.append(check)
    return check


def checks_functions(check: Check) -> Check:
    """Register a check of an experiment with its functions."""
    FUNCTION_CHECKS.append(check)
    return check


def checks_function(
    check: Callable[[ExaminedFunction], Iterator[Finding]],
) -> Callable[[ExaminedFunction], Iterator[Finding]]:
    """Register a check of one transfer function."""
    FUNCTION_CHECKS.append(lambda examined: (found for one in examined.functions for found in check(one)))
    return check


@contextmanager
def with_functions(
    examined: ExaminedExperiment, brain: MockBrain | None, functions: Iterable[TransferFunction]
) -> Iterator[None]:
    """Bind the functions of an experiment to mocks until the end of the block.

    Args:
        examined: receives them.
        brain: the brain that they are bound to; None: they are not bound.
        functions: the functions, which can be bound.
    """
    ordered = sorted(functions, key=lambda function: -function.priority)
    variables: dict[str, object] = {}
    try:
        for function in ordered:
            if brain is not None and examined.stage is not None:
                function.bind(brain, examined.stage, variables=variables)
            adapters = dict(function.adapters)
            examined.functions.append(ExaminedFunction(function, adapters, examined.experiment))
        examined.devices = () if brain is None else brain.devices
        yield
    finally:
        for function in ordered:
            function.unbind()


def mock_brain(parts: Checkable) -> MockBrain | None:
    """Return a brain without a simulator; None if functions cannot be bound to it and a world."""
    if parts.network is None or parts.stage is None:
        return None
    is_accepted = isinstance(parts, Plan) or parts.is_accepted
    capabilities = parts.brain.capabilities if parts.brain is not None and is_accepted else None
    return MockBrain(parts.network, capabilities=capabilities)


def at_most(finding: Finding, level: Level) -> Finding:
    """Return a finding with its level lowered to a limit."""
    is_worse = finding.level is Level.ERROR and level is not Level.ERROR
    return replace(finding, level=level) if is_worse else finding
