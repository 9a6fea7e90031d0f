"""Leaky membranes under weighted spikes: closed forms, any time constants, reading without a trace."""

from math import e, exp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.membrane import LeakyMembrane
from nrp_core.network.filters import MembraneKernel, driven

taus = st.floats(0.05, 200.0)
trains = st.lists(st.tuples(st.floats(0.0, 50.0), st.floats(-2.0, 2.0)), max_size=14)


def integral(values: np.ndarray, step: float) -> float:
    """Simpson's rule for an odd number of equidistant samples."""
    return float((values[:-2:2] + 4 * values[1:-1:2] + values[2::2]).sum() * step / 3.0)


def membrane(kernel: MembraneKernel, train: list[tuple[float, float]]) -> LeakyMembrane:
    new = LeakyMembrane(kernel)
    for spike in train:
        new.push(*zip(spike, strict=True))
    return new


@given(tau_m=taus, ratio=st.one_of(st.floats(0.02, 50.0), st.floats(0.98, 1.02), st.just(1.0)),
       dt=st.floats(0.0, 5.0), current=st.floats(-3.0, 3.0), slope=st.floats(-3.0, 3.0))  # fmt: skip
def test_a_decaying_current_contributes_its_integral_against_the_leak(
    tau_m: float, ratio: float, dt: float, current: float, slope: float
) -> None:
    tau_syn = tau_m * ratio
    dt *= min(tau_m, tau_syn)
    t = np.linspace(0.0, dt, 2001)
    values = (current + slope * t) * np.exp(-t / tau_syn - (dt - t) / tau_m)
    gap = 1.0 / tau_syn - 1.0 / tau_m
    left = driven(dt, exp(-dt / tau_m), exp(-dt / tau_syn), gap, current, slope)
    assert left == pytest.approx(integral(values, dt / 2000), rel=1e-9, abs=1e-11 * (1 + dt) ** 2)


@pytest.mark.parametrize("alpha", [False, True])
@pytest.mark.parametrize(("tau_m", "tau_syn"), [(10.0, 2.0), (2.0, 10.0), (5.0, 5.0), (20.0, 0.5)])
def test_the_area_under_one_spike_is_the_kernels(alpha: bool, tau_m: float, tau_syn: float) -> None:
    kernel = MembraneKernel(alpha, tau_m, tau_syn, cm_nf=0.5)
    one = membrane(kernel, [(0.0, 1.0)])
    t = np.linspace(0.0, 400.0, 20_001)
    assert integral(np.array([one.voltage_mv(x) for x in t]), 0.02) == pytest.approx(kernel.area, rel=1e-6)


def test_the_alpha_integrator_of_the_platform_peaks_where_it_should() -> None:
    one = membrane(MembraneKernel(alpha=True, tau_m_ms=10.0, tau_syn_ms=2.0), [(0.0, 0.01)])
    t = np.arange(6.0, 7.5, 0.001)
    voltages = [one.voltage_mv(x) for x in t]
    assert max(voltages) == pytest.approx(0.032502, abs=5e-7)
    assert t[int(np.argmax(voltages))] == pytest.approx(6.651, abs=1e-3)
    assert 0.01 * MembraneKernel(True, 10.0, 2.0).area == pytest.approx(0.543656, abs=1e-6)


def test_without_spikes_it_settles_under_its_constant_current() -> None:
    kernel = MembraneKernel(False, 10.0, 2.0, cm_nf=0.5, v_rest_mv=-65.0, i_offset_na=0.25)
    quiet = LeakyMembrane(kernel)
    assert kernel.settled_mv == -60.0
    assert quiet.voltage_mv(0.0) == -65.0
    assert quiet.voltage_mv(10.0) == pytest.approx(-60.0 - 5.0 / e)
    assert quiet.voltage_mv(1e4) == -60.0


@given(train=trains, alpha=st.booleans(), tau_m=taus, tau_syn=taus, reads=st.lists(st.floats(0.0, 60.0)))
def test_reading_leaves_no_trace(
    train: list[tuple[float, float]], alpha: bool, tau_m: float, tau_syn: float, reads: list[float]
) -> None:
    kernel = MembraneKernel(alpha, tau_m, tau_syn, v_rest_mv=3.0)
    read_often, read_once = membrane(kernel, train), membrane(kernel, train)
    for t_ms in sorted(reads):
        read_often.voltage_mv(t_ms)
    assert read_often.voltage_mv(60.0) == read_once.voltage_mv(60.0)


@given(train=trains, data=st.data())
def test_the_order_in_which_spikes_are_announced_does_not_matter(
    train: list[tuple[float, float]], data: st.DataObject
) -> None:
    kernel = MembraneKernel(True, 7.0, 3.0)
    shuffled = data.draw(st.permutations(train))
    assert membrane(kernel, train).voltage_mv(55.0) == membrane(kernel, shuffled).voltage_mv(55.0)


@given(train=trains, cut=st.floats(0.0, 50.0))
def test_a_restored_membrane_continues_with_its_spikes_in_transit(
    train: list[tuple[float, float]], cut: float
) -> None:
    kernel = MembraneKernel(False, 7.0, 3.0)
    original, other = membrane(kernel, train), LeakyMembrane(kernel)
    original.voltage_mv(cut)
    other.restore(original.state())
    assert other.voltage_mv(60.0) == original.voltage_mv(60.0)
