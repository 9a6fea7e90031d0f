"""Cells whose equations have conductances, against fine solutions; crossings of thresholds."""

from __future__ import annotations

from math import exp, log
from typing import Any

import numpy as np
import pytest
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.grid.equations import blocks, runge_kutta_source
from nrp_brain_event.grid.equations.layout import TOLERANCE
from scipy.integrate import quad, solve_ivp

from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.linear import driven, integrals

STEP_MS = 0.1
PARAMETERS = {
    "v_rest": "-65 mV", "tau_m": "20 ms", "cm": "1 nF", "e_exc": "0 mV", "e_inh": "-80 mV", "tau_exc": "2 ms",
    "tau_inh": "6 ms", "top": "1000 mV", "i_offset": "0 nA",
}  # fmt: skip
EQUATIONS = """
dv/dt = (v_rest - v)/tau_m + (I + i_offset)/cm : mV (unless refractory)
I = ge*(e_exc - v) + gi*(e_inh - v) : nA
dge/dt = -ge/tau_exc : nS
dgi/dt = -gi/tau_inh : nS
"""
TEXTS: dict[str, Any] = {
    "equations": EQUATIONS, "threshold": "v > top", "reset": "v = v_rest", "refractory": "2 ms",
    "receptors": {"excitatory": "ge", "inhibitory": "gi"},
}  # fmt: skip
V_MV, GE_NS, GI_NS = -55.0, np.geomspace(1.0, 1e4, 40), np.geomspace(3e3, 2.0, 40)
"""Conductances up to 200 times that of the leak, in which Runge-Kutta must divide the step."""


def voltages_after_a_step() -> np.ndarray:
    sim = builder()
    cell = sim.EquationCell(**TEXTS, parameters=PARAMETERS, initial={"v": f"{V_MV} mV"})
    sim.Population(len(GE_NS), cell(i_offset=0.3), label="cells").initialize(ge=GE_NS, gi=GI_NS)
    options = EventOptions.model_validate({"resolution": f"{STEP_MS} ms"})
    with EventBackend().open(sim.network(), seed=1, options=options) as brain:
        brain.run_until(round(STEP_MS * 1e6))
        return brain.read_state("v", np.arange(len(GE_NS)))


def fine_voltages_after_a_step() -> np.ndarray:
    def slope(t: float, v: float, ge: float, gi: float) -> float:
        ge, gi = ge * exp(-t / 2.0) * 1e-3, gi * exp(-t / 6.0) * 1e-3  # uS, so that nA / nF is mV / ms
        return (-65.0 - v) / 20.0 + ge * (0.0 - v) + gi * (-80.0 - v) + 0.3

    found = [
        solve_ivp(slope, (0.0, STEP_MS), [V_MV], method="DOP853", rtol=1e-13, atol=1e-13, args=args).y[0, -1]
        for args in zip(GE_NS, GI_NS, strict=True)
    ]
    return np.array(found)


def errors_in_tolerances() -> np.ndarray:
    expected = fine_voltages_after_a_step()
    return np.abs(voltages_after_a_step() - expected) / (TOLERANCE * (1.0 + np.abs(expected)))


@pytest.mark.heavy
def test_the_error_of_a_step_is_below_the_tolerance_for_any_conductances() -> None:
    assert errors_in_tolerances().max() < 1.0


@pytest.mark.heavy
def test_steps_that_are_not_bounded_are_beyond_the_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blocks, "SAFETY", 1e15)
    errors = errors_in_tolerances()
    assert errors.max() > 100.0
    assert errors.min() < 0.01, "the expansion is good where conductances are small"


def test_a_cell_whose_adaptation_follows_its_voltage_is_not_of_this_kind() -> None:
    units = {name: text.split()[1] for name, text in PARAMETERS.items()} | {"a": "nS", "tau_w": "ms"}
    adapting = (
        EQUATIONS.replace("I + i_offset", "I + i_offset - w") + "dw/dt = (a*(v - v_rest) - w)/tau_w : nA"
    )
    curved = EQUATIONS.replace("ge*(e_exc - v)", "ge*(e_exc - v)/(1 + exp(-v/(10*mV)))")
    found = [
        driven(CellEquations(**{**TEXTS, "equations": text}, units=units).model)
        for text in (EQUATIONS, adapting, curved)
    ]
    assert [None if one is None else list(one) for one in found] == [["v"], None, None]


@pytest.mark.parametrize("shape", ["exponential", "alpha"])
def test_integrals_are_those_of_the_formula(shape: str) -> None:
    tau, h, alpha = 2e-3, 1e-4, shape == "alpha"
    rise = "dx/dt = -x/tau : nS\n"
    equations = f"dv/dt = g*(top - v)/cm : mV\ndg/dt = {'(x - g)' if alpha else '-g'}/tau : nS\n{rise}"
    units = {"top": "mV", "cm": "nF", "tau": "ms"}
    cell = CellEquations(equations, "v > top", "v = top", receptors={"excitatory": "x"}, units=units)
    found = driven(cell.model)
    assert found is not None
    known = {"top": np.array([0.01]), "cm": np.array([2e-9]), "tau": np.array([tau])}
    sums = integrals(cell.model, found["v"].factor, known, 1, h)

    def courses(t: float) -> dict[str, float]:
        return {"g": exp(-t / tau), "x": t / tau * exp(-t / tau)} if alpha else {"g": exp(-t / tau)}

    for name in courses(0.0):
        whole = quad(lambda t, name=name: -courses(t)[name] / 2e-9, 0.0, h, epsabs=0.0)[0]
        moment = quad(lambda t, name=name: -(t / h - 0.5) * courses(t)[name] / 2e-9, 0.0, h, epsabs=0.0)[0]
        np.testing.assert_allclose(sums.whole[name], whole, rtol=1e-10)
        np.testing.assert_allclose(sums.moment[name], moment, rtol=1e-8)
        assert sums.size[name] >= abs(whole)
    assert sums.whole.keys() == courses(0.0).keys()


def spikes_ms(threshold: str) -> np.ndarray:
    sim = builder()
    cell = sim.EquationCell(
        "dv/dt = (25*mV - v)/tau : mV (unless refractory)", threshold, "v = 0*mV", "2 ms",
        parameters={"tau": "20 ms"}, method="runge_kutta",
    )  # fmt: skip
    sim.Population(1, cell(), label="cell")
    options = EventOptions.model_validate({"resolution": f"{STEP_MS} ms"})
    with EventBackend().open(sim.network(), seed=1, options=options) as brain:
        recorder = brain.add_sink(SpikeRecorder(), [0], name="spikes")
        brain.run_until(2_000_000_000)
        return recorder.spikes().times_ms


@pytest.mark.one_of(6)
@pytest.mark.parametrize("threshold", ["v > 15*mV", "15*mV <= v", "v > 15*mV and v > 10*mV"])
def test_crossings_are_found_where_the_closed_formula_says(threshold: str) -> None:
    period_ms = 20.0 * log(25.0 / 10.0) + 2.0
    crossed_ms = period_ms * np.arange(1, 200) - 2.0
    crossed_ms = crossed_ms[crossed_ms < 1999.9]
    distance = crossed_ms / STEP_MS - np.round(crossed_ms / STEP_MS)
    assert np.abs(distance).min() > 1e-4, "no crossing is so near to a grid point that rounding decides"
    np.testing.assert_allclose(spikes_ms(threshold), STEP_MS * np.ceil(crossed_ms / STEP_MS), atol=1e-9)


def test_a_chord_that_is_wrong_still_leads_to_the_crossing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runge_kutta_source, "_LEAST", 0.4)
    test_crossings_are_found_where_the_closed_formula_says("v > 15*mV")
