"""Brain and world advance at once where that is wanted, and fail without leaving the other behind."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest
from golden import Golden

from nrp_core.cle import ClosedLoop
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockEngine, MockWorld
from nrp_core.errors import SimulationError

PERIOD = 20 * NS_PER_MS
BY_TURNS = [("brain", True)] * 2 + [("world", True)] * 2
AT_ONCE = [("brain", False)] * 2 + [("world", True)] * 2


def nothing() -> None: ...


class ActingBrain(MockBrain):
    def __init__(self, act: Callable[[], None], *, releases_gil: bool = True) -> None:
        super().__init__({"cells": 1}, releases_gil=releases_gil)
        self._act = act

    def _do_run_until(self, t_ns: int) -> None:
        self._act()


class ActingEngine(MockEngine):
    def __init__(self, act: Callable[[], None]) -> None:
        super().__init__(step_ns=PERIOD)
        self._act = act

    def _do_advance(self, steps: int) -> None:
        self._act()


def acting_world(act: Callable[[], None]) -> MockWorld:
    return MockWorld(engine=ActingEngine(act))


def threads_used(concurrent: bool | None, *, releases_gil: bool = True) -> list[tuple[str, bool]]:
    used: list[tuple[str, bool]] = []

    def note(side: str) -> Callable[[], None]:
        return lambda: used.append((side, threading.current_thread() is threading.main_thread()))

    brain, world = ActingBrain(note("brain"), releases_gil=releases_gil), acting_world(note("world"))
    with ClosedLoop(brain, world, period_ns=PERIOD, concurrent=concurrent) as loop:
        loop.run_until(2 * PERIOD)
    return sorted(used)


def test_both_sides_are_at_work_at_the_same_time() -> None:
    """Each waits in its step until the other one is in its own."""
    barrier = threading.Barrier(2)

    def meet() -> None:
        barrier.wait(timeout=60)

    with ClosedLoop(ActingBrain(meet), acting_world(meet), period_ns=PERIOD, concurrent=True) as loop:
        loop.run_until(3 * PERIOD)
        assert loop.now_ns == loop.brain.now_ns == 3 * PERIOD


def test_the_world_stays_on_the_calling_thread() -> None:
    assert threads_used(True) == AT_ONCE
    assert threads_used(False) == BY_TURNS


@pytest.mark.parametrize(
    ("worth_ns", "cores", "releases_gil", "expected"),
    [(0, 2, True, AT_ONCE), (10**18, 2, True, BY_TURNS), (0, 1, True, BY_TURNS), (0, 2, False, BY_TURNS)],
)
def test_by_default_a_thread_is_used_where_it_pays(
    monkeypatch: pytest.MonkeyPatch,
    worth_ns: int,
    cores: int,
    releases_gil: bool,
    expected: list[tuple[str, bool]],
) -> None:
    monkeypatch.setattr("nrp_core.cle.loop.WORTH_A_THREAD_NS", worth_ns)
    monkeypatch.setattr("nrp_core.cle.loop.cores", lambda: cores)
    assert threads_used(None, releases_gil=releases_gil) == expected


def fail(message: str) -> Callable[[], None]:
    def act() -> None:
        raise RuntimeError(message)

    return act


@pytest.mark.parametrize("concurrent", [True, False])
def test_an_exception_of_the_brain_reaches_the_caller(concurrent: bool, golden: Golden) -> None:
    brain, world = ActingBrain(fail("no more spikes")), acting_world(nothing)
    loop = ClosedLoop(brain, world, period_ns=PERIOD, concurrent=concurrent)
    with golden.raises(SimulationError):
        loop.step()
    loop.close()


@pytest.mark.parametrize("concurrent", [True, False])
def test_an_exception_of_the_world_reaches_the_caller_after_the_brain_has_finished(concurrent: bool) -> None:
    brain, world = ActingBrain(nothing), acting_world(fail("it fell"))
    loop = ClosedLoop(brain, world, period_ns=PERIOD, concurrent=concurrent)
    with pytest.raises(SimulationError, match="it fell"):
        loop.step()
    assert loop.brain.now_ns == PERIOD
    loop.close()


def test_when_both_fail_both_are_reported() -> None:
    loop = ClosedLoop(
        ActingBrain(fail("no more spikes")), acting_world(fail("it fell")), period_ns=PERIOD, concurrent=True
    )
    with pytest.raises(SimulationError, match="it fell") as caught:
        loop.step()
    assert "no more spikes" in caught.value.__notes__[0]
    loop.close()


def test_a_failed_run_can_be_reset() -> None:
    remaining = ["it fell"]

    def act() -> None:
        if remaining:
            raise RuntimeError(remaining.pop())

    with ClosedLoop(ActingBrain(nothing), acting_world(act), period_ns=PERIOD) as loop:
        with pytest.raises(SimulationError, match="it fell"):
            loop.step()
        loop.reset()
        loop.run_until(2 * PERIOD)
        assert loop.now_ns == loop.brain.now_ns == 2 * PERIOD


def test_the_shares_of_the_work_add_up() -> None:
    with ClosedLoop(ActingBrain(nothing), acting_world(nothing), period_ns=PERIOD) as loop:
        assert set(loop.account.shares().values()) == {0.0}
        loop.run_until(5 * PERIOD)
        shares = loop.account.shares()
        assert sum(shares.values()) == pytest.approx(1.0)
        assert min(shares.values()) >= 0.0
        assert set(shares) == {"brain", "world", "transfer_functions", "engine"}
