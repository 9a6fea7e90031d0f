"""Run the transfer functions of an experiment for a few steps between mocks, without an engine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core._support.time_limit import TimeLimitExceeded
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.checks.dry_engine import DryEngine
from nrp_core.checks.sandbox import is_refused
from nrp_core.cle.loop import ClosedLoop, Failure
from nrp_core.clock import milliseconds, seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.monitors import MonitoringFunction
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.dsl.weights import Weights
from nrp_core.errors import (
    CapabilityError,
    Instead,
    LifecycleError,
    NetworkError,
    SimulationError,
    did_you_mean,
)
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.findings import Code, Finding, Level

STEPS: Final = 5
"""Steps of the loop in a dry run."""
LONGEST_CALL_S: Final = 5.0
"""Wall time that one call of a function may take, s."""
CONFINED: Final = "a check runs functions without network access, and they can only write temporary files"


def dry_run(
    experiment: Experiment, brain: MockBrain, world: MockWorld, functions: Sequence[TransferFunction]
) -> list[Finding]:
    """Run functions for :data:`STEPS` steps; return their exceptions and the parts that were not tried.

    Every sink reads a spike in each step, so that functions that wait for spikes run.

    Args:
        experiment: the experiment.
        brain: a brain with its network.
        world: a world with a :class:`~nrp_core.checks.dry_engine.DryEngine`, and its topics.
        functions: its functions, not yet bound.
    """
    limit_ns = experiment.function_time_limit
    limit_s = LONGEST_CALL_S if limit_ns is None else min(LONGEST_CALL_S, seconds(limit_ns))
    returned: dict[str, Any] = {}
    found: list[Finding] = []
    for function in functions:
        _note_result(function, returned)
    with ClosedLoop(
        brain,
        world,
        functions,
        period_ns=experiment.timestep,
        tf_time=experiment.tf_time,
        on_error="quarantine",
        function_time_limit_s=limit_s,
        concurrent=False,
    ) as loop:
        try:
            for _ in range(STEPS):
                _fire(brain, loop.now_ns + experiment.timestep)
                loop.step()
        except (SimulationError, LifecycleError) as error:
            place = experiment.place("transfer_functions")
            found.append(place.finding(Code.NRP239, f"the dry run ended early: {error}", Level.NOTE))
        unknown = world.engine.unknown if isinstance(world.engine, DryEngine) else set()
        by_name = {function.name: function for function in functions}
        found += (_finding_of(one, by_name[one.function], unknown) for one in loop.failures)
        found += _never_called(loop, functions)
    found += _lost_results(functions, returned)
    return found


def _fire(brain: MockBrain, t_ns: int) -> None:
    """Let the first neuron of each sink spike at a time, ns."""
    firsts = [
        int(port.neurons[0]) for port in brain.devices if isinstance(port, SinkPort) and len(port.neurons)
    ]
    if firsts:
        brain.fire(np.unique(firsts), milliseconds(t_ns))


# -- findings


def _finding_of(failure: Failure, function: TransferFunction, unknown: set[str]) -> Finding:
    """Return the finding about a function that failed."""
    error, said, instead = failure.error, f"'{failure.function}' {failure.reason}", None
    code, level = Code.NRP240, Level.ERROR
    if isinstance(error, TimeLimitExceeded):
        code, level = Code.NRP357, Level.WARNING
    elif isinstance(error, EOFError) and "reading a line" in str(error):
        code, level = Code.NRP357, Level.WARNING
        said = f"'{failure.function}' reads a line with input(): the loop waits until somebody types it"
    elif doubt := _doubt(error, function, unknown):
        code, level, said = Code.NRP239, Level.NOTE, f"{said} ({doubt})"
    else:
        code = Code.NRP246 if isinstance(error, NameError) else code
        hint, instead = _hint(error)
        said = f"{said}{hint}{failure.notes}"
    return Finding(code, said, level, failure.path, failure.line, instead=instead)


def _doubt(error: BaseException, function: TransferFunction, unknown: set[str]) -> str:
    """Return why an error may be the fault of the dry run; empty if it is that of the function."""
    if is_refused(error):
        return CONFINED
    empty = [topic.name for topic in function.subscribed if topic.name in unknown]
    if empty:
        return f"the mock message on '{empty[0]}' is empty, because only its type is known"
    weights = [one for one in function.adapters.values() if isinstance(one, Weights)]
    if isinstance(error, NetworkError | CapabilityError) and any(one.is_stand_in for one in weights):
        return "the synapses of a dry run have no equations"
    return ""


def _hint(error: BaseException) -> tuple[str, Instead | None]:
    """Return the end of the message about a name that does not exist, and its replacement."""
    instead = getattr(error, "instead", None)
    if instead is not None or not isinstance(error, NameError | AttributeError) or not error.name:
        return "", instead
    if "valid: " in str(error):
        return "", None
    hint = did_you_mean(error.name, _names_at(error))
    is_said = not hint.instead or "did you mean" in str(error)
    return "" if is_said else hint, hint.instead


def _names_at(error: NameError | AttributeError) -> set[str]:
    """Return the names that exist where one was not found."""
    if isinstance(error, AttributeError):
        return {name for name in dir(error.obj) if not name.startswith("_")}
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return set() if trace is None else {*trace.tb_frame.f_locals, *trace.tb_frame.f_globals}


def _never_called(loop: ClosedLoop, functions: Sequence[TransferFunction]) -> Iterator[Finding]:
    """Yield a note about each function that was not due."""
    for function in functions:
        if function.active and not loop.account.function_calls[function.name]:
            awaited = ", ".join(map(repr, function.triggers))
            message = f"'{function.name}' did not run in {STEPS} steps, because nothing came for {awaited}"
            yield Finding(Code.NRP239, message, Level.NOTE, Path(function.place.path), function.place.line)


# -- results


def _note_result(function: TransferFunction, returned: dict[str, Any]) -> None:
    """Store the last result of each function that is not None."""
    inner = function.function

    def noting(*arguments: Any) -> Any:
        result = inner(*arguments)
        if result is not None:
            returned[function.name] = result
        return result

    function.function = noting


def _lost_results(functions: Sequence[TransferFunction], returned: dict[str, Any]) -> Iterator[Finding]:
    """Yield the functions whose results go nowhere; messages were probably meant for a topic."""
    for function in functions:
        if (
            function.topic is None
            and function.name in returned
            and not isinstance(function, MonitoringFunction)
        ):
            is_message = hasattr(returned[function.name], "__msgtype__")
            message = f"the return value of '{function.name}' is not used: it has no topic"
            level = Level.WARNING if is_message else Level.NOTE
            yield Finding(Code.NRP237, message, level, Path(function.place.path), function.place.line)
