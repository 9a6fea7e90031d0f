"""Short-term plasticity against the equations of Tsodyks, Uziel & Markram (2000)."""

from collections.abc import Callable
from math import exp

import numpy as np
import pytest

from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import TSODYKS_MARKRAM

TRAIN_MS = [1.0, 4.0, 4.5, 20.0, 90.0, 90.25, 91.0]


def released(u_jump: float, tau_rec: float, tau_facil: float, tau_psc: float) -> list[float]:
    """Integrate the equations in steps of 1 us (Runge-Kutta 4) and return u x at each spike of the train."""
    x, y, z, u = 1.0, 0.0, 0.0, 0.0
    shares, at_ms, rates = [], 0.0, np.array([[-1 / tau_psc, 0.0], [1 / tau_psc, -1 / tau_rec]])
    for spike_ms in TRAIN_MS:
        steps = round((spike_ms - at_ms) * 1000)
        step = rates * (spike_ms - at_ms) / max(1, steps)
        one = np.eye(2) + step @ (np.eye(2) + step @ (np.eye(2) + step @ (np.eye(2) + step / 4) / 3) / 2)
        y, z = np.linalg.matrix_power(one, steps) @ (y, z)
        u *= exp(-(spike_ms - at_ms) / tau_facil) if tau_facil else 0.0
        u += u_jump * (1.0 - u)
        x, at_ms = 1.0 - y - z, spike_ms
        shares.append(float(u * x))
        y += u * x
    return shares


@pytest.mark.parametrize(
    ("u_jump", "tau_rec", "tau_facil", "tau_psc"),
    [
        (1.0, 1.0, 1.0, 2.5),
        (0.5, 100.0, 0.0, 5.0),
        (0.1, 20.0, 500.0, 2.0),
        (0.7, 5.0, 30.0, 5.0),
        (0.7, 5.0, 30.0, 5.001),
    ],
)
def test_each_spike_arrives_with_the_share_of_the_weight_that_it_releases(
    u_jump: float, tau_rec: float, tau_facil: float, tau_psc: float,
    cells: Callable[..., Population], spike_source: Callable[..., Population],
    connect: Callable[..., Projection], open_brain: Callable[..., Brain],
) -> None:  # fmt: skip
    dynamics = {"U": u_jump, "tau_rec": tau_rec, "tau_facil": tau_facil, "kind": TSODYKS_MARKRAM}
    brain = open_brain(
        cells("cell", "IF_cond_exp", tau_syn_E=tau_psc),
        spike_source("source", TRAIN_MS),
        connect("source", "cell", 0.25, 0.5, **dynamics),
    )
    arrived, conductance, before_ms = [], 0.0, 0.0
    for spike_ms in TRAIN_MS:
        arrival_ms = spike_ms + 0.5
        brain.run_until(from_milliseconds(arrival_ms))
        now = float(brain.read_state("gsyn_exc", [0])[0])
        arrived.append(now - conductance * exp(-(arrival_ms - before_ms) / tau_psc))
        conductance, before_ms = now, arrival_ms
    expected = [0.25 * share for share in released(u_jump, tau_rec, tau_facil, tau_psc)]
    assert arrived[0] == pytest.approx(0.25 * u_jump, rel=1e-14)
    assert arrived == pytest.approx(expected, rel=1e-9)


def test_on_cells_without_a_synaptic_current_nothing_stays_active(
    cells: Callable[..., Population], spike_source: Callable[..., Population],
    connect: Callable[..., Projection], open_brain: Callable[..., Brain],
) -> None:  # fmt: skip
    dynamics = {"U": 0.5, "tau_rec": 10.0, "tau_facil": 0.0, "kind": TSODYKS_MARKRAM}
    brain = open_brain(
        cells("cell", "IF_curr_delta", tau_m=1e9),
        spike_source("source", [1.0, 6.0]),
        connect("source", "cell", 8.0, 1.0, **dynamics),
    )
    brain.run_until(from_milliseconds(2.0))
    assert brain.read_state("v", [0])[0] == pytest.approx(-65.0 + 4.0, abs=1e-6)
    brain.run_until(from_milliseconds(7.0))
    second = 8.0 * 0.5 * (1.0 - 0.5 * exp(-0.5))
    assert brain.read_state("v", [0])[0] == pytest.approx(-61.0 + second, abs=1e-6)
