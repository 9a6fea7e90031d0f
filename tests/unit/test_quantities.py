"""Numbers with units."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from nrp_core.quantities import AngleRad, DurationNs, LengthM, RateHz, TimeNs, length_text


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
    ("field", "text", "says"),
    [
        ("duration", 20, "needs a unit"),
        ("duration", "20 msec", "did you mean 'ms'"),
        ("duration", "fast", "cannot read 'fast'"),
        ("duration", "0 ms", "more than 0"),
        ("time", "-1 s", "0 or more"),
        ("duration", "0.5 ns", "whole number of nanoseconds"),
        ("rate", "3 m", "valid: Hz, MHz, kHz"),
        ("length", True, "a length is a number with a unit"),
        ("angle", [1], "an angle is a number with a unit"),
    ],
)
def test_an_unreadable_value_is_refused_with_a_valid_example(field: str, text: object, says: str) -> None:
    with pytest.raises(ValidationError, match=says):
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
