"""Neurons that NESTML ships are the cells that they describe: equal to PyNN's where PyNN has the same."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator

from nrp_nestml.cell import cell_of
from nrp_nestml.errors import NestmlError

MODELS = Path(sys.prefix) / "models/neurons"
STEP_MS = 0.1


class Pair(NamedTuple):
    """A model, PyNN's cell with the same equations, and weights that let it fire."""

    model: str
    cell: str
    parameters: dict[str, float]
    weights: tuple[float, float]
    """Of the receptors, in pA, nS or mV."""
    per_weight: float = 1e-3
    """From the unit of these weights to PyNN's."""
    most_mv: float = 1e-9
    is_linear: bool = True


CURRENTS = {
    "cm": 0.25, "tau_m": 10.0, "v_rest": -70.0, "v_reset": -70.0, "v_thresh": -55.0, "tau_refrac": 2.0,
    "tau_syn_E": 2.0, "tau_syn_I": 2.0,
}  # fmt: skip
CONDUCTANCES = {
    "cm": 0.25, "tau_m": 250.0 / 16.6667, "v_rest": -70.0, "v_reset": -60.0, "v_thresh": -55.0,
    "tau_refrac": 2.0, "e_rev_E": 0.0, "e_rev_I": -85.0, "tau_syn_E": 0.2, "tau_syn_I": 2.0,
}  # fmt: skip
PAIRS = (
    Pair("iaf_psc_exp_neuron", "IF_curr_exp", CURRENTS, (900.0, 300.0)),
    Pair("iaf_psc_alpha_neuron", "IF_curr_alpha", CURRENTS, (400.0, 100.0)),
    Pair("iaf_cond_alpha_neuron", "IF_cond_alpha", CONDUCTANCES, (100.0, 5.0), most_mv=1e-4, is_linear=False),
    Pair("iaf_cond_exp_neuron", "IF_cond_exp", CONDUCTANCES, (120.0, 5.0), most_mv=1e-4, is_linear=False),
)
CASES = [PAIRS[0], *(pytest.param(pair, marks=pytest.mark.heavy) for pair in PAIRS[1:])]


def response(cell: str, given: Any, weights: tuple[float, float], variable: str) -> tuple[Any, Any]:
    """Return the voltage (mV) and the steps of spikes of a cell that receives two trains."""
    sim = new_simulator()
    sim.setup(timestep=STEP_MS, options={"resolution": f"{STEP_MS} ms"})
    kind = sim.nestml_cell(MODELS / f"{cell}.nestml") if variable == "V_m" else getattr(sim, cell)
    cells = sim.Population(1, kind(**given))
    cells.initialize(**{variable: -70.0})
    rng = np.random.default_rng(4)
    for receptor, weight, n in zip(("excitatory", "inhibitory"), weights, (80, 20), strict=True):
        times = np.sort(rng.choice(np.arange(10, 2900), n, replace=False)) * STEP_MS
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=times.tolist()))
        synapse = sim.StaticSynapse(weight=weight, delay=1.0)
        sim.Projection(source, cells, sim.OneToOneConnector(), synapse, receptor_type=receptor)
    cells.record(["spikes", variable])
    sim.run(300.0)
    data = cells.get_data().segments[0]
    steps = np.rint(np.asarray(data.spiketrains[0]) / STEP_MS).astype(int)
    return np.asarray(data.filter(name=variable)[0])[:, 0], steps


@pytest.mark.parametrize("pair", CASES, ids=[pair.model for pair in PAIRS])
def test_a_neuron_that_pynn_has_too_has_its_voltage_and_spikes(pair: Pair) -> None:
    mine, spikes = response(pair.model, {}, pair.weights, "V_m")
    excitatory, inhibitory = (weight * pair.per_weight for weight in pair.weights)
    inhibitory *= -1 if "curr" in pair.cell else 1
    theirs, expected = response(pair.cell, pair.parameters, (excitatory, inhibitory), "v")
    assert len(expected) > 3
    assert len(spikes) == len(expected)
    same = slice(None)
    if pair.is_linear:
        assert spikes.tolist() == expected.tolist()
    else:  # cells in equations find the threshold within the step, so later ones are earlier
        same = slice(int(expected[0]))
        assert abs(int(spikes[0]) - int(expected[0])) <= 1
    assert np.abs(mine - theirs)[same].max() < pair.most_mv
    longer = {**pair.parameters, "tau_syn_E": 1.01 * pair.parameters["tau_syn_E"]}
    other, _ = response(pair.cell, longer, (excitatory, inhibitory), "v")
    assert np.abs(mine - other)[same].max() > 10 * pair.most_mv


def test_functions_peaks_and_pulses_become_equations() -> None:
    barrel = cell_of(MODELS / "wb_cond_exp_neuron.nestml")
    assert "alpha_m" not in barrel["equations"]
    assert "(V_m_falls < 0)" in barrel["threshold"]
    assert barrel["refractory"].replace("(", "").replace(")", "") == "refr_T/ms*ms"
    untested = cell_of(MODELS / "aeif_psc_exp_neuron.nestml")  # its threshold does not test its timer
    assert "refr_t" not in untested["equations"] + untested["reset"]
    assert untested["refractory"].replace("(", "").replace(")", "") == "refr_T/ms*ms"
    pulses = cell_of(MODELS / "iaf_psc_delta_neuron.nestml")
    assert list(pulses["receptors"]) == ["excitatory"]
    assert pulses["parameters"]["V_th"] == "-55.0 mV"


def test_a_cell_that_counts_steps_fires_when_its_period_is_over() -> None:
    sim = new_simulator()
    sim.setup(timestep=STEP_MS)
    rates = [10.0, 30.0, 2000.0]
    cells = sim.Population(3, sim.nestml_cell(MODELS / "ignore_and_fire_neuron.nestml")(firing_rate=rates))
    cells.initialize(phase_steps=0.0)
    cells.record("spikes")
    sim.run(1000.0)
    for rate, train in zip(rates, cells.get_data().segments[0].spiketrains, strict=True):
        period = np.ceil(1000.0 / rate / STEP_MS - 1e-6)
        steps = np.rint(np.asarray(train) / STEP_MS).astype(int)
        assert steps.tolist() == (np.arange(1, 10000 // period + 1) * period).astype(int).tolist()


class Reference(NamedTuple):
    """A model, its spike ports with receptors, weights and numbers of spikes, and NESTML's own result.

    Args:
        apart: steps between two spikes; a spike in the last step of a refractory period is lost here.
        step_ms: of NESTML, which holds the input of a step.
        late_ms: the largest difference of a spike.
        most: the largest difference of the variable up to the first spike, and later.
    """

    model: str
    variable: str
    ports: dict[str, tuple[str, float, int]]
    apart: int
    step_ms: float
    late_ms: float
    most: tuple[float, float]


REFERENCES = (
    Reference(
        "iaf_psc_delta_fixed_timestep_neuron", "V_m", {"spikes": ("excitatory", 4.0, 400)}, 3, 0.1, 1e-9,
        (1e-9, 1e-9),
    ),
    Reference(
        "aeif_psc_exp_neuron", "V_m",
        {"exc_spikes": ("excitatory", 30000.0, 120), "inh_spikes": ("inhibitory", 900.0, 20)}, 1, 0.005, 0.2,
        (1e-2, np.inf),
    ),
    Reference("ignore_and_fire_neuron", "phase_steps", {}, 1, 0.1, 1e-9, (1e-9, 1e-9)),
    Reference(
        "iaf_chxk_2008_neuron", "V_m",
        {"exc_spikes": ("excitatory", 60.0, 60), "inh_spikes": ("inhibitory", 20.0, 20)}, 1, 0.005, 0.1,
        (1e-6, np.inf),
    ),
)  # fmt: skip


def of_nestml(cell: Any, case: Reference, steps: dict[str, set[int]], weights: dict[str, float]) -> Any:
    """Return the variable in each step, and the times of spikes (ms), of a neuron in NESTML's own Python."""
    per, values, fired = round(STEP_MS / case.step_ms), [], []
    for k in range(1, 3000 * per + 1):
        for port, arrivals in steps.items():
            if k % per == 0 and k // per in arrivals:
                cell.handle(k * case.step_ms, weights[port], port)
        cell.step((k - 1) * case.step_ms, case.step_ms)
        if cell.pop_emitted_spikes():
            fired.append(k * case.step_ms)
        if k % per == 0:
            state, names = cell.S_, getattr(cell.S_, "ode_state_variable_name_to_index", {})
            in_ode = case.variable in names
            values.append(state.ode_state[names[case.variable]] if in_ode else getattr(state, case.variable))
    return np.array(values), np.array(fired)


@pytest.mark.heavy
def test_neurons_that_pynn_lacks_are_those_of_nestmls_own_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from importlib import import_module

    from pynestml.frontend.pynestml_frontend import generate_python_standalone_target

    files = [str(MODELS / f"{case.model}.nestml") for case in REFERENCES]
    generate_python_standalone_target(files, target_path=str(tmp_path / "made"), logging_level="ERROR")
    monkeypatch.syspath_prepend(tmp_path)
    for case in REFERENCES:
        rng = np.random.default_rng(4)
        sim = new_simulator()
        sim.setup(timestep=STEP_MS)
        cells = sim.Population(1, sim.nestml_cell(MODELS / f"{case.model}.nestml")())
        steps, weights = {}, {}
        for port, (receptor, weight, n) in case.ports.items():
            arrivals = np.unique(rng.choice(np.arange(12, 2900), n, replace=False) // case.apart) * case.apart
            steps[port], weights[port] = set(arrivals.tolist()), weight
            source = sim.Population(1, sim.SpikeSourceArray(spike_times=((arrivals - 10) * STEP_MS).tolist()))
            synapse = sim.StaticSynapse(weight=weight, delay=1.0)
            sim.Projection(source, cells, sim.OneToOneConnector(), synapse, receptor_type=receptor)
        cells.record(["spikes", case.variable])
        sim.run(300.0)
        data = cells.get_data().segments[0]
        mine = np.asarray(data.filter(name=case.variable)[0])[1:, 0]
        theirs_class = getattr(import_module(f"made.{case.model}"), f"Neuron_{case.model}")
        theirs, fired = of_nestml(theirs_class(case.step_ms), case, steps, weights)
        theirs = theirs * STEP_MS if case.variable == "phase_steps" else theirs
        spikes = np.asarray(data.spiketrains[0])
        assert len(spikes) == len(fired) > 2, case.model
        assert np.abs(spikes - fired).max() < case.late_ms + 1e-6
        first = int(fired[0] / STEP_MS) - 1
        apart = np.abs(mine - theirs)
        assert apart[:first].max() < case.most[0]
        assert apart.max() < case.most[1]


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ("iaf_psc_exp_htum_neuron", r"line \d+: an update has no conditions but 'if refr_t > 0 ms'"),
        pytest.param(
            "traub_cond_multisyn_neuron",
            r"line \d+: it has more than one excitatory port",
            marks=pytest.mark.heavy,
        ),
    ],
)
def test_what_a_cell_in_equations_does_not_have_is_refused_with_its_line(model: str, message: str) -> None:
    with pytest.raises(NestmlError, match=message):
        cell_of(MODELS / f"{model}.nestml")


def test_a_mistake_in_a_file_is_one_error_of_the_network(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.nestml"
    wrong.write_text("model wrong:\n    state\n        V_m mV = 3 mV\n")
    with pytest.raises(NetworkError, match=r"wrong.nestml: NESTML cannot read it"):
        new_simulator().nestml_cell(wrong)


@pytest.mark.heavy
def test_most_neurons_that_nestml_ships_are_cells_here() -> None:
    sim = new_simulator()
    sim.setup(timestep=STEP_MS)
    made, refused = [], []
    for path in sorted(MODELS.glob("*.nestml")):
        try:
            sim.Population(2, sim.nestml_cell(path)())
            made.append(path.stem)
        except NetworkError:
            refused.append(path.stem)
    assert len(made) >= 25, refused
