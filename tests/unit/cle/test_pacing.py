"""Simulated time passes as fast as was asked for."""

from __future__ import annotations

import pytest
from golden import Golden

from nrp_core.cle import AsFastAsPossible, ClosedLoop, Paced, pacing_of
from nrp_core.clock import NS_PER_MS
from nrp_core.dsl.testing import MockBrain, MockWorld
from nrp_core.errors import ExperimentError

PERIOD = 20 * NS_PER_MS


class FakeTime:
    """Wall time that passes only where somebody sleeps or works."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.slept: list[float] = []

    def clock(self) -> float:
        return self.now_s

    def sleep(self, duration_s: float) -> None:
        self.slept.append(round(duration_s, 6))
        self.now_s += duration_s

    def paced(self, factor: float) -> Paced:
        return Paced(factor, clock=self.clock, sleep=self.sleep)


def run(time: FakeTime, pacing: Paced, work_s: list[float]) -> None:
    pacing.start(0)
    for k, work in enumerate(work_s):
        time.now_s += work
        pacing.wait((k + 1) * PERIOD)


def test_the_rest_of_a_step_is_slept() -> None:
    time = FakeTime()
    run(time, time.paced(1.0), [0.005, 0.015, 0.0])
    assert time.slept == [0.015, 0.005, 0.02]


def test_a_factor_shortens_the_wait() -> None:
    time = FakeTime()
    run(time, time.paced(2.0), [0.005, 0.001])
    assert time.slept == [0.005, 0.009]


def test_a_small_delay_is_made_up_for() -> None:
    time = FakeTime()
    run(time, time.paced(1.0), [0.05, 0.001, 0.001, 0.001])
    assert time.now_s == pytest.approx(100.08)


def test_a_large_delay_is_made_up_for_by_a_tenth_of_a_second_only() -> None:
    time = FakeTime()
    run(time, time.paced(1.0), [1.0, *[0.001] * 20])
    assert time.now_s == pytest.approx(100.0 + 1.0 - 0.1 + 20 * 0.02)


def test_time_between_runs_does_not_count() -> None:
    time = FakeTime()
    pacing = time.paced(1.0)
    with ClosedLoop(MockBrain({}), MockWorld(), period_ns=PERIOD, pacing=pacing) as loop:
        loop.step()
        time.now_s += 50.0
        loop.run_until(3 * PERIOD)
    assert time.slept == [0.02, 0.02, 0.02]


def test_the_words_for_a_pace() -> None:
    assert isinstance(pacing_of("max"), AsFastAsPossible)
    for text, factor in (("realtime", 1.0), ("2.5", 2.5), (0.5, 0.5)):
        pacing = pacing_of(text)
        assert isinstance(pacing, Paced)
        assert pacing.factor == factor


@pytest.mark.parametrize("text", ["fast", "0", "-1", "nan", "inf", ""])
def test_an_invalid_pace_is_refused(text: str, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        pacing_of(text)
