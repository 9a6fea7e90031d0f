"""Scripts give with nrp-core what they give with NEST itself."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_pynest.script import run_script

CELLS = {
    "iaf_psc_exp": 40.0, "iaf_psc_alpha": 40.0, "iaf_psc_delta": 0.6, "iaf_cond_exp": 3.0,
    "iaf_cond_alpha": 3.0, "hh_psc_alpha": 300.0, "hh_cond_exp_traub": 6.0,
}  # fmt: skip
DRIVEN = """
import nest
nest.ResetKernel()
nest.resolution = 0.1
source = nest.Create("spike_generator", 2, {{"spike_times": [k * 3.7 + 1.0 for k in range(40)]}})
cell = nest.Create("{model}", 3, {{"I_e": [0.0, 200.0, {current}], "V_m": [-70.0, -66.0, -62.0]}})
nest.Connect(source[0], cell, syn_spec={{"weight": {weight}, "delay": 1.3}})
nest.Connect(source[1], cell, syn_spec={{"weight": -0.4 * {weight}, "delay": 2.0}})
nest.Connect(cell[2], cell[0], syn_spec={{"weight": 2.0 * {weight}, "delay": 1.0}})
meter = nest.Create("multimeter", params={{"record_from": ["V_m"], "interval": 0.5}})
heard = nest.Create("spike_recorder")
nest.Connect(meter, cell)
nest.Connect(cell, heard)
nest.Simulate(100.0)
nest.Simulate(60.0)
samples, spikes = meter.get("events"), heard.get("events")
"""
DEVICES = """
import nest
nest.ResetKernel()
cell = nest.Create("iaf_psc_exp", 3, {"V_th": 1000.0})
for k, (model, values) in enumerate([
    ("dc_generator", {"amplitude": 80.0, "start": 3.0, "stop": 30.0, "origin": 1.0}),
    ("step_current_generator", {"amplitude_times": [2.0, 9.5, 20.0], "amplitude_values": [50.0, -30.0, 9.0]}),
    ("dc_generator", {"amplitude": -40.0}),
]):
    nest.Connect(nest.Create(model, params=values), cell[k], syn_spec={"weight": 1.5, "delay": 1.0 + k / 2})
waves = nest.Create("ac_generator", params={"amplitude": 30.0, "frequency": 80.0, "phase": 30.0})
nest.Connect(waves, cell[2], syn_spec={"weight": 1.0, "delay": 1.7})
meter = nest.Create("voltmeter", params={"interval": 0.1, "start": 2.0, "stop": 40.0})
nest.Connect(meter, cell)
for amplitude in (60.0, -25.0, 90.0):
    nest.Simulate(10.0)
    waves.amplitude = amplitude
    nest.Simulate(0.4)
    waves.amplitude = amplitude / 2
nest.Simulate(30.0)
samples = meter.get("events")
"""
RECEPTORS = """
import nest
nest.ResetKernel()
source = nest.Create("spike_generator", params={{"spike_times": [10.0, 13.0, 60.0]}})
cell = nest.Create("{model}", 2, {values})
for k, weight in enumerate({weights}, 1):
    nest.Connect(source, cell, syn_spec={{"receptor_type": k, "weight": weight, "delay": 20.0 * k}})
drive = nest.Create("dc_generator", params={{"amplitude": {current}, "start": 20.0}})
nest.Connect(drive, cell[1])
meter = nest.Create("multimeter", params={{"record_from": {names}, "interval": 0.5}})
spikes = nest.Create("spike_recorder")
nest.Connect(meter, cell)
nest.Connect(cell, spikes)
nest.Simulate(250.0)
samples, spikes = meter.get("events"), spikes.get("events")
"""
PORTS: dict[str, tuple[dict[str, Any], list[float], float, list[str], float]] = {
    "iaf_psc_exp_multisynapse": ({"tau_syn": [2.0, 5.0, 9.0]}, [400.0, 300.0, -99.0], 500.0, ["V_m"], 1e-9),
    "iaf_psc_alpha_multisynapse": ({"tau_syn": [2.0, 5.0, 9.0]}, [400.0, 300.0, -99.0], 500.0, ["V_m"], 1e-9),
    "aeif_cond_alpha_multisynapse": (
        {"E_rev": [0.0, -85.0], "tau_syn": [2.0, 9.0]}, [4.0, 6.0], 400.0, ["V_m", "w"], 0.05,
    ),
    "aeif_cond_beta_multisynapse": (
        {"E_rev": [0.0, -85.0], "tau_decay": [20.0, 9.0], "tau_rise": [1.0, 9.0]}, [2.0, 6.0], 0.0,
        ["V_m", "w"], 0.05,
    ),
    "glif_psc": ({"tau_syn": [2.0, 5.0]}, [40.0, -20.0], 400.0, ["V_m", "threshold"], 1e-6),
    "glif_psc_double_alpha": (
        {"tau_syn_fast": [2.0, 4.0], "tau_syn_slow": [6.0, 9.0], "amp_slow": [0.3, 0.6],
         "spike_dependent_threshold": True, "after_spike_currents": True, "adapting_threshold": True},
        [40.0, -20.0], 400.0, ["V_m"], 3.0,
    ),
    "ht_neuron": ({}, [0.2, 0.2, 0.2, 0.2], 2.0, ["V_m", "I_h", "I_T", "I_NaP", "I_KNa"], 0.5),
}  # fmt: skip
GAPS = """
import nest
nest.ResetKernel()
nest.resolution = 0.05
cell = nest.Create("hh_psc_alpha_gap", 2, {"I_e": [100.0, 60.0]})
cell[0].V_m = -10.0
meter, spikes = nest.Create("voltmeter", params={"interval": 0.1}), nest.Create("spike_recorder")
nest.Connect(meter, cell)
nest.Connect(cell, spikes)
nest.Connect(cell, cell, {"rule": "all_to_all", "allow_autapses": False},
             {"synapse_model": "gap_junction", "weight": 0.5})
nest.Simulate(120.0)
samples, spikes = meter.get("events"), spikes.get("events")
"""
LEARNING = """
import nest
nest.ResetKernel()
times = [[k * 11.0 + 5.0 for k in range(15)], [k * 13.0 + 9.0 for k in range(12)]]
source = nest.Create("spike_generator", 2, [{"spike_times": one} for one in times])
relay, cell = nest.Create("parrot_neuron", 2), nest.Create("iaf_psc_exp", params={"tau_minus": 30.0})
nest.Connect(source, relay, "one_to_one")
nest.Connect(relay[1], cell, syn_spec={"weight": 3000.0})
nest.Connect(relay[0], cell, syn_spec={"synapse_model": "stdp_synapse", "weight": 20.0, "delay": 1.0,
             "Wmax": 60.0, "lambda": 0.05, "alpha": 1.1, "mu_plus": 0.0, "mu_minus": 0.0})
nest.Simulate(180.0)
weight = nest.GetConnections(relay[0], cell).weight
"""
SPACE = """
import nest
nest.ResetKernel()
layer = nest.Create("iaf_psc_alpha", positions=nest.spatial.grid([4, 3], center=[1.0, 0.0], extent=[4.0, 3.0],
                    edge_wrap={wrap}))
nest.Connect(layer, layer, {{"rule": "pairwise_bernoulli", "p": 1.0, {use} "mask": {{{mask}}}}},
             {{"weight": 1.0 + nest.spatial.distance}})
found = nest.GetConnections().get(["source", "target", "weight"])
synapses = sorted(zip(found["source"], found["target"], [round(w, 9) for w in found["weight"]]))
places = nest.GetPosition(layer)
middle = nest.FindCenterElement(layer).tolist()
far = nest.Distance(layer[0], layer)
"""


def both(folder: Path, text: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Run a script with nrp-core and with NEST; return the variables of both."""
    path = folder / "script.py"
    path.write_text(text)
    return vars(run_script(path)), runpy.run_path(str(path))


@pytest.mark.one_of(2)
@pytest.mark.parametrize("model", CELLS)
def test_driven_cells_fire_at_the_same_grid_points_and_have_the_same_voltages(
    tmp_path: Path, model: str
) -> None:
    ours, nests = both(
        tmp_path,
        DRIVEN.format(model=model, weight=CELLS[model], current=1500.0 if model == "hh_psc_alpha" else 420.0),
    )
    first, second = ours["spikes"], nests["spikes"]
    assert len(second["times"]) > 5
    order, other = (np.lexsort((one["senders"], one["times"])) for one in (first, second))
    assert first["senders"][order].tolist() == second["senders"][other].tolist()
    assert first["times"][order] == pytest.approx(second["times"][other], abs=1e-6)
    samples, expected = ours["samples"], nests["samples"]
    assert samples["times"] == pytest.approx(expected["times"])
    assert samples["senders"].tolist() == expected["senders"].tolist()
    steep = {"hh_psc_alpha": 1e-2, "hh_cond_exp_traub": 1.0}.get(
        model, 2e-3
    )  # its voltage rises by 300 mV in a ms
    assert samples["V_m"] == pytest.approx(expected["V_m"], abs=steep)


@pytest.mark.parametrize("model", PORTS)
def test_receptors_by_number_give_the_same_spikes_and_states(tmp_path: Path, model: str) -> None:
    values, weights, current, names, far = PORTS[model]
    text = RECEPTORS.format(model=model, values=values, weights=weights, current=current, names=names)
    ours, nests = both(tmp_path, text)
    assert ours["spikes"]["times"].tolist() == pytest.approx(nests["spikes"]["times"].tolist(), abs=1e-6)
    for name in names:
        assert ours["samples"][name] == pytest.approx(nests["samples"][name], abs=far)
        assert np.ptp(nests["samples"][name]) > 0 or name == "threshold"


def test_gap_junctions_give_the_same_spikes_and_voltages(tmp_path: Path) -> None:
    ours, nests = both(tmp_path, GAPS)
    assert ours["spikes"]["times"] == pytest.approx(nests["spikes"]["times"], abs=0.051)
    assert len(nests["spikes"]["times"]) > 2
    close = np.abs(ours["samples"]["V_m"] - nests["samples"]["V_m"]) < 2.0  # but for single samples of spikes
    assert close.mean() > 0.97


def test_generators_of_currents_act_at_the_same_times(tmp_path: Path) -> None:
    ours, nests = (one["samples"] for one in both(tmp_path, DEVICES))
    assert ours["times"] == pytest.approx(nests["times"])
    assert ours["V_m"] == pytest.approx(nests["V_m"], abs=1e-9)
    assert np.ptp(nests["V_m"]) > 5


def test_stdp_ends_at_the_same_weight(tmp_path: Path) -> None:
    ours, nests = both(tmp_path, LEARNING)
    assert ours["weight"] == pytest.approx(nests["weight"], rel=1e-9) != 20.0


@pytest.mark.one_of(4)
@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("use", ["", "'use_on_source': True,"], ids=["targets", "sources"])
@pytest.mark.parametrize(
    "mask",
    [
        "'circular': {'radius': 1.0}",
        "'rectangular': {'lower_left': [-0.5, -1.0], 'upper_right': [1.0, 0.2]}",
        "'doughnut': {'inner_radius': 1.0, 'outer_radius': 1.5}",
        "'elliptical': {'major_axis': 2.2, 'minor_axis': 1.2}",
        "'circular': {'radius': 1.0}, 'anchor': [1.0, 0.0]",
    ],
    ids=["circular", "rectangular", "doughnut", "elliptical", "anchored"],
)
def test_masks_choose_the_same_synapses(tmp_path: Path, wrap: bool, use: str, mask: str) -> None:
    ours, nests = both(tmp_path, SPACE.format(wrap=wrap, use=use, mask=mask))
    assert np.array(ours["places"]) == pytest.approx(np.array(nests["places"]))
    assert ours["far"] == pytest.approx(nests["far"])
    assert ours["synapses"] == nests["synapses"]
    assert len(ours["synapses"])
