"""Numbers with units."""

from math import pi

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from nrp_core.quantities import (
    AngleRad,
    DurationNs,
    LengthM,
    RateHz,
    RoundedNs,
    TimeNs,
    length_text,
    period_ns,
)


class Everything(BaseModel):
    duration: DurationNs = 1
    time: TimeNs = 0
    rate: RateHz = 1.0
    length: LengthM = 1.0
    angle: AngleRad = 0.0


@pytest.mark.parametrize(
    ("field", "text", "value"),
    [
        ("duration", "20 ms", 20_000_000),
        ("duration", "20ms", 20_000_000),
        ("duration", "0.1 ms", 100_000),
        ("duration", "1 µs", 1_000),
        ("duration", "2 min", 120_000_000_000),
        ("time", 0, 0),
        ("time", "1e-3 s", 1_000_000),
        ("rate", "1 kHz", 1000.0),
        ("rate", 30, 30.0),
        ("length", "12 cm", 0.12),
        ("length", 1.2, 1.2),
        ("angle", "180 deg", pi),
        ("angle", "90°", pi / 2),
        ("angle", -1.5, -1.5),
    ],
)
def test_a_quantity_is_read_in_its_base_unit(field: str, text: object, value: float) -> None:
    assert getattr(Everything(**{field: text}), field) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("field", "text"),
    [
        ("duration", 20),
        ("duration", "20 msec"),
        ("duration", "fast"),
        ("duration", "0 ms"),
        ("time", "-1 s"),
        ("duration", "0.5 ns"),
        ("rate", "3 m"),
        ("length", True),
        ("angle", [1]),
    ],
)
def test_an_unreadable_value_is_refused_with_a_valid_example(
    field: str, text: object, golden: Golden
) -> None:
    with golden.raises(ValidationError):
        Everything(**{field: text})


@given(st.integers(1, 10**6))
def test_times_are_exact(n: int) -> None:
    assert Everything(duration=f"{n} us").duration == n * 1000
    assert Everything(duration=f"{n / 1000} ms").duration == n * 1000


@pytest.mark.parametrize(
    ("length", "text"),
    [(0.0, "0.00 m"), (12.345, "12.35 m"), (0.1, "0.10 m"), (0.0042, "4.2 mm"), (-0.05, "-50 mm")],
)
def test_short_lengths_are_shown_in_millimetres(length: float, text: str) -> None:
    assert length_text(length) == text


@pytest.mark.parametrize(
    ("written", "ns", "is_rounded"),
    [
        ("60 Hz", 16_700_000, True),
        ("1/60 s", 16_700_000, True),
        ("1000/60 ms", 16_700_000, True),
        ("30 Hz", 33_300_000, True),
        ("50 Hz", 20_000_000, False),
        ("1/50 s", 20_000_000, False),
        ("1 kHz", 1_000_000, False),
        ("20 ms", 20_000_000, False),
    ],
)
def test_a_period_may_be_a_rate_or_a_fraction(written: str, ns: int, is_rounded: bool) -> None:
    found = period_ns(written)
    assert (found, isinstance(found, RoundedNs)) == (ns, is_rounded)


@given(st.integers(1, 100_000))
def test_a_period_is_rounded_by_less_than_one_percent_or_refused(rate: int) -> None:
    try:
        found = period_ns(f"{rate} Hz")
    except ValueError:
        assert min(abs(10_000 - n * rate) for n in (10_000 // rate, 10_000 // rate + 1)) * 100 >= 10_000
    else:
        assert found % 100_000 == 0
        assert abs(found * rate - 10**9) * 100 < 10**9


@pytest.mark.parametrize("written", ["700 Hz", "0 Hz", "-60 Hz", "1/0 s", "1/60 parsec", "1/60", "60"])
def test_a_period_that_cannot_be_met_is_refused(written: str, golden: Golden) -> None:
    with golden.raises(ValueError):
        period_ns(written)
