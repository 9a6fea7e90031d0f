"""Neurons that NESTML ships become cells, or are refused with the line."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from nrp_core.errors import NetworkError
from nrp_core.pynn import new_simulator

from nrp_nestml.cell import cell_of
from nrp_nestml.errors import NestmlError

MODELS = Path(sys.prefix) / "models/neurons"
STEP_MS = 0.1


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


def test_ports_of_no_sign_are_receptors_of_their_own_names() -> None:
    cell = cell_of(MODELS / "wb_cond_multisyn_neuron.nestml")
    assert list(cell["receptors"]) == ["AMPA", "NMDA", "GABA_A", "GABA_B"]


def test_unsupported_statements_of_a_cell_are_refused_with_their_line() -> None:
    with pytest.raises(NestmlError, match="'if refr_t > 0 ms'"):
        cell_of(MODELS / "iaf_psc_exp_htum_neuron.nestml")


def test_a_mistake_in_a_file_is_one_error_of_the_network(tmp_path: Path, golden: Golden) -> None:
    wrong = tmp_path / "wrong.nestml"
    wrong.write_text("model wrong:\n    state\n        V_m mV = 3 mV\n")
    with golden.raises(NetworkError):
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
    assert len(made) == 27, refused
