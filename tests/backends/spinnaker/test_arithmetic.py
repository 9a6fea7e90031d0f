"""Fixed-point arithmetic against exact integers and exact decimals."""

from decimal import Decimal
from fractions import Fraction
from math import floor

import numpy as np
import pytest
from golden import Golden
from hypothesis import example, given, settings
from hypothesis import strategies as st
from nrp_brain_spinnaker.machine.fixed_point import (
    FRACTION_LARGEST,
    LARGEST,
    ONE,
    SMALLEST,
    ceiling,
    clamp,
    div,
    exp_accum,
    exp_fraction,
    from_accum,
    mul,
    scale,
    to_accum,
    wrap,
)

ACCUM = st.integers(SMALLEST, LARGEST)
FRACTION = st.integers(0, FRACTION_LARGEST)

compiling = settings(deadline=None)
"""The first example of a compiled function may include its compilation."""


def low_32_bits(value: int) -> int:
    return int.from_bytes((value % 2**32).to_bytes(4, "little"), "little", signed=True)


@compiling
@given(st.integers(-(2**62), 2**62))
def test_wrapping_keeps_the_low_32_bits_as_a_signed_number(value: int) -> None:
    assert wrap(value) == low_32_bits(value)


@compiling
@given(ACCUM, ACCUM)
@example(SMALLEST, SMALLEST)
def test_a_product_is_floored_and_wraps(a: int, b: int) -> None:
    assert mul(a, b) == low_32_bits(floor(Fraction(a * b, ONE)))


@compiling
@given(ACCUM, FRACTION)
@example(SMALLEST, FRACTION_LARGEST)
@example(-1, 1)
def test_scaling_by_a_fraction_is_floored(a: int, fraction: int) -> None:
    assert scale(a, fraction) == floor(Fraction(a * fraction, 2**32))


@compiling
@given(st.integers(0, LARGEST), st.integers(1, LARGEST))
def test_a_quotient_of_positive_numbers_is_truncated(a: int, b: int) -> None:
    assert div(a, b) == low_32_bits(a * ONE // b)


@compiling
@given(st.integers(0, LARGEST))
def test_the_ceiling_is_the_least_integer_not_below(a: int) -> None:
    assert ceiling(a) == -(-a // ONE)


@compiling
@given(st.integers(-(2**40), 2**40))
def test_clamping_returns_the_nearest_number_of_the_format(value: int) -> None:
    assert clamp(value) == sorted([SMALLEST, value, LARGEST])[1]


@compiling
@given(st.integers(-340695, -1))
@example(-1)
@example(-32768)
def test_the_exponential_stays_within_its_known_error(n: int) -> None:
    exact = (Decimal(n) / ONE).exp()
    assert -1.04 < exp_accum(n) - exact * ONE < 0.04
    assert abs(exp_fraction(n) / Decimal(2**32) - exact) < Decimal("1.3e-6")


@pytest.mark.parametrize(
    ("n", "accum", "fraction"), [(0, ONE, 0), (363409, LARGEST, LARGEST), (-340696, 0, 0), (-1, 32766, None)]
)
def test_the_exponential_at_its_ends(n: int, accum: int, fraction: int | None) -> None:
    assert exp_accum(n) == accum
    assert fraction is None or exp_fraction(n) == fraction


@compiling
@given(st.floats(-65536, 65535.9999))
@example(0.2)
@example(-1.52587890625e-05)
@example(16384.63038635254)
def test_the_host_rounds_what_is_written_to_nearest_with_ties_to_even(value: float) -> None:
    assert int(to_accum(value)) == round(Decimal(repr(value)) * ONE)


def test_a_negative_divisor_is_larger_than_any_dividend() -> None:
    assert div(ONE, -1) == div(LARGEST, -(2**31)) == 0


@compiling
@given(ACCUM)
def test_reading_back_is_exact(raw: int) -> None:
    assert to_accum(from_accum(raw)) == raw


@pytest.mark.parametrize("value", [65536.0, -65536.1, np.inf, np.nan])
def test_a_number_outside_the_format_is_refused_by_name(value: float, golden: Golden) -> None:
    with golden.raises(ValueError):
        to_accum([1.0, value], "tau_m")
