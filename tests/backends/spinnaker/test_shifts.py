"""Left shifts and raw weights: the rules of sPyNNaker 7.4.1 at their edges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_brain_spinnaker.host.weights import (
    Expectation,
    Incoming,
    binomial_quantile,
    host_raw,
    largest_input,
    left_shift,
    machine_raw,
    parse_distribution,
    poisson_share_below,
)
from nrp_brain_spinnaker.host.wiring import longest_delay, stages

MILLISECOND = Expectation(step_ms=1.0)


@given(st.floats(0, 60000))
def test_the_shift_leaves_a_spare_bit_above_the_largest_input(largest: float) -> None:
    shift = left_shift(largest)
    assert largest < 2**shift
    assert shift == 0 or largest >= 2 ** (shift - 1)
    assert host_raw(np.array([largest]), shift, 1)[0] <= 2**15


def test_different_delays_are_bounded_by_statistics_and_never_below_one_weight() -> None:
    many = Incoming(connections=1000, largest=0.1, mean=0.1, variance=0.0, delay_variance=1.0)
    rate = 1000 * 0.03
    assert largest_input([many], 1, MILLISECOND) == pytest.approx(rate * 0.1 + 5 * np.sqrt(rate * 0.01))
    lone = Incoming(connections=1, largest=3.0, mean=3.0, variance=0.0, delay_variance=1.0)
    assert largest_input([lone], 1, MILLISECOND) == 3.0


def test_unequal_weights_widen_the_bound() -> None:
    equal = Incoming(1000, 1.0, 0.1, 0.0, 1.0)
    unequal = Incoming(1000, 1.0, 0.1, 0.05, 1.0)
    assert largest_input([unequal], 1, MILLISECOND) > largest_input([equal], 1, MILLISECOND)


@given(st.floats(0, 0.999))
def test_machine_weights_pass_through_s1615_and_host_weights_do_not(weight: float) -> None:
    on_host, on_machine = (
        int(convert(np.array([weight]), 4, 1024)[0]) for convert in (host_raw, machine_raw)
    )
    assert on_host == round(weight * 2**21) % 2**16
    assert on_machine == round(weight * 2**15) * 2**6 % 2**16


def test_a_tiny_conductance_vanishes_on_the_machine_but_not_on_the_host() -> None:
    assert machine_raw(np.array([1e-5]), 0, 1024)[0] == 0
    assert host_raw(np.array([1e-5]), 0, 1024)[0] == 336


@pytest.mark.parametrize(
    ("text", "mean", "variance"),
    [
        ("uniform(low=1, high=3)", 2.0, 1 / 3),
        ("normal(mu=0.5, sigma=0.1)", 0.5, 0.01),
        ("exponential(beta=2.0)", 2.0, 4.0),
        ("lognormal(mu=0.0, sigma=0.5)", 1.1331, 0.3647),
        ("normal_clipped(mu=0.0, sigma=1.0, low=0.0, high=100.0)", 0.7979, 0.3634),
        ("normal_clipped_to_boundary(mu=0.0, sigma=1.0, low=0.0, high=100.0)", 0.3989, 0.3408),
    ],
)
def test_distributions_are_read_with_their_moments(text: str, mean: float, variance: float) -> None:
    read = parse_distribution(text)
    assert read is not None
    assert (read.mean, read.variance) == (pytest.approx(mean, rel=0.01), pytest.approx(variance, rel=0.02))
    assert read.quantile(0.3) < read.quantile(0.9) <= read.most_probable_extreme(10)


@pytest.mark.parametrize("text", [0.5, None, "0.5", "vonmises(mu=0, kappa=1)", "normal(mu=0.5)", "normal(a)"])
def test_an_unknown_distribution_is_replaced_by_its_drawn_values(text: object) -> None:
    assert parse_distribution(text) is None


def test_counts_of_connections_are_quantiles_of_the_binomial() -> None:
    assert binomial_quantile(800, 0.1, 1 - 1e-4 / 640000) == 138
    edges = [(5, 0.0), (5, 1.0), (0, 0.5)]
    assert [binomial_quantile(n, probability, 0.5) for n, probability in edges] == [0, 5, 0]
    assert poisson_share_below(1, 0.3) == pytest.approx(np.exp(-0.3))


def test_long_delays_take_stages_of_a_delay_extension() -> None:
    assert [stages(256, delay) for delay in (32, 33, 100, 288)] == [0, 1, 3, 8]
    assert longest_delay(256) == 288
