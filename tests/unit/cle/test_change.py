"""Functions come, go and take each other's place while the loop runs, all or nothing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st

import nrp_core.dsl as nrp
from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import ExperimentError, NeuronSelectionError, TransferFunctionError
from nrp_core.messages.std_msgs import Float64

PERIOD = 20 * NS_PER_MS


def loop_of(*functions: nrp.TransferFunction, **options: Any) -> ClosedLoop:
    brain, world = MockBrain({"cells": 4}), MockWorld({"/in": Float64, "/out": Float64})
    return ClosedLoop(brain, world, functions, period_ns=PERIOD, **options)


def counting(by: int, name: str = "count", **variable: Any) -> nrp.TransferFunction:
    """Return a function that adds to a variable each step and says what it is."""

    def count(t: float, total: Any) -> Float64:
        total.value += by
        return Float64(total.value)

    count.__name__ = name
    return nrp.MapVariable("total", initial_value=0, **variable)(nrp.Neuron2Robot("/out")(count))


def said(loop: ClosedLoop) -> list[float]:
    assert isinstance(loop.world, MockWorld)
    return [message.data for message in loop.world.sent("/out")]


def test_a_function_takes_the_place_of_the_one_of_its_name_and_keeps_its_variables() -> None:
    loop = loop_of(counting(1))
    loop.run_until(3 * PERIOD)
    loop.change([counting(10)])
    loop.run_until(5 * PERIOD)
    assert said(loop) == [1, 2, 3, 13, 23]


def test_a_shared_variable_outlives_every_function_that_has_it() -> None:
    loop = loop_of(counting(1, scope=nrp.GLOBAL))
    loop.run_until(2 * PERIOD)
    loop.change(remove=["count"])
    loop.run_until(4 * PERIOD)
    loop.change([counting(5, "again", scope=nrp.GLOBAL)])
    loop.run_until(5 * PERIOD)
    assert said(loop) == [1, 2, 7]


def integrating(name: str = "listen") -> tuple[nrp.TransferFunction, list[float]]:
    seen: list[float] = []

    def listen(t: float, cell: Any) -> None:
        seen.append(cell.voltage)

    listen.__name__ = name
    return nrp.MapSpikeSink("cell", nrp.brain.cells[0], nrp.leaky_integrator_exp)(
        nrp.Robot2Neuron()(listen)
    ), seen


def test_a_device_on_the_same_neurons_keeps_the_spikes_that_it_received() -> None:
    never, (straight, (once, again)) = integrating(), (integrating(), (integrating(), integrating()))
    for function, successor in ((straight, None), (once, again)):
        loop = loop_of(function[0])
        assert isinstance(loop.brain, MockBrain)
        loop.brain.fire([0], [5.0])
        loop.step()
        if successor is not None:
            loop.change([successor[0]])
        loop.run_until(3 * PERIOD)
    assert straight[1] == once[1] + again[1]
    assert straight[1][-1] > 0
    assert not never[1]


def test_a_replaced_function_leaves_no_device_behind() -> None:
    loop = loop_of(integrating()[0])
    loop.change([integrating()[0]])
    assert len(loop.brain.devices) == 1
    loop.change(remove=["listen"])
    assert loop.brain.devices == ()


def wrong() -> nrp.TransferFunction:
    @nrp.MapSpikeSink("cell", nrp.brain.cells[9], nrp.leaky_integrator_exp)
    @nrp.Robot2Neuron()
    def count(t: float, cell: Any) -> None: ...

    return count


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (lambda loop: loop.change([counting(3, "other"), wrong()]), NeuronSelectionError),
        (lambda loop: loop.change([counting(3)], ["cuont"]), ExperimentError),
        (lambda loop: loop.change([counting(3), counting(4)]), TransferFunctionError),
    ],
    ids=["a neuron that does not exist", "nothing to remove", "one name twice"],
)
def test_a_change_that_cannot_be_changes_nothing(
    change: Callable[[ClosedLoop], None], error: type[Exception]
) -> None:
    loop = loop_of(counting(1))
    loop.step()
    functions, devices = loop.functions, loop.brain.devices
    with pytest.raises(error):
        change(loop)
    assert (loop.functions, loop.brain.devices) == (functions, devices)
    loop.step()
    assert said(loop) == [1, 2]


def test_an_unknown_function_to_remove_gets_the_nearest_name_as_a_suggestion(golden: Golden) -> None:
    with golden.raises(ExperimentError, match="'cuont'.*'count'"):
        loop_of(counting(1)).change(remove=["cuont"])


def test_a_function_in_quarantine_runs_again_once_it_is_replaced() -> None:
    @nrp.MapVariable("total", initial_value=0)
    @nrp.Neuron2Robot("/out")
    def count(t: float, total: Any) -> None:
        raise ZeroDivisionError

    loop = loop_of(count, on_error="quarantine")
    loop.run_until(2 * PERIOD)
    loop.change([counting(1)])
    loop.run_until(4 * PERIOD)
    assert said(loop) == [1, 2]
    assert len(loop.failures) == 1


def test_one_that_was_switched_off_stays_off_when_it_is_replaced(golden: Golden) -> None:
    loop = loop_of(counting(1))
    loop.activate("count", False)
    with golden.raises(ExperimentError, match="'no'"):
        loop.activate("count", "no")  # type: ignore[arg-type]
    loop.change([counting(2)])
    loop.run_until(2 * PERIOD)
    assert said(loop) == []
    loop.activate("count")
    loop.run_until(3 * PERIOD)
    assert said(loop) == [2]


def test_another_thread_changes_functions_between_two_steps() -> None:
    loop = loop_of(counting(1))
    began, changed = threading.Event(), threading.Event()

    def look(at: ClosedLoop) -> None:
        began.set()
        if changed.is_set() and said(at)[-1] - said(at)[-2] == 100:
            at.stop()

    def change() -> None:
        began.wait(60)
        loop.change([counting(100)])
        changed.set()

    loop.hooks.after_step.append(look)
    other = threading.Thread(target=change)
    other.start()
    loop.run_until(100_000 * PERIOD)
    other.join(60)
    steps = [b - a for a, b in zip([0.0, *said(loop)], said(loop), strict=False)]
    assert sorted(steps) == steps
    assert set(steps) == {1, 100}


def test_a_wrong_request_of_another_thread_is_raised_there_and_the_run_continues() -> None:
    loop = loop_of(counting(1))
    raised: list[Exception] = []
    began = threading.Event()

    def ask() -> None:
        began.wait(60)
        try:
            loop.change(remove=["nothing"])
        except ExperimentError as error:
            raised.append(error)

    loop.hooks.after_step.append(lambda _: began.set())
    other = threading.Thread(target=ask)
    other.start()
    loop.run_until(50 * PERIOD)
    other.join(60)
    assert len(raised) == 1
    assert len(said(loop)) == 50


def test_a_function_that_removes_another_in_the_same_step_keeps_it_from_running() -> None:
    @nrp.Neuron2Robot()
    def remover(t: float) -> None:
        if len(loop.functions) > 1:
            loop.change(remove=["count"])

    loop = loop_of(remover, counting(1))
    loop.run_until(2 * PERIOD)
    assert said(loop) == []


NAMES = st.sampled_from("abc")


@settings(deadline=None, max_examples=40)
@given(
    st.lists(
        st.tuples(st.lists(NAMES, unique=True), st.lists(NAMES, unique=True), st.integers(0, 2)), max_size=6
    )
)
def test_any_sequence_of_changes_leaves_those_bound_that_were_asked_for(
    changes: list[tuple[list[str], list[str], int]],
) -> None:
    loop = loop_of()
    expected: dict[str, float] = {}
    for add, remove, steps in changes:
        gone = [name for name in remove if name in expected]
        loop.change([counting(1, name) for name in add], gone)
        expected = {name: n for name, n in expected.items() if name not in gone or name in add}
        expected |= {name: expected.get(name, 0) for name in add}
        loop.run_until(loop.now_ns + steps * PERIOD)
        expected = {name: n + steps for name, n in expected.items()}
        assert {f.name: f.total.value for f in loop.functions} == expected
        assert all(function.is_bound for function in loop.functions)


def test_a_stop_between_two_steps_ends_the_run_before_the_next() -> None:
    loop = loop_of(counting(1))
    begun = threading.Event()
    loop.hooks.after_step.append(lambda _loop: begun.set() or requested.wait(60))
    requested = threading.Event()
    times: list[int] = []

    def stop() -> None:
        loop.stop()
        times.append(loop.now_ns)

    def ask() -> None:
        begun.wait(60)
        loop.between_steps(stop)

    waiting = len(loop._requests._waiting)
    other = threading.Thread(target=ask)
    other.start()
    watcher = threading.Thread(
        target=lambda: _until(lambda: len(loop._requests._waiting) > waiting, requested)
    )
    watcher.start()
    loop.run_until(100 * PERIOD)
    other.join()
    watcher.join()
    assert times == [loop.now_ns] == [PERIOD]


def _until(condition: Callable[[], bool], event: threading.Event) -> None:
    while not condition():
        time.sleep(0.001)
    event.set()


def test_a_thread_that_attends_makes_the_calls_of_others_between_runs_and_in_them() -> None:
    loop = loop_of(counting(1))
    makers: list[int] = []

    def ask() -> None:
        for _ in range(3):
            loop.between_steps(lambda: makers.append(threading.get_ident()))

    with loop.serving_calls():
        other = threading.Thread(target=ask)
        other.start()
        while len(makers) < 2:
            loop.attend(10.0)
        loop.run_until(PERIOD)
        while len(makers) < 3:
            loop.attend(10.0)
        other.join()
    assert makers == [threading.get_ident()] * 3
    loop.between_steps(lambda: makers.append(0))  # nobody attends: the caller makes it
    assert makers[3:] == [0]


def test_attending_returns_without_a_call_in_time() -> None:
    loop = loop_of()
    began = time.monotonic()
    with loop.serving_calls():
        loop.attend(0.01)
    assert time.monotonic() - began >= 0.01
