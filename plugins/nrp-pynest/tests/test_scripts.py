"""Scripts of PyNEST run in brain backends, and build the brains of experiments."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_pynest.script import run_script

from nrp_core.errors import NetworkError, NrpError
from nrp_core.network.files.script import load_network

Run = Callable[[str], dict[str, Any]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Run a script and return its variables."""

    def script(text: str) -> dict[str, Any]:
        path = tmp_path / "script.py"
        path.write_text(text)
        return vars(run_script(path))

    return script


def test_a_voltmeter_has_a_sample_each_millisecond_that_follows_the_membrane_equation(run: Run) -> None:
    found = run(
        "import nest\n"
        "cell = nest.Create('iaf_psc_exp', params={'I_e': 100.0, 'tau_m': 20.0, 'C_m': 200.0})\n"
        "meter = nest.Create('voltmeter')\n"
        "nest.Connect(meter, cell)\n"
        "nest.Simulate(10.0)\n"
        "first = meter.get('events')\n"
        "nest.Simulate(2.0)\n"
        "then = meter.events['times']\n"
    )
    times = np.arange(1.0, 10.0)  # the sample of the present time is collected later
    assert found["first"]["times"].tolist() == times.tolist()
    assert set(found["first"]["senders"].tolist()) == {1}
    rises = 100.0 * 20.0 / 200.0
    assert found["first"]["V_m"] == pytest.approx([-70.0 + rises * (1 - exp(-t / 20.0)) for t in times])
    assert found["then"].tolist() == np.arange(1.0, 12.0).tolist()


def test_a_current_arrives_after_the_delay_of_its_synapse_and_ends_at_its_stop(run: Run) -> None:
    found = run(
        "import nest\n"
        "cell = nest.Create('iaf_psc_exp', params={'tau_m': 1e6, 'C_m': 100.0})\n"
        "source = nest.Create('dc_generator', params={'amplitude': 50.0, 'start': 2.0, 'stop': 5.0})\n"
        "nest.Connect(source, cell, syn_spec={'delay': 1.5})\n"
        "meter = nest.Create('multimeter', params={'record_from': ['V_m'], 'interval': 0.5})\n"
        "nest.Connect(meter, cell)\n"
        "nest.Simulate(10.0)\n"
        "times, volts = meter.events['times'], meter.events['V_m']\n"
    )
    at = dict(zip(found["times"].tolist(), found["volts"].tolist(), strict=True))
    assert at[3.5] == pytest.approx(-70.0)
    assert at[4.5] == pytest.approx(-69.5, abs=1e-4)  # 50 pA / 100 pF is 0.5 mV in a ms
    assert [at[6.5], at[8.0]] == pytest.approx([-68.5, -68.5], abs=1e-4)


def test_a_changed_current_arrives_after_the_delay_of_its_synapse(run: Run) -> None:
    found = run(
        "import nest\n"
        "cell = nest.Create('iaf_psc_exp', params={'tau_m': 1e6, 'C_m': 100.0})\n"
        "source = nest.Create('dc_generator', params={'amplitude': 50.0, 'start': 2.0})\n"
        "nest.Connect(source, cell, syn_spec={'delay': 1.5})\n"
        "meter = nest.Create('multimeter', params={'record_from': ['V_m'], 'interval': 0.5})\n"
        "nest.Connect(meter, cell)\n"
        "nest.Simulate(4.5)\n"
        "source.amplitude = -100.0\n"
        "nest.Simulate(0.5)\n"
        "source.amplitude = 0.0\n"
        "nest.Simulate(5.0)\n"
        "times, volts = meter.events['times'], meter.events['V_m']\n"
    )
    at = dict(zip(found["times"].tolist(), found["volts"].tolist(), strict=True))
    assert [at[3.5], at[6.0], at[6.5], at[9.0]] == pytest.approx([-70.0, -68.75, -69.1, -69.2], abs=1e-4)


def test_the_state_of_a_cell_can_be_read_while_it_runs(run: Run) -> None:
    found = run(
        "import nest\n"
        "cell, source = nest.Create('iaf_cond_exp', 1, {'tau_syn_ex': 2.0}), nest.Create('spike_generator')\n"
        "source.spike_times = [1.0]\n"
        "nest.Connect(source, cell, syn_spec={'weight': 5.0, 'delay': 1.0})\n"
        "nest.Simulate(5.0)\n"
        "open_, others = cell.g_ex, cell.get(['V_m', 'g_in'])\n"
    )
    assert found["open_"] == pytest.approx(5.0 * exp(-3.0 / 2.0))
    assert found["others"]["V_m"] > -70.0
    assert found["others"]["g_in"] == 0.0


def test_spikes_reach_their_targets_and_recorders_after_each_simulate(run: Run) -> None:
    found = run(
        "import nest\n"
        "nest.resolution = 0.25\n"
        "source = nest.Create('spike_generator', params={'spike_times': [1.0, 5.0, 12.0]})\n"
        "relay, heard = nest.Create('parrot_neuron', 2), nest.Create('spike_recorder')\n"
        "nest.Connect(source, relay, syn_spec={'weight': 1.0, 'delay': [[0.5], [2.0]]})\n"
        "nest.Connect(relay, heard)\n"
        "nest.Simulate(10.0)\n"
        "count = heard.n_events\n"
        "heard.n_events = 0\n"
        "nest.Simulate(10.0)\n"
        "events, now = heard.events, nest.biological_time\n"
    )
    assert (found["count"], found["now"], found["nest"].GetKernelStatus("resolution")) == (4, 20.0, 0.25)
    assert found["events"]["times"] == pytest.approx([12.5, 14.0])
    assert found["events"]["senders"].tolist() == [2, 3]


def test_a_reset_kernel_starts_again_and_numbers_nodes_from_1(run: Run) -> None:
    found = run(
        "import nest\n"
        "counts = []\n"
        "for current in (0.0, 400.0, 600.0):\n"
        "    nest.ResetKernel()\n"
        "    cell = nest.Create('iaf_psc_alpha', params={'I_e': current})\n"
        "    heard = nest.Create('spike_recorder')\n"
        "    nest.Connect(cell, heard)\n"
        "    nest.Simulate(100.0)\n"
        "    counts.append(heard.n_events)\n"
        "number = cell.global_id\n"
    )
    silent, slow, fast = found["counts"]
    assert silent == 0 < slow < fast
    assert found["number"] == 1


def test_nodes_on_a_grid_are_connected_within_a_mask_and_across_its_edges(run: Run) -> None:
    found = run(
        "import nest\n"
        "def targets(wrap):\n"
        "    nest.ResetKernel()\n"
        "    layer = nest.Create('iaf_psc_alpha',\n"
        "                        positions=nest.spatial.grid([5, 5], extent=[5.0, 5.0], edge_wrap=wrap))\n"
        "    nest.Connect(layer, layer, {'rule': 'pairwise_bernoulli', 'p': 1.0,\n"
        "                                'mask': {'circular': {'radius': 1.0}}},\n"
        "                 {'weight': 2.0 * nest.spatial.distance})\n"
        "    near = nest.GetConnections(layer[0])\n"
        "    return nest.GetPosition(layer[0]), nest.GetTargetPositions(layer[0], layer)[0], near.weight\n"
        "free, wrapped = targets(False), targets(True)\n"
    )
    place, near, weights = found["free"]
    assert place == (-2.0, 2.0)  # the upper left, then down the column
    assert sorted(near) == [(-2.0, 1.0), (-2.0, 2.0), (-1.0, 2.0)]
    assert sorted(weights) == [0.0, 2.0, 2.0]
    _, near, weights = found["wrapped"]
    assert sorted(near) == [(-2.0, -2.0), (-2.0, 1.0), (-2.0, 2.0), (-1.0, 2.0), (2.0, 2.0)]
    assert sorted(weights) == [0.0, 2.0, 2.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("rule", "sources", "targets"),
    [
        ("{'rule': 'fixed_indegree', 'indegree': 3, 'allow_autapses': False}", None, [3] * 8),
        ("{'rule': 'fixed_outdegree', 'outdegree': 7, 'allow_autapses': False, 'allow_multapses': False}",
         [7] * 8, [7] * 8),
        ("{'rule': 'pairwise_bernoulli', 'p': 1.0, 'allow_autapses': False}", [7] * 8, [7] * 8),
    ],
)  # fmt: skip
def test_rules_make_their_numbers_of_synapses(
    run: Run, rule: str, sources: list[int] | None, targets: list[int]
) -> None:
    found = run(
        f"import nest\ncells = nest.Create('iaf_psc_alpha', 8)\nnest.Connect(cells, cells, {rule})\n"
        "every = nest.GetConnections().get(['source', 'target'])\n"
    )["every"]
    assert np.bincount(found["target"], minlength=9)[1:].tolist() == targets
    assert sources is None or np.bincount(found["source"], minlength=9)[1:].tolist() == sources
    assert all(source != target for source, target in zip(found["source"], found["target"], strict=True))


@pytest.mark.parametrize(
    "text",
    [
        "nest.Create('lin_rate_ipn')",
        "nest.Create('iaf_psc_alpha', params={'tau_x': 1.0})",
        "cell = nest.Create('iaf_psc_alpha')\nnest.Connect(cell, cell, syn_spec='clopath_synapse')",
        "nest.Connect(nest.Create('iaf_psc_alpha'), nest.Create('iaf_psc_alpha'), {'rule': 'conngen'})",
        "meter = nest.Create('multimeter', params={'record_from': ['g_ex']})\n"
        "nest.Connect(meter, nest.Create('iaf_psc_delta'))\nnest.Simulate(1.0)",
        "nest.Simulate(1.0)\nnest.Create('iaf_psc_alpha')",
        "cell = nest.Create('iaf_psc_alpha')\nnest.Simulate(1.0)\ncell.V_m = -60.0",
        "nest.Create('iaf_psc_exp')\nnest.Create('iaf_psc_exp_ps')\nnest.Simulate(1.0)",
        "cell = nest.Create('glif_psc', params={'tau_syn': [2.0, 5.0]})\n"
        "nest.Connect(cell, cell, syn_spec={'receptor_type': 3})\nnest.Simulate(1.0)",
        "nest.Create('glif_psc', 2, [{'tau_syn': [2.0, 5.0]}, {'tau_syn': [2.0]}])\nnest.Simulate(1.0)",
        "spikes = {'spike_times': [1.0, 2.0], 'spike_weights': [1.0, 3.0]}\n"
        "source = nest.Create('spike_generator', params=spikes)\n"
        "nest.Connect(source, nest.Create('iaf_psc_exp'))\nnest.Simulate(1.0)",
        "cells = nest.Create('hh_psc_alpha_gap', 2)\n"
        "nest.Connect(cells[0], cells[1], syn_spec='gap_junction')\nnest.Simulate(1.0)",
        "cell = nest.Create('iaf_tum_2000', params={'delta': 1.0})\n"
        "nest.Connect(cell, cell, syn_spec={'receptor_type': 1})\nnest.Simulate(1.0)",
        "nest.SonataNetwork('config.json')",
    ],
)
def test_what_is_not_supported_is_refused_with_its_line(tmp_path: Path, golden: Golden, text: str) -> None:
    path = tmp_path / "script.py"
    path.write_text(f"import nest\n{text}\n")
    with golden.raises(NrpError, match="nest") as caught:
        run_script(path)
    assert caught.value.line == 1 + len(text.splitlines())


def test_precise_cells_fire_between_grid_points_at_the_times_of_the_membrane_equation(run: Run) -> None:
    found = run(
        "import nest\n"
        "nest.resolution = 1.0\n"
        "cell = nest.Create('iaf_psc_exp_ps', params={'I_e': 700.0})\n"
        "spikes = nest.Create('spike_recorder')\n"
        "nest.Connect(cell, spikes)\n"
        "nest.Simulate(60.0)\n"
        "times = spikes.events['times']\n"
    )
    rises = 10.0 * log(28.0 / (28.0 - 15.0))  # from E_L to 15 mV above it, towards 28 mV
    assert found["times"] == pytest.approx(rises + (rises + 2.0) * np.arange(6), abs=1e-6)


def test_a_stochastic_cell_fires_at_its_hazard_and_refractory_period(run: Run) -> None:
    found = run(
        "import nest\n"
        "cells = nest.Create('gif_psc_exp', 200, {'lambda_0': 100.0, 'Delta_V': 1e9, 't_ref': 4.0})\n"
        "spikes = nest.Create('spike_recorder')\n"
        "nest.Connect(cells, spikes)\n"
        "nest.Simulate(700.0)\n"
        "count = spikes.n_events\n"
    )
    assert found["count"] == pytest.approx(200 * 700.0 / (4.0 + 10.0), rel=0.04)


@pytest.mark.heavy
def test_a_generalised_cell_fires_at_the_rate_of_the_membrane_equation(run: Run) -> None:
    found = run(
        "import nest\n"
        "cell = nest.Create('glif_psc', params={'C_m': 100.0, 'g': 10.0, 'E_L': -70.0, 'V_m': -70.0,\n"
        "                   'V_reset': -70.0, 'V_th': -55.0, 't_ref': 3.0, 'tau_syn': [2.0, 5.0]})\n"
        "source = nest.Create('dc_generator', params={'amplitude': 280.0})\n"
        "nest.Connect(source, cell, syn_spec={'delay': 0.1})\n"
        "spikes = nest.Create('spike_recorder')\n"
        "nest.Connect(cell, spikes)\n"
        "nest.Simulate(100.0)\n"
        "times = spikes.events['times']\n"
    )
    between = 10.0 * log(28.0 / (28.0 - 15.0)) + 3.0
    assert np.diff(found["times"]) == pytest.approx(between, abs=0.2)


def test_a_cell_of_iaf_tum_2000_depresses_its_synapses_as_tsodyks_synapse_does(run: Run) -> None:
    found = run(
        "import nest\n"
        "own = {'U': 0.6, 'tau_rec': 300.0, 'tau_fac': 0.0, 'tau_psc': 2.0}\n"
        "traces = []\n"
        "for model, more, synapse in [\n"
        "    ('iaf_tum_2000', {**own, 'x': 1.0}, {'receptor_type': 1}),\n"
        "    ('iaf_psc_exp', {}, {'synapse_model': 'tsodyks_synapse', **own}),\n"
        "]:\n"
        "    nest.ResetKernel()\n"
        "    first, second = nest.Create(model, 1, {'I_e': 500.0, **more}), nest.Create('iaf_psc_exp')\n"
        "    nest.Connect(first, second, syn_spec={'weight': 100.0, 'delay': 1.0, **synapse})\n"
        "    meter = nest.Create('voltmeter')\n"
        "    nest.Connect(meter, second)\n"
        "    nest.Simulate(100.0)\n"
        "    traces.append(meter.events['V_m'])\n"
    )
    first, second = found["traces"]
    assert first == pytest.approx(second, abs=1e-9)
    assert np.ptp(first) > 0.1


def test_parrots_repeat_every_spike_of_a_poisson_generator(run: Run) -> None:
    found = run(
        "import nest\n"
        "source, relays = nest.Create('poisson_generator', params={'rate': 1e5, 'start': 10.0}), "
        "nest.Create('parrot_neuron', 2)\n"
        "spikes = nest.Create('spike_recorder')\n"
        "nest.Connect(source, relays, syn_spec={'delay': 2.0})\n"
        "nest.Connect(relays, spikes)\n"
        "nest.Simulate(112.0)\n"
        "events = spikes.events\n"
        "source.rate = 0.0\n"
        "nest.Simulate(10.0)\n"
        "then = spikes.n_events\n"
    )
    assert set(found["events"]["senders"].tolist()) == {2, 3}
    assert len(found["events"]["times"]) == pytest.approx(2e4, rel=0.04)
    assert found["events"]["times"].min() >= 12.0
    assert found["then"] == len(found["events"]["times"])


def test_the_weight_of_the_spikes_of_a_generator_multiplies_that_of_its_synapses(run: Run) -> None:
    found = run(
        "import nest\n"
        "rises = []\n"
        "for given, weight in ((), 60.0), ([3.0], 20.0):\n"
        "    nest.ResetKernel()\n"
        "    source = nest.Create('spike_generator', params={'spike_times': [1.0], 'spike_weights': given})\n"
        "    cell, meter = nest.Create('iaf_psc_exp'), nest.Create('voltmeter')\n"
        "    nest.Connect(source, cell, syn_spec={'weight': weight})\n"
        "    nest.Connect(meter, cell)\n"
        "    nest.Simulate(10.0)\n"
        "    rises.append(meter.events['V_m'].tolist())\n"
    )
    assert found["rises"][0] == found["rises"][1]
    assert max(found["rises"][0]) > -69.9


def test_a_script_that_imports_nest_builds_the_brain_of_an_experiment(tmp_path: Path) -> None:
    path = tmp_path / "brain.py"
    path.write_text(
        "import nest\n"
        "eyes = nest.Create('poisson_generator', 2)\n"
        "cells = nest.Create('iaf_cond_alpha', 3, {'V_m': nest.random.uniform(-70.0, -60.0)})\n"
        "nest.Connect(eyes, cells, syn_spec={'weight': 1.5})\n"
    )
    one, same, other = (load_network(path, seed=seed) for seed in (1, 1, 2))
    assert one.views["cells"].tolist() == [0, 1, 2]
    assert one.digest == same.digest != other.digest
    voltages = one.populations["iaf_cond_alpha"].initial_values["v"]
    assert ((voltages > -70) & (voltages < -60)).all()
    assert len(set(voltages.tolist())) == 3


def test_currents_of_a_brain_begin_after_the_delay_of_their_synapse(tmp_path: Path, golden: Golden) -> None:
    path = tmp_path / "brain.py"
    text = (
        "import nest\n"
        "cells = nest.Create('iaf_psc_exp', 2)\n"
        "source = nest.Create('{}', params={{'start': 2.0, 'stop': 5.0}})\n"
        "source.set({})\n"
        "nest.Connect(source, cells, syn_spec={{'weight': 2.0, 'delay': 1.5}})\n"
    )
    path.write_text(text.format("dc_generator", "amplitude=100.0"))
    (current,) = load_network(path).currents
    assert current.neurons.tolist() == [0, 1]
    assert current.times_ms == pytest.approx([3.5, 6.5])
    assert current.amplitudes_na == pytest.approx([0.2, 0.0])
    path.write_text(text.format("noise_generator", "std=100.0"))
    with golden.raises(NetworkError, match="noise_generator"):
        load_network(path)


def test_the_command_takes_a_backend_and_options(tmp_path: Path) -> None:
    path = tmp_path / "script.py"
    path.write_text(
        "import sys\nimport nest\ncell = nest.Create('iaf_psc_delta', params={'I_e': 500.0})\n"
        "heard = nest.Create('spike_recorder')\nnest.Connect(cell, heard)\nnest.Simulate(50.0)\n"
        "print(heard.events['times'][0], sys.argv[1:])\n"
    )
    command = [sys.executable, "-m", "nrp_core.pynn", "--as", "nest", "--backend", "event", "--option"]
    done = subprocess.run(
        [*command, "resolution=1ms", str(path), "mine"], capture_output=True, text=True, check=True
    )
    assert done.stdout == "14.0 ['mine']\n"  # 10 ms * ln(20 / (20 - 15)) is 13.86 ms


def test_a_script_of_pynn_that_imports_nest_is_told_how_to_run(tmp_path: Path) -> None:
    from nrp_core.pynn.__main__ import main

    path = tmp_path / "script.py"
    path.write_text("import nest\n")
    with pytest.raises(SystemExit, match="--as nest"):
        main([str(path)])


def test_stdp_without_an_equivalent_is_refused(run: Run) -> None:
    with pytest.raises(NetworkError, match="mu"):
        run(
            "import nest\n"
            "cells = nest.Create('iaf_psc_alpha', 2)\n"
            "nest.Connect(cells[0], cells[1], syn_spec={'synapse_model': 'stdp_synapse', 'mu_plus': 0.4})\n"
            "nest.Simulate(1.0)\n"
        )


def test_a_script_in_python_2_runs_as_one(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    run("import nest\nnest.Simulate(3 / 2 * 4.0)\nprint 'ran', nest.biological_time\n")
    assert capsys.readouterr().out == "ran 4.0\n"
