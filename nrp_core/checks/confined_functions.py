"""Load, check and try transfer functions in a confined child, :mod:`nrp_core.checks.functions_sandbox`.

Where the system cannot confine a process, no function is loaded.
"""

from __future__ import annotations

import json
import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from nrp_core._support.machine import cores
from nrp_core._support.probe import ChildResult, run_module
from nrp_core.brain.backend import BrainBackend
from nrp_core.checks.dry_engine import DryEngine
from nrp_core.checks.examined import (
    FUNCTION_CHECKS,
    Checkable,
    ExaminedExperiment,
    FunctionTopics,
    at_most,
    mock_brain,
    with_functions,
)
from nrp_core.checks.network_summary import NetworkSummary, with_stand_ins
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.testing import MockEngine, MockWorld
from nrp_core.errors import ExperimentError
from nrp_core.experiment.making.maker import Parameters, load_function_file
from nrp_core.experiment.making.plan import B, PlanParts, Side
from nrp_core.experiment.making.prepare import load_functions
from nrp_core.experiment.making.watch import declare_own
from nrp_core.experiment.model.collector import Collector
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.running.observers import Participant
from nrp_core.findings import Code, Finding, Level, has_errors
from nrp_core.findings.error_codes import code_of
from nrp_core.network.data import Network
from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldBackend
from nrp_core.world.topics import TopicInfo

TIME_LIMIT_S = 20.0
"""Time that loading and trying all functions may take, without that in which others had the processors, s."""
CHILD = "nrp_core.checks.functions_sandbox"


_NOT_CHECKED = "the transfer functions are not checked"

Answer: TypeAlias = tuple[list[Finding], FunctionTopics]
"""Findings, and the topics of the functions."""


class _NoAnswerError(Exception):
    """Functions were not executed; the message gives the reason."""


@dataclass(frozen=True, slots=True)
class Question:
    """The data that a child needs of an experiment; :class:`PlanParts` without the rest.

    Args:
        experiment: the experiment.
        brain, world: the capabilities of the backends.
        network, scene, parameters, is_accepted: as in :class:`PlanParts`.
        summary: facts about the network.
        topics: the topics of the world itself; None without a world.
        image_scale: factor of the width and height of images.
    """

    experiment: Experiment
    brain: Side[BrainBackend] | None
    world: Side[WorldBackend] | None
    network: Network | None
    scene: Scene | None
    parameters: Parameters
    is_accepted: bool
    summary: NetworkSummary
    topics: Sequence[TopicInfo] | None
    image_scale: float

    @classmethod
    def of(cls, parts: PlanParts, summary: NetworkSummary) -> Question:
        """Return the question about the parts of an experiment."""
        engine = None if parts.stage is None else parts.stage.engine
        return cls(
            parts.experiment,
            _capabilities(parts.brain),
            _capabilities(parts.world),
            None if parts.network is None else with_stand_ins(parts.network, summary.sizes),
            parts.scene,
            parts.parameters,
            parts.is_accepted,
            summary,
            engine.own_topics if isinstance(engine, MockEngine) else None,
            getattr(parts.world and parts.world.options, "image_scale", 1.0),
        )

    def answer(self) -> Answer:
        """Load the functions, check them, and try them; called in the child."""
        from nrp_core.checks.dry_run import dry_run

        parts = self._parts()
        functions = load_functions(parts)
        topics = FunctionTopics.of(functions, is_complete=not has_errors(parts.collector.findings))
        found = check_functions(parts, self.summary, topics, functions)
        brain = mock_brain(parts)
        if brain is not None and isinstance(parts.stage, MockWorld):
            found += dry_run(self.experiment, brain, parts.stage, functions)
        worst = Level.ERROR if self.experiment.strict else Level.WARNING
        return [*parts.collector.findings, *(at_most(finding, worst) for finding in found)], topics

    def not_checked(self, why: str) -> Finding:
        """Return the finding that the functions were not executed."""
        place = self.experiment.place("transfer_functions")
        return place.finding(Code.NRP239, f"{_NOT_CHECKED}: {why}", Level.WARNING)

    def _parts(self) -> PlanParts:
        """Return the parts of the experiment, with a world whose sensors measure something."""
        collector, stage = Collector(self.experiment.source), None
        if self.topics is not None and self.scene is not None and self.world is not None:
            step_ns, scale = self.world.capabilities.step_ns, self.image_scale
            engine = DryEngine(self.scene, step_ns=step_ns, topics=self.topics, image_scale=scale)
            stage = MockWorld(engine=engine)
            declare_own(self.experiment, stage, collector)
        return PlanParts(
            self.experiment, self.brain, self.world, self.network, self.scene, stage, self.parameters,
            self.is_accepted, collector,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class FileQuestion:
    """The data that a child needs to check only a file of transfer functions."""

    path: Path

    def answer(self) -> Answer:
        """Return the mistakes in the file's declarations; called in the child."""
        try:
            functions = load_function_file(self.path)
            for function in functions:
                function.require_mappings()
            return [], FunctionTopics.of(functions)
        except ExperimentError as error:
            return [Finding.of(error, code_of(error, Code.NRP210))], FunctionTopics()

    def not_checked(self, why: str) -> Finding:
        """Return the finding that the file was not executed."""
        return Finding(Code.NRP239, f"{_NOT_CHECKED}: {why}", Level.WARNING, self.path)


def _capabilities(side: Side[B] | None) -> Side[B] | None:
    """Return a side without its backend, whose module would have to be imported in the child."""
    nothing: Any = None
    return None if side is None else Side(nothing, None, side.capabilities)


def check_functions(
    parts: Checkable,
    summary: NetworkSummary,
    topics: FunctionTopics,
    functions: Sequence[TransferFunction],
) -> list[Finding]:
    """Return probable mistakes in functions, without running them.

    Args:
        parts: the other parts of their experiment.
        summary: facts about its network.
        topics: their topics.
        functions: the functions, which can be bound.
    """
    import nrp_core.checks.subjects.functions  # noqa: F401  registers the checks

    examined = ExaminedExperiment.of(parts, summary, topics)
    with with_functions(examined, mock_brain(parts), functions):
        return [at_most(finding, examined.worst) for check in FUNCTION_CHECKS for finding in check(examined)]


def check_confined(parts: PlanParts, summary: NetworkSummary) -> Answer:
    """Load, check and try the functions of an experiment in a child.

    Args:
        parts: the parts of the experiment.
        summary: facts about its network.

    Returns:
        The findings, and the topics of the functions.
    """
    question, maker = Question.of(parts, summary), parts.experiment.maker
    if not isinstance(maker, Participant):
        return ask(question)
    collector = Collector(parts.experiment.source)
    list(maker.listings(parts.experiment, collector))  # reports what is not Python
    why = "those of another platform need a whole run"
    return [*collector.findings, question.not_checked(why)], FunctionTopics()


def ask(question: Question | FileQuestion) -> Answer:
    """Return the answer of a child, or a finding with the reason why it did not answer."""
    try:
        asked = pickle.dumps(question)
    except (pickle.PicklingError, AttributeError, TypeError):
        why = "they depend on objects that exist only in this process"
        return [question.not_checked(why)], FunctionTopics()
    with TemporaryDirectory(prefix="nrp-") as folder:
        file = Path(folder, "question")
        file.write_bytes(asked)
        given = str(file), str(TIME_LIMIT_S * cores() + 1)
        answer = run_module(CHILD, *given, timeout_s=TIME_LIMIT_S, is_forked=True, has_folder=True)
    try:
        return _read_answer(answer)
    except _NoAnswerError as why:
        return [question.not_checked(str(why))], FunctionTopics()


def data_of(answer: Answer) -> dict[str, Any]:
    """Return an answer as plain data for JSON."""
    found, topics = answer
    return {
        "findings": [one.to_dict() for one in found],
        "read": sorted(topics.read),
        "published": sorted(topics.published),
        "is_complete": topics.is_complete,
    }


def _read_answer(answer: ChildResult) -> Answer:
    if answer.exit_code is None:
        raise _NoAnswerError(f"they were not ready after {TIME_LIMIT_S:g} s")
    try:
        data = json.loads(answer.output)
        if data["lacking"]:
            lacking = " and ".join(data["lacking"])
            why = f"this system cannot confine a process: {lacking} cannot be used"
            raise _NoAnswerError(f"{why}; --trust executes them with your permissions")
        found = [Finding.from_dict(one) for one in data["findings"]]
        topics = FunctionTopics(
            frozenset(data["read"]), frozenset(data["published"]), bool(data["is_complete"])
        )
    except (ValueError, KeyError, TypeError):
        last = (answer.errors.strip().splitlines() or ["it gave no reason"])[-1][-300:]
        raise _NoAnswerError(f"their process ended with code {answer.exit_code}: {last}") from None
    return found, topics
