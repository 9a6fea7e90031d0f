"""Cells of NEST with several receptors are those with two, if the signs of their weights tell them apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from nrp_legacy.brains import load_script

from nrp_core.errors import NetworkError
from nrp_core.network.data import Network

SEVERAL = """
import nest
noise = nest.Create('poisson_generator', 1, {'rate': 800.0})
cells = nest.Create('iaf_psc_%(shape)s_multisynapse', 3, {'tau_syn': [3.0, 7.0, 15.0], 'V_th': -50.0})
nest.CopyModel('static_synapse', 'inh', {'weight': -40.0, 'delay': 1.5, 'receptor_type': 3})
nest.Connect(noise, cells, syn_spec={'weight': 90.0, 'delay': 1.0, 'receptor_type': 2})
nest.Connect(cells, cells, 'all_to_all', syn_spec='inh')
circuit = cells
"""
TWO = """
import nest
noise = nest.Create('poisson_generator', 1, {'rate': 800.0})
cells = nest.Create('iaf_psc_%(shape)s', 3, {'tau_syn_ex': 7.0, 'tau_syn_in': 15.0, 'V_th': -50.0})
nest.CopyModel('static_synapse', 'inh', {'weight': -40.0, 'delay': 1.5})
nest.Connect(noise, cells, syn_spec={'weight': 90.0, 'delay': 1.0})
nest.Connect(cells, cells, 'all_to_all', syn_spec='inh')
circuit = cells
"""


def loaded(folder: Path, text: str) -> Network:
    path = folder / "b.py"
    path.write_text(text)
    return load_script(path, 0)


@pytest.mark.parametrize("shape", ["exp", "alpha"])
def test_cells_with_receptors_for_each_sign_are_those_with_two_receptors(tmp_path: Path, shape: str) -> None:
    several, two = (loaded(tmp_path, text % {"shape": shape}) for text in (SEVERAL, TWO))
    for own, other in zip(several.populations.values(), two.populations.values(), strict=True):
        assert (own.cell_type, own.size) == (other.cell_type, other.size)
        for name, values in other.parameters.items():
            assert np.array_equal(own.parameters[name], values), name
    for mine, its in zip(several.projections, two.projections, strict=True):
        assert (mine.receptor, mine.size) == (its.receptor, its.size)
        assert np.array_equal(mine.weight, its.weight)
        assert np.array_equal(mine.delay_ms, its.delay_ms)


def test_each_cell_has_the_receptors_that_it_uses(tmp_path: Path) -> None:
    text = SEVERAL % {"shape": "exp"}
    text += "nest.SetStatus(cells[:1], {'tau_syn': [3.0, 8.0, 16.0]})\n"
    network = loaded(tmp_path, text)
    (cells,) = (one for one in network.populations.values() if not one.is_source)
    assert cells.parameters["tau_syn_E"].tolist() == [8.0, 7.0, 7.0]
    assert cells.parameters["tau_syn_I"].tolist() == [16.0, 15.0, 15.0]


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("'receptor_type': 3", "'receptor_type': 4", "4; receptor_type"),
        (", 'receptor_type': 2", "", "receptor_type"),
    ],
)
def test_cells_whose_synapses_name_no_receptor_are_refused(
    tmp_path: Path, right: str, wrong: str, told: str, golden: Golden
) -> None:
    assert right in SEVERAL
    with golden.raises(NetworkError, match=told):
        loaded(tmp_path, SEVERAL.replace(right, wrong) % {"shape": "exp"})


def test_cells_with_several_receptors_for_a_sign_are_cells_in_equations(tmp_path: Path) -> None:
    network = loaded(tmp_path, SEVERAL.replace("'weight': -40.0", "'weight': 40.0") % {"shape": "exp"})
    (cells,) = (one for one in network.populations.values() if not one.is_source)
    assert cells.equations is not None
    assert [one.receptor for one in network.projections] == ["receptor2", "receptor3"]
    assert [float(one.weight[0]) for one in network.projections] == pytest.approx([0.09, 0.04])
