"""Afferents have the rates of the published formulas; pools recruit units by their size."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden

from nrp_core.dsl import map_afferents, map_motoneurons
from nrp_core.dsl.afferents import Spindle, TendonOrgan
from nrp_core.dsl.functions import collecting
from nrp_core.errors import TransferFunctionError
from nrp_core.network.motoneurons import MotoneuronPool


@pytest.mark.parametrize(
    ("stretch", "velocity", "activation", "ia", "ii"),
    [
        (0.0, 0.0, 0.0, 50.0, 80.0),
        (5e-3, 0.05, 0.0, 104.962501, 147.5),
        (5e-3, -0.05, 0.0, 15.037499, 147.5),
        (2e-3, 0.1, 0.5, 147.150407, 117.0),
        (0.0, -0.2, 0.0, 0.0, 80.0),
    ],
)
def test_spindles_have_the_rates_of_their_formula(stretch, velocity, activation, ia, ii):
    assert Spindle().ia(stretch, velocity, activation) == pytest.approx(ia, abs=1e-6)
    assert Spindle().ii(stretch, activation) == pytest.approx(ii)


def test_gamma_drive_scales_the_terms_and_a_dead_zone_ends_chatter():
    assert Spindle(gamma_dynamic=0.0).ia(0.005, 0.05) == pytest.approx(60.0)
    assert Spindle(gamma_static=0.5).ii(0.002) == pytest.approx(0.5 * 107.0)
    assert Spindle(dead_zone=0.1).ia(0.0, 0.9e-4) == 50.0
    assert Spindle(highest=200.0).ia(0.02, 1.0) == 200.0


def test_tendon_organs_answer_a_step_as_their_transfer_function():
    """The gain is 1.7 at once and 1 in the end, as 1.7 s^2 and 0.4 / 0.4 say."""
    organ, step = TendonOrgan(highest=np.inf), 0.001
    rest, state = organ.filtered([4.0], None, step)
    assert rest == pytest.approx([60 * np.log(2)])
    jump = organ.static(12.0) - organ.static(4.0)
    first, state = organ.filtered([12.0], state, step)
    assert (first - rest) / jump == pytest.approx([1.7], rel=2e-3)
    for _ in range(10_000):
        last, state = organ.filtered([12.0], state, 0.01)
    assert last == pytest.approx([organ.static(12.0)], rel=1e-4)


def test_units_are_recruited_by_size():
    pool = MotoneuronPool(50, rheobase=0.3, recruitment=10.0)
    assert pool.rheobases[[0, -1]] == pytest.approx([0.3, 3.0])
    assert (np.diff(pool.rheobases) > 0).all()
    assert pool.twitches.sum() == pytest.approx(1.0)
    assert pool.twitches[-1] / pool.twitches[0] == pytest.approx(30.0)
    cell = pool.parameters()
    rheobases = np.array(cell["cm"]) / cell["tau_m"] * (cell["v_thresh"] - cell["v_rest"])
    assert rheobases == pytest.approx(pool.rheobases)
    assert pool.excitation(np.full(50, 80.0)) == pytest.approx(1.0)
    assert pool.excitation(np.full(50, 20.0)) == pytest.approx(0.5)


def test_one_statement_maps_a_group():
    with collecting() as functions:
        map_afferents("Ia", "/arm/muscles", {"biceps": lambda brain: brain})
        map_motoneurons("/arm/muscles", {"biceps": lambda brain: brain})
    assert [each.name for each in functions] == ["Ia_of_arm_muscles", "motoneurons_of_arm_muscles"]
    assert functions[0].subscribed[0].name == "/arm/muscles/state"
    assert functions[1].published[0].name == "/arm/muscles/cmd"


def test_mistakes_are_one_error(golden: Golden):
    with golden.raises(TransferFunctionError):
        map_afferents("Ia", "/arm/muscles", {})
    with golden.raises(TransferFunctionError, match="'/arm/muscles'.*'m'"):
        map_afferents("Ia", "/arm/muscles", {"m": None}, rest={"n": 0.2})
    with golden.raises(TransferFunctionError):
        map_afferents("Ia", "/arm/muscles", {"m": None}, model=TendonOrgan())
    with golden.raises(TransferFunctionError):
        map_motoneurons("/arm/muscles", {"m": None}, saturation=0.0)
