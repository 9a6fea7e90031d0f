"""A script of Brian2 as a network that any backend with equations runs: Brian2's spikes and states."""

import runpy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nrp_core import brains
from nrp_core.brain import SpikeInjector, SpikeRecorder
from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.experiment import network_from

from nrp_brain_brian2.runner import run_script

Script = Callable[[str], Path]
START = """
from brian2 import *
prefs.codegen.target = "numpy"
np.random.seed(4)
taum, taue, Vt, El = 20*ms, 5*ms, -50*mV, -49*mV
"""
NETWORK = """
eqs = '''dv/dt = (ge - (v - El))/taum : volt (unless refractory)
dge/dt = -ge/taue : volt
drive = 2*mV*sin(2*pi*30*Hz*t) : volt
du/dt = (a*(v - El) + drive - u)/(9*ms) : volt
a : 1'''
reset = 'v = -60*mV; u += 2*mV'
cells = NeuronGroup(30, eqs, threshold='v > Vt', reset=reset, refractory=3.3*ms, method='METHOD')
cells.v = '-60*mV + rand()*12*mV'
cells.a = 'i/30.0'
plain = NeuronGroup(5, 'dx/dt = (1.2 - x)/(8*ms) : 1', threshold='x > 1', reset='x = 0', method='euler')
plain.x = 'rand()'
given = SpikeGeneratorGroup(2, [0, 1, 0], [3, 3.26, 20]*ms)
inner = Synapses(cells[:20], cells, 'w : volt', on_pre='ge += w')
inner.connect('i != j', p=0.4)
inner.w = 'rand()*4*mV'
inner.delay = 'rand()*2*ms'
braking = Synapses(cells[20:], cells, on_pre='v -= 1.5*mV', delay=0.7*ms)
braking.connect(p=0.5)
kicks = Synapses(given, plain, on_pre='x_post += 0.3')
kicks.connect()
shunts = Synapses(cells, plain, on_pre='x -= 0.01')
shunts.connect()
spikes, simple = SpikeMonitor(cells), SpikeMonitor(plain)
rates = PopulationRateMonitor(cells)
trace = StateMonitor(cells, ('ge', 'u'), record=[2, 25])
run(60*ms)
cells.a = 0.5
run(40*ms)
"""


@pytest.mark.parametrize("method", ["euler", pytest.param("exponential_euler", marks=pytest.mark.slow)])
def test_spikes_and_states_are_those_of_brian2(tmp_path: Path, method: str) -> None:
    path = tmp_path / "script.py"
    path.write_text(START + NETWORK.replace("METHOD", method))
    ours, own = vars(run_script(path)), runpy.run_path(str(path), run_name="__main__")
    for name in ("spikes", "simple"):
        found, expected = (one[name] for one in (ours, own))
        assert expected.num_spikes > 20
        assert np.array(found.i).tolist() == np.array(expected.i).tolist()
        np.testing.assert_allclose(found.t_[:], expected.t_[:], atol=1e-12)
    np.testing.assert_allclose(ours["trace"].u_[:], own["trace"].u_[:], rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(ours["rates"].rate_[:], own["rates"].rate_[:], rtol=1e-9)
    np.testing.assert_allclose(ours["cells"].v_[:], own["cells"].v_[:], rtol=1e-6)


def test_an_experiment_names_the_groups_and_drives_their_cells(tmp_path: Path) -> None:
    path = tmp_path / "script.py"
    path.write_text(START + NETWORK.replace("METHOD", "euler"))
    network = network_from(path)
    assert list(network.populations) == ["cells", "plain", "given"]
    backend = brains().load("event")
    options = backend.options.model_validate({"resolution": "0.1 ms"})
    with backend.open(network, seed=1, options=options) as brain:
        injector = brain.add_source(SpikeInjector(weight=400.0, delay=0.1), [3], name="kick")
        recorder = brain.add_sink(SpikeRecorder(), np.arange(30), name="spikes")
        injector.inject_spikes(times_ms=1.0)
        brain.run_until(6_000_000)
        assert 3 in recorder.spikes().neurons


def test_a_brain_with_another_step_is_refused_with_both_steps(tmp_path: Path) -> None:
    path = tmp_path / "script.py"
    path.write_text(f"{START}cells = NeuronGroup(2, 'dv/dt = -v/taum : 1', method='euler')\nrun(1*ms)\n")
    network, backend = network_from(path), brains().load("event")
    options = backend.options.model_validate({"resolution": "0.05 ms"})
    with pytest.raises(CapabilityError, match=r"0\.05 ms.*'cells'.*0\.1 ms"):
        backend.open(network, seed=1, options=options)
    equations = network.populations["cells"].equations
    assert equations is not None
    assert equations.step_ms == 0.1
    assert type(equations).from_data(equations.data()) == equations


def test_int_truncates_in_cells_as_in_synapses(tmp_path: Path) -> None:
    path = tmp_path / "script.py"
    path.write_text(
        f"{START}cells = NeuronGroup(4, 'dx/dt = int(3*a)*Hz : 1\\na : 1', method='euler')\n"
        "cells.a = [-1.1, -0.2, 0.9, 1.1]\nrun(5*ms)\n"
    )
    np.testing.assert_allclose(vars(run_script(path))["cells"].x[:], 5e-3 * np.array([-3, 0, 2, 3]))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("given.set_spikes([1], [7]*ms)", "spike times of 'given'"),
        ("kicks.delay = 2*ms", "delays of 'given→plain"),
        ("kicks.connect(i=0, j=1)", "cells of 'given→plain"),
        ("more = Synapses(given, plain, on_pre='x_post += 0.1')\nmore.connect()", "synapses are added"),
    ],
)
def test_what_a_brain_cannot_change_between_runs_is_refused(tmp_path: Path, change: str, told: str) -> None:
    path = tmp_path / "script.py"
    path.write_text(
        f"{START}plain = NeuronGroup(2, 'dx/dt = -x/taum : 1', method='euler')\n"
        "given = SpikeGeneratorGroup(2, [0, 1], [0.3, 6]*ms)\n"
        "kicks = Synapses(given, plain, on_pre='x_post += 1')\nkicks.connect()\n"
        f"run(1*ms)\n{change}\nrun(1*ms)\n"
    )
    with pytest.raises(CapabilityError, match=told):
        run_script(path)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ("cells = NeuronGroup(2, 'dv/dt = -v/ms + xi/ms**.5 : 1', method='euler')", "noise, xi"),
        ("cells = NeuronGroup(2, 'v : 1')\ncells.run_regularly('v += 1')", "no equivalent"),
        ("cells = NeuronGroup(2, 'v : 1', threshold='v > 1', events={'low': 'v < 0'})", "low"),
        (
            "cells = NeuronGroup(2, 'v : 1', threshold='v > 1', reset='v = 0')\n"
            "syn = Synapses(cells, cells, 'w : 1', on_pre='v += w; w += 1')\nsyn.connect()",
            "'w = ",
        ),
        ("cells = PoissonGroup(2, 'TimedArray'[:0] or '(1 + t/second)*Hz')", "change with the time"),
    ],
)
def test_what_cells_in_equations_cannot_say_is_refused_by_name(tmp_path: Path, more: str, told: str) -> None:
    path = tmp_path / "script.py"
    path.write_text(f"{START}{more}\nrun(1*ms)\n")
    with pytest.raises((CapabilityError, NetworkError), match=told):
        network_from(path)
