"""The clock: integers, divisibility, rational sampling."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.clock import (
    FOREVER_NS,
    NS_PER_S,
    SampleSchedule,
    StepPlan,
    from_milliseconds,
    from_seconds,
    nanoseconds,
    seconds,
    without_rounding_errors,
)
from nrp_core.errors import TimestepError

MS = 1_000_000


@given(st.integers(0, 10**15))
def test_seconds_and_nanoseconds_are_inverse(t_ns: int) -> None:
    assert from_seconds(Fraction(t_ns, NS_PER_S)) == t_ns
    assert seconds(t_ns) * NS_PER_S == pytest.approx(t_ns)


def test_a_float_is_read_by_its_printed_form() -> None:
    assert from_seconds(0.1) == 100 * MS
    assert from_milliseconds(0.3) == 300_000


@given(
    st.floats(-1e8, 1e8)
    | st.integers(-(10**17), 10**17).map(lambda t_ns: t_ns / NS_PER_S)
    | st.integers(2**51, 2**53).map(lambda n: n * 2.0**-32)
)
def test_every_float_is_read_by_its_printed_form(t_s: float) -> None:
    assert from_seconds(t_s) == round(Fraction(repr(t_s)) * NS_PER_S)
    t_ms = t_s * 22.0
    assert from_milliseconds(t_ms) == round(Fraction(repr(t_ms)) * MS)


@given(
    st.floats(-1e12, 1e12)
    | st.integers(-(10**12), 10**12).map(lambda n: n * 0.1)
    | st.integers(-(10**9), 10**9).map(lambda n: (n + 0.5) / MS)
)
def test_times_in_an_array_are_read_as_one_alone(t_ms: float) -> None:
    assert nanoseconds([[t_ms, 0.3]]).tolist() == [[from_milliseconds(t_ms), 300_000]]


def test_a_time_that_is_never_reached_is_a_number_too() -> None:
    assert nanoseconds([float("inf"), 1e300, -float("inf")]).tolist() == [FOREVER_NS, FOREVER_NS, -FOREVER_NS]


@given(st.integers(0, 10**6))
def test_computed_times_become_those_that_are_written(n: int) -> None:
    assert without_rounding_errors([n * 0.1, 0.1 * n]).tolist() == [n / 10, n / 10]


def test_times_between_two_nanoseconds_stay() -> None:
    assert without_rounding_errors(1.00000025).tolist() == 1.00000025
    assert without_rounding_errors([float("inf")]).tolist() == [float("inf")]


@pytest.mark.parametrize(("brain", "world"), [(None, None), (MS, 2 * MS), (20 * MS, None), (None, 20 * MS)])
def test_steps_that_divide_the_period_are_accepted(brain: int | None, world: int | None) -> None:
    assert StepPlan(20 * MS, brain, world).period_ns == 20 * MS


@pytest.mark.parametrize(
    ("period", "brain", "world"), [(20, 3, 2), (20, 2, 3), (0, 1, 1), (20, 0, 2), (20, -1, 2)]
)
def test_steps_that_do_not_divide_are_refused_with_all_three_numbers(
    period: int, brain: int, world: int
) -> None:
    with pytest.raises(TimestepError) as refusal:
        StepPlan(period * MS, brain * MS, world * MS)
    for number in (period, brain, world):
        assert f"{number} ms" in str(refusal.value)


rates = st.floats(0.5, 1000, allow_nan=False)
steps = st.integers(1, 50).map(lambda n: n * 100_000)


@given(rates, steps, st.integers(0, 10_000))
def test_sample_k_is_taken_at_the_first_step_at_or_after_its_time(rate: float, step_ns: int, k: int) -> None:
    schedule = SampleSchedule.of(rate, step_ns)
    due = Fraction(k) / schedule.rate_hz * NS_PER_S
    at_ns = schedule.sample_ns(k)
    assert at_ns % step_ns == 0
    assert due <= at_ns < due + step_ns


@given(rates, steps, st.integers(0, 10**11))
def test_the_next_sample_is_the_earliest_one_in_the_future(rate: float, step_ns: int, t_ns: int) -> None:
    schedule = SampleSchedule.of(rate, step_ns)
    at_ns = schedule.next_after(t_ns)
    k = round(Fraction(at_ns, NS_PER_S) * schedule.rate_hz)
    samples = {schedule.sample_ns(i) for i in range(max(0, k - 3), k + 4)}
    assert at_ns > t_ns
    assert at_ns in samples
    assert not any(t_ns < other < at_ns for other in samples)


@given(rates, steps, st.integers(0, 10_000))
def test_sample_k_is_the_last_one_due_from_its_own_time_on(rate: float, step_ns: int, k: int) -> None:
    schedule = SampleSchedule.of(rate, step_ns)
    due_ns = -(-k * NS_PER_S // schedule.rate_hz)
    assert schedule.index_at(int(due_ns)) == k
    assert schedule.index_at(int(due_ns) - 1) < k


def test_a_30_hz_camera_on_2_ms_steps_gives_30_images_in_every_second() -> None:
    schedule = SampleSchedule.of(30, 2 * MS)
    times = [schedule.sample_ns(k) for k in range(300)]
    assert times[:4] == [0, 34 * MS, 68 * MS, 100 * MS]
    for second in range(10):
        assert sum(second * NS_PER_S <= t < (second + 1) * NS_PER_S for t in times) == 30
