"""A transfer function that raises is reported with everything needed to mend it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

import nrp_core.dsl as nrp
from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.loading import load_transfer_functions
from nrp_core.dsl.testing import MockBrain, MockEngine, MockWorld
from nrp_core.errors import SimulationError, TransferFunctionRaisedError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.model import Model
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo

PERIOD = 20 * NS_PER_MS

FILE = """
import sys


def ratio(a, b):
    return a / b


@nrp.MapRobotSubscriber("x", Topic("/in", std_msgs.msg.Float64))
@nrp.MapSpikeSink("v", nrp.brain.cells, nrp.leaky_integrator_alpha)
@nrp.MapSpikeSource("eye", nrp.brain.cells, nrp.poisson)
@nrp.Robot2Neuron()
def fragile(t, x, v, eye):
    eye.rate = 10.0
    if t > 0.03:
        eye.rate = {statement}


@nrp.Neuron2Robot(Topic("/out", std_msgs.msg.Float64))
def sturdy(t):
    return std_msgs.msg.Float64(t)
"""


def loop_from(folder: Path, statement: str, **options: Any) -> tuple[ClosedLoop, MockWorld]:
    path = folder / "functions.py"
    path.write_text(FILE.format(statement=statement))
    world = MockWorld({"/in": Float64, "/out": Float64})
    functions = load_transfer_functions(path)
    return ClosedLoop(MockBrain({"cells": 2}), world, functions, period_ns=PERIOD, **options), world


@pytest.mark.parametrize(
    ("statement", "line", "message"),
    [
        ("1 / 0", 16, "ZeroDivisionError: division by zero"),
        ("ratio(1, 0)", 6, "ZeroDivisionError: division by zero"),
        ("-5.0", 16, "ValueError: eye: rate must be finite and at least 0, not -5.0"),
        ("float('nan')", 16, "ValueError: eye: rate must be finite and at least 0, not nan"),
        ("sys.exit()", 16, "SystemExit"),
        ("v.rate", 16, "AttributeError: the device 'v' has no attribute 'rate'; valid: active, voltage"),
    ],
)
def test_the_report_names_file_line_step_time_and_inputs(
    tmp_path: Path, statement: str, line: int, message: str
) -> None:
    loop, world = loop_from(tmp_path, statement)
    world.put("/in", Float64(7.0))
    with pytest.raises(TransferFunctionRaisedError) as caught:
        loop.run_until(10 * PERIOD)
    report = str(caught.value).splitlines()
    assert report[0].startswith(
        f"{tmp_path / 'functions.py'}:{line}: transfer function 'fragile' raised {message}"
    )
    assert report[1:] == [
        "  in step 2, at 0.04 s, with",
        "    x: value = Float64(data=7.0)",
        "    v: voltage = 0",
    ]
    assert caught.value.t_ns == 2 * PERIOD
    assert caught.value.__cause__ is loop.failures[0].error
    assert isinstance(caught.value, RuntimeError)


def test_with_stop_hooks_see_the_complete_step_and_the_other_functions_do_not_run(tmp_path: Path) -> None:
    loop, world = loop_from(tmp_path, "1 / 0")
    recorded: list[int] = []
    loop.hooks.after_step.append(lambda loop: recorded.append(loop.now_ns))
    with pytest.raises(TransferFunctionRaisedError):
        loop.run_until(10 * PERIOD)
    assert recorded == [PERIOD, 2 * PERIOD]
    assert (loop.brain.now_ns, loop.world.now_ns, loop.steps) == (2 * PERIOD, 2 * PERIOD, 2)
    assert world.sent("/out") == [Float64(0.02)]


def test_with_quarantine_the_function_is_set_aside_and_the_rest_runs_on(tmp_path: Path) -> None:
    loop, world = loop_from(tmp_path, "1 / 0", on_error="quarantine")
    loop.run_until(5 * PERIOD)
    (failure,) = loop.failures
    assert (failure.function, failure.step, failure.line) == ("fragile", 2, 16)
    assert len(world.sent("/out")) == 5
    fragile = loop.functions[0]
    assert not fragile.active
    assert not fragile.eye.active


def test_reset_gives_a_function_in_quarantine_another_chance(tmp_path: Path) -> None:
    loop, _ = loop_from(tmp_path, "1 / 0", on_error="quarantine")
    loop.run_until(5 * PERIOD)
    loop.reset()
    assert loop.failures == []
    assert loop.functions[0].eye.active
    loop.run_until(5 * PERIOD)
    assert [failure.step for failure in loop.failures] == [2]


def test_reset_leaves_a_function_inactive_that_was_switched_off(tmp_path: Path) -> None:
    loop, _ = loop_from(tmp_path, "1.0")
    loop.functions[0].active = False
    loop.reset()
    assert not loop.functions[0].active


def test_a_wrong_return_value_is_reported_at_the_function_with_topic_and_type() -> None:
    @nrp.Neuron2Robot(nrp.Topic("/out", Float64))
    def drive(t: float) -> list[float]:
        return [3.0]

    world = MockWorld({"/out": Float64})
    loop = ClosedLoop(MockBrain({}), world, [drive], period_ns=PERIOD)
    with pytest.raises(TransferFunctionRaisedError) as caught:
        loop.step()
    assert str(caught.value).startswith(
        f"{drive.place}: transfer function 'drive' raised TopicError: return value of 'drive': "
        "/out carries std_msgs/msg/Float64, not list ([3.0])"
    )


@pytest.mark.parametrize("on_error", ["stop", "quarantine"])
def test_an_engine_that_fails_under_a_function_is_not_blamed_on_the_function(
    on_error: Any, golden: Golden
) -> None:
    class Broken(Part):
        topics = (TopicInfo("/out", Float64, Direction.IN),)

        def write(self, topic: str, message: Any, now_ns: int) -> None:
            raise SimulationError("the engine broke")

    class BrokenEngine(MockEngine):
        def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
            return [*usual, Broken()]

    @nrp.Neuron2Robot(nrp.Topic("/out", Float64))
    def drive(t: float) -> Float64:
        return Float64(t)

    world = MockWorld(engine=BrokenEngine())
    loop = ClosedLoop(MockBrain({}), world, [drive], period_ns=PERIOD, on_error=on_error)
    with golden.raises(SimulationError) as caught:
        loop.step()
    assert not isinstance(caught.value, TransferFunctionRaisedError)
    assert loop.failures == []
