"""Afferents have the rates of the published formulas; pools recruit units by their size."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden

from nrp_core.dsl import map_afferents, map_motoneurons
from nrp_core.dsl.afferents import NormalizedSpindle, NormalizedTendonOrgan, Spindle, TendonOrgan
from nrp_core.dsl.functions import collecting
from nrp_core.dsl.proprioception import AfferentRates, _rates
from nrp_core.errors import TransferFunctionError
from nrp_core.messages.nrp_msgs import MuscleStates
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


def states(length: float, velocity: float, tension: float, *, optimal: float, force: float) -> MuscleStates:
    """Return the states of a muscle whose normalised values are those of the first three arguments."""
    values = optimal * length, optimal * velocity, force * tension, 0.2, length, tension, velocity
    return MuscleStates(name=["m"], **dict(zip(
        ("length", "velocity", "force", "activation", "normalized_length", "normalized_force",
         "normalized_velocity"), (np.array([each]) for each in values), strict=True)))  # fmt: skip


@pytest.mark.parametrize(("optimal", "force"), [(0.02, 5.0), (0.1, 300.0), (0.4, 6000.0)])
def test_normalised_rates_do_not_depend_on_the_size_of_the_body(optimal, force):
    """Ia = 200 (1 - 0.4) + 65 sqrt(0.25) + 50 * 0.2, II = 200 * 0.6 + 20 * 0.2, Ib = 250 * 0.3."""
    seen = states(1.0, 0.25, 0.3, optimal=optimal, force=force)
    rates = {}
    for kind, model in (
        ("Ia", NormalizedSpindle()),
        ("II", NormalizedSpindle()),
        ("Ib", NormalizedTendonOrgan()),
    ):
        rates[kind], _ = _rates(
            model, seen, np.array([0]), None, AfferentRates(kind, ("m",), None, 0.0), 0.01
        )
    assert rates == {"Ia": [pytest.approx(162.5)], "II": [pytest.approx(124.0)], "Ib": [pytest.approx(75.0)]}


@pytest.mark.parametrize(("length", "stretch"), [(1.0, 0.25), (0.8, 0.0), (0.6, 0.0)])
def test_stretches_in_lengths_at_rest_are_0_below_the_rest(length, stretch):
    model = NormalizedSpindle(by_rest=True, ia_emg=0.0)
    last = AfferentRates("Ia", ("m",), None, 0.0)
    seen = states(length, 0.8, 0.0, optimal=0.1, force=1.0)
    rates, _ = _rates(model, seen, np.array([0]), {"m": 0.8}, last, 0.01)
    assert rates == [pytest.approx(200.0 * stretch + 65.0)]


def test_tendon_organs_with_a_threshold_are_silent_below_it():
    organ = NormalizedTendonOrgan(threshold=0.2)
    assert organ.static([0.1, 0.2, 0.6]).tolist() == pytest.approx([0.0, 0.0, 100.0])


def test_muscles_whose_rate_is_almost_always_at_a_limit_are_known():
    memory = AfferentRates("II", ("m",), None, 0.0)
    for n in range(20):
        seen = states(0.3 if n else 1.0, 0.0, 0.0, optimal=0.1, force=1.0)
        _, memory = _rates(NormalizedSpindle(ii_emg=0.0), seen, np.array([0]), None, memory, 0.01 * n)
    assert (memory.samples, memory.lowest.tolist(), memory.limited()) == (20, [19], {"m": "0"})
    assert AfferentRates("Ib", ("m", "n"), None, 0.0, 0, np.array([6, 10]), 10).limited() == {
        "n": "at its highest"
    }
    assert not AfferentRates("Ia", ("m",), None, 0.0).limited()


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
