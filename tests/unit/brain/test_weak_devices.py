"""Weights of devices that are too small for any rate are reported."""

from __future__ import annotations

import pytest

from nrp_core.brain.network.implausible import too_weak
from nrp_core.brain.pynn import builder


@pytest.mark.parametrize(
    ("cell", "setting", "weight", "words"),
    [
        # w 100/ms e tau_syn tau_m / cm of the shape of an alpha function, which is the largest
        ("IF_curr_exp", {}, 0.00015, "0.00015 nA: even 100000 spikes a second move a cell by 4.1 mV"),
        ("IF_curr_exp", {}, 0.001, ""),
        ("IF_curr_exp", {"v_thresh": -70.0, "v_reset": -75.0}, 0.00015, ""),  # a pacemaker
        ("IF_curr_exp", {"cm": 0.01}, 0.00015, ""),
        ("IF_curr_delta", {}, 0.0001, "0.0001 mV: even 100000 spikes a second move a cell by 0.2 mV"),
        ("IF_cond_alpha", {}, 0.00015, ""),
        ("IF_cond_alpha", {}, 1.5e-8, "1.5e-08 uS: even"),
        ("Izhikevich", {}, 1e-9, ""),
    ],
)
def test_a_weight_by_which_no_rate_makes_a_cell_fire_is_reported(
    cell: str, setting: dict[str, float], weight: float, words: str
) -> None:
    sim = builder()
    sim.Population(2, getattr(sim, cell)(**setting), label="cells")
    found = too_weak(weight, sim.network().populations["cells"])
    assert bool(found) == bool(words)
    assert found.startswith(words)
