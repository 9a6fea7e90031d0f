"""Devices that listen: exact values, windows, and no trace of how a run was divided."""

from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.sinks import (
    LeakyIntegratorAlpha,
    LeakyIntegratorExp,
    PopulationRate,
    SinkPort,
    SinkSpec,
    SpikeRecorder,
)
from nrp_core.brain.spikes import Spikes
from nrp_core.errors import CapabilityError

SPECS = (LeakyIntegratorAlpha(delay=0.7), LeakyIntegratorExp(weight=-0.3), PopulationRate(), SpikeRecorder())
spike_lists = st.lists(st.tuples(st.floats(0.001, 50.0), st.integers(0, 4)), max_size=20)


def spikes(*pairs: tuple[float, int]) -> Spikes:
    """Make spikes from times (ms) and ids."""
    times, ids = (np.array(column) for column in zip(*sorted(pairs), strict=True)) if pairs else ([], [])
    return Spikes(np.array(ids, dtype=np.int64), np.array(times, dtype=float))


def opened(spec: SinkSpec, *neurons: int) -> Any:
    return spec.open(np.array(neurons), 5, "sink")


def reading(port: SinkPort) -> object:
    if port.quantity is not None:
        return getattr(port, port.quantity)
    return port.spikes().times_ms.tolist(), port.spikes().neurons.tolist()


@pytest.mark.parametrize(
    ("spec", "peak", "at_ms", "accuracy"),
    [
        (LeakyIntegratorAlpha(delay=0.0), 0.032502, 6.651, 5e-7),
        (LeakyIntegratorExp(delay=0.0), 0.004549, 1.892, 5e-7),
        (PopulationRate(), 25.0, 13.863, 1e-6),
    ],
)
def test_one_spike_has_the_peak_that_users_of_the_platform_know(
    spec: SinkSpec, peak: float, at_ms: float, accuracy: float
) -> None:
    port = opened(spec, 2)
    port.receive(spikes((1.0, 2)), 1.0)
    course = []
    for t_us in range(1000, 20_000):
        port.receive(Spikes(), t_us * 1e-3)
        course.append(reading(port))
    assert max(course) == pytest.approx(peak, abs=accuracy)
    assert np.argmax(course) * 1e-3 == pytest.approx(at_ms, abs=1.1e-3)


def test_a_population_rate_is_the_sum_of_the_rates_of_its_neurons() -> None:
    port = opened(PopulationRate(), 0, 1, 2)
    times = np.arange(1, 4001) * 0.5
    port.receive(spikes(*((t, k % 3) for k, t in enumerate(times))), 2000.0)
    assert port.rate == pytest.approx(2000.0, rel=0.02)  # one spike every 0.5 ms


def test_rise_and_fall_of_a_population_rate_are_exchanged_where_the_rise_is_slower() -> None:
    one, two = opened(PopulationRate(20.0, 10.0), 0), opened(PopulationRate(10.0, 20.0), 0)
    for port in (one, two):
        port.receive(spikes((1.0, 0)), 15.0)
    assert one.rate == two.rate > 20.0


def test_the_receptor_chooses_sign_and_time_constant() -> None:
    kinds = {"tau_syn_E": 3.0, "tau_syn_I": 8.0, "delay": 0.0}
    excited = opened(LeakyIntegratorAlpha(**kinds), 0)
    inhibited = opened(LeakyIntegratorAlpha(**kinds, receptor_type="inhibitory"), 0)
    slow = opened(LeakyIntegratorAlpha(tau_syn_E=8.0, delay=0.0), 0)
    for port in (excited, inhibited, slow):
        port.receive(spikes((0.5, 0)), 9.0)
    assert inhibited.voltage == -slow.voltage
    assert excited.voltage > 0


def test_only_spikes_of_chosen_neurons_count_and_one_chosen_twice_counts_twice() -> None:
    once, twice, other = (opened(LeakyIntegratorExp(), *ids) for ids in ((1,), (1, 1), (0, 4)))
    for port in (once, twice, other):
        port.receive(spikes((1.0, 1), (2.0, 3)), 5.0)
    assert twice.voltage == pytest.approx(2 * once.voltage, rel=1e-14)
    assert other.voltage == 0.0


def test_a_spike_is_seen_when_its_delay_has_passed_and_not_before() -> None:
    port = opened(LeakyIntegratorExp(delay=4.0), 0)
    port.receive(spikes((1.0, 0)), 4.999)
    assert port.voltage == 0.0
    port.receive(Spikes(), 5.001)
    assert port.voltage > 0.0


@given(pairs=spike_lists, cuts=st.lists(st.floats(0.0, 60.0), max_size=6), which=st.integers(0, 3))
def test_how_spikes_are_handed_over_does_not_matter(
    pairs: list[tuple[float, int]], cuts: list[float], which: int
) -> None:
    whole, split = opened(SPECS[which], 0, 3), opened(SPECS[which], 0, 3)
    everything = spikes(*pairs)
    whole.receive(everything, 60.0)
    since_ms = 0.0
    for until_ms in [*sorted(cuts), 60.0]:
        split.receive(everything.within(since_ms, until_ms), until_ms)
        reading(split)
        since_ms = until_ms
    assert reading(split) == reading(whole)


@given(pairs=spike_lists, cut=st.floats(0.0, 50.0), which=st.integers(0, 3))
def test_a_saved_sink_goes_on_where_it_was(pairs: list[tuple[float, int]], cut: float, which: int) -> None:
    port, other = opened(SPECS[which], 0, 3), opened(SPECS[which], 0, 3)
    everything = spikes(*pairs)
    port.receive(everything.within(-1.0, cut), cut)
    other.restore(port.save())
    for each in (port, other):
        each.receive(everything.within(cut, 60.0), 60.0)
    assert reading(other) == reading(port)


@pytest.mark.parametrize("spec", SPECS)
def test_a_reset_sink_has_no_spikes(spec: SinkSpec) -> None:
    port, fresh = opened(spec, 0), opened(spec, 0)
    port.receive(spikes((1.0, 0)), 5.0)
    assert reading(port) != reading(fresh)
    port.reset()
    assert reading(port) == reading(fresh)


@pytest.mark.parametrize("spec", SPECS)
def test_an_inactive_sink_is_deaf(spec: SinkSpec) -> None:
    port, fresh = opened(spec, 0), opened(spec, 0)
    port.active = False
    port.receive(spikes((1.0, 0)), 5.0)
    fresh.receive(Spikes(), 5.0)
    assert reading(port) == reading(fresh)


def test_a_recorder_shows_windows_that_tile() -> None:
    port = opened(SpikeRecorder(), 0, 1)
    port.receive(spikes((1.0, 0), (2.0, 1), (2.0, 0), (3.0, 4)), 4.0)
    port.receive(spikes((5.0, 1)), 6.0)
    assert port.spikes().times_ms.tolist() == [1.0, 2.0, 2.0, 5.0]
    assert port.spikes().neurons.tolist() == [0, 0, 1, 1]
    assert port.spikes(1.0, 2.0).neurons.tolist() == [0, 1]
    assert port.spikes(2.0).times_ms.tolist() == [5.0]
    assert port.spikes(until_ms=1.0).times_ms.tolist() == [1.0]


def test_a_recorder_that_forgets_keeps_at_least_what_it_promised() -> None:
    port = opened(SpikeRecorder(keep_ms=10.0), 0)
    for t_ms in range(1, 101):
        port.receive(spikes((float(t_ms), 0)), float(t_ms))
    assert port.spikes(90.0).times_ms.tolist() == [float(t) for t in range(91, 101)]
    assert len(port.spikes()) == 10


@pytest.mark.parametrize("name", ["cm", "tau_m", "tau_syn_E", "tau_syn_I"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_an_impossible_integrator_is_refused(name: str, value: float, golden: Golden) -> None:
    with golden.raises(ValueError, match=f"{name}"):
        LeakyIntegratorAlpha(**{name: value})


def test_other_impossible_sinks_are_refused(golden: Golden) -> None:
    with golden.raises(ValueError, match="-1"):
        LeakyIntegratorExp(delay=-1.0)
    with golden.raises(CapabilityError, match="v_thresh.*-50"):
        LeakyIntegratorExp(v_thresh=-50.0)
    with golden.raises(ValueError, match="tau_fall.*tau_rise"):
        PopulationRate(tau_rise=0.0)
