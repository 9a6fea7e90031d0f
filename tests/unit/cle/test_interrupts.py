"""Ctrl-C ends a run between two steps, with both sides at the same time."""

from __future__ import annotations

import ctypes
import os
import signal
import threading
import time
from collections.abc import Callable

import pytest

import nrp_core.dsl as nrp
from nrp_core._support import signals, time_limit
from nrp_core._support.time_limit import DeferredInterrupt
from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockEngine, MockWorld

PERIOD = 20 * NS_PER_MS


def press_ctrl_c() -> None:
    os.kill(os.getpid(), signal.SIGINT)


class InterruptedEngine(MockEngine):
    """Somebody presses Ctrl-C in the middle of its third step."""

    def _do_advance(self, steps: int) -> None:
        if self.now_ns == 2 * PERIOD:
            press_ctrl_c()


@pytest.mark.parametrize("concurrent", [True, False])
def test_the_step_is_finished_and_the_run_can_go_on(concurrent: bool) -> None:
    told: list[float] = []

    @nrp.Robot2Neuron()
    def f(t: float) -> None:
        told.append(t)

    brain, world = MockBrain({"cells": 1}), MockWorld(engine=InterruptedEngine(step_ns=PERIOD))
    with ClosedLoop(brain, world, [f], period_ns=PERIOD, concurrent=concurrent) as loop:
        with pytest.raises(KeyboardInterrupt):
            loop.run_until(10 * PERIOD)
        assert loop.now_ns == brain.now_ns == 3 * PERIOD
        assert told == [0.02, 0.04, 0.06]
        loop.run_until(10 * PERIOD)
        assert loop.now_ns == 10 * PERIOD


def test_a_second_ctrl_c_is_not_held_back() -> None:
    reached: list[str] = []

    def stuck() -> None:
        with DeferredInterrupt():
            press_ctrl_c()
            reached.append("after the first")
            press_ctrl_c()
            reached.append("after the second")

    with pytest.raises(KeyboardInterrupt):
        stuck()
    assert reached == ["after the first"]


def test_a_request_to_end_is_held_back_for_a_limited_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time_limit, "_LONGEST_DELAY_S", 0.05)
    monkeypatch.setattr(signals, "asked", False)
    previous = signal.signal(signal.SIGTERM, signals.interrupt)
    reached: list[str] = []

    def stuck() -> None:
        with DeferredInterrupt():
            os.kill(os.getpid(), signal.SIGTERM)
            reached.append("after the signal")
            time.sleep(10)
            reached.append("at the end")

    try:
        with pytest.raises(KeyboardInterrupt):
            stuck()
    finally:
        signal.signal(signal.SIGTERM, previous)
    assert reached == ["after the signal"]


def test_the_program_s_own_handler_is_called_and_put_back() -> None:
    called: list[int] = []
    previous = signal.signal(signal.SIGINT, lambda number, frame: called.append(number))
    handler = signal.getsignal(signal.SIGINT)
    try:
        with DeferredInterrupt():
            press_ctrl_c()
            assert called == []
        assert called == [signal.SIGINT]
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, previous)


def test_an_error_within_is_not_replaced_by_the_interrupt() -> None:
    def fail() -> None:
        with DeferredInterrupt():
            press_ctrl_c()
            raise ValueError("first")

    with pytest.raises(ValueError, match="first"):
        fail()


@pytest.mark.parametrize("disposition", [signal.SIG_IGN, signal.SIG_DFL])
def test_a_program_that_ignores_ctrl_c_goes_on_ignoring_it(disposition: signal.Handlers) -> None:
    previous = signal.signal(signal.SIGINT, disposition)
    try:
        with DeferredInterrupt():
            assert signal.getsignal(signal.SIGINT) is disposition
    finally:
        signal.signal(signal.SIGINT, previous)


def test_in_another_thread_nothing_is_changed() -> None:
    handler = signal.getsignal(signal.SIGINT)
    seen: list[object] = []

    def run(look: Callable[[], object]) -> None:
        with DeferredInterrupt():
            seen.append(look())

    thread = threading.Thread(target=run, args=(lambda: signal.getsignal(signal.SIGINT),))
    thread.start()
    thread.join()
    assert seen == [handler]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_interrupt_that_c_code_swallows_ends_the_run_at_its_next_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(signals, "asked", False)
    previous = signal.signal(signal.SIGTERM, signals.interrupt)
    brain, world = MockBrain({"cells": 1}), MockWorld(engine=MockEngine(step_ns=PERIOD))
    try:
        with ClosedLoop(brain, world, [], period_ns=PERIOD, concurrent=False) as loop:
            loop.run_until(2 * PERIOD)
            ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), signal.SIGTERM))()  # as a compiler's callback
            with pytest.raises(KeyboardInterrupt):
                loop.run_until(10 * PERIOD)
            assert loop.now_ns == brain.now_ns == 2 * PERIOD
    finally:
        signal.signal(signal.SIGTERM, previous)
