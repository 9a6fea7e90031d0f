"""The shipped Braitenberg brain has the cells and synapses of the original experiment."""

from pathlib import Path

import nrp_experiments.braitenberg_husky as experiment
import numpy as np
import pytest

from nrp_core.network.data import Network
from nrp_core.network.files.script import load_network

SCRIPT = Path(next(iter(experiment.__path__))) / "brain.py"


@pytest.fixture(scope="module")
def brain() -> Network:
    return load_network(SCRIPT, populations={"sensors": "0:5", "actors": "5:8"})


def test_it_has_eight_cells_of_which_one_fires_by_itself(brain: Network) -> None:
    (cells,) = brain.populations.values()
    assert (cells.size, cells.cell_type) == (8, "IF_cond_alpha")
    common = {
        "v_rest": -60.5, "cm": 0.025, "tau_m": 10.0, "tau_refrac": 10.0, "tau_syn_E": 2.5, "tau_syn_I": 2.5,
        "e_rev_E": 0.0, "e_rev_I": -75.0, "i_offset": 0.0,
    }  # fmt: skip
    for name, value in common.items():
        assert cells.parameters[name].tolist() == [value] * 8
    others = np.arange(8) != 5
    assert set(cells.parameters["v_thresh"][others]) == {-60.0}
    assert set(cells.parameters["v_reset"][others]) == {-60.5}
    assert (cells.parameters["v_thresh"][5], cells.parameters["v_reset"][5]) == (-60.51, -61.6)
    assert (cells.parameters["v_rest"] > cells.parameters["v_thresh"]).tolist() == (~others).tolist()
    assert cells.initial_values["v"].tolist() == [-60.5] * 8


def test_its_synapses_are_those_of_the_original(brain: Network) -> None:
    found = {
        (int(i), int(j), projection.receptor, float(weight))
        for projection in brain.projections
        for i, j, weight in zip(projection.pre_index, projection.post_index, projection.weight, strict=True)
    }
    assert found == {
        (2, 7, "excitatory", 1.5e-4), (3, 6, "excitatory", 1.5e-4),
        (4, 7, "excitatory", 1.05e-4), (5, 7, "excitatory", 1.4e-4),
        (0, 4, "inhibitory", 1.2e-3), (1, 4, "inhibitory", 1.2e-3),
        (0, 5, "inhibitory", 1.2e-3), (1, 5, "inhibitory", 1.2e-3),
    }  # fmt: skip
    for projection in brain.projections:
        assert projection.synapse_type == "tsodyks_markram"
        assert set(projection.delay_ms) == {0.1}
        assert {k: set(v) for k, v in projection.synapse_parameters.items()} == {
            "U": {1.0}, "tau_rec": {1.0}, "tau_facil": {1.0},
        }  # fmt: skip


def test_experiments_name_its_cells(brain: Network) -> None:
    assert brain.neurons("sensors").tolist() == [0, 1, 2, 3, 4]
    assert brain.neurons("actors").tolist() == [5, 6, 7]
    assert brain.timestep_ms == 0.1
