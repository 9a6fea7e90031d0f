"""``python -m nrp_core.pynn`` runs scripts of PyNN's own style, in the backend that it is given."""

import sys
from collections.abc import Callable
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

import pytest

from nrp_core.pynn.__main__ import main

Run = Callable[..., str]

SCRIPT = """\
import pyNN.nest as sim
sim.setup(timestep=0.1, options={options})
cell = sim.Population(1, sim.IF_curr_exp(i_offset=1.5))
cell.record("spikes")
sim.run(20.0)
print(cell.get_data("spikes", clear="true").segments[0].spiketrains[0].magnitude[0])
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "argv", [])
    monkeypatch.delitem(sys.modules, "pyNN.nrp", raising=False)

    def output(script: str, *options: str) -> str:
        path = tmp_path / "script.py"
        path.write_text(script)
        main([*options, str(path)])
        return capsys.readouterr().out

    return output


def test_options_of_the_command_line_are_those_of_the_backend(run: Run) -> None:
    """The spike is at ``tau_m ln 2`` for a current of twice the rheobase, and on the next point of a grid."""
    script = SCRIPT.format(options="None")
    assert float(run(script)) == pytest.approx(13.8629436)
    assert float(run(script, "--option", "resolution=1ms")) == 14.0
    assert float(run(script, "--backend", "spinnaker", "--option", "timestep=1ms")) == 14.0


def test_options_of_the_command_line_replace_those_of_the_script(run: Run) -> None:
    script = SCRIPT.format(options={"resolution": "0.5 ms"})
    assert float(run(script)) == 14.0
    assert float(run(script, "--option", "resolution=0.1ms")) == pytest.approx(13.9)


@pytest.mark.parametrize(
    ("simulator", "cell", "setup", "spike_ms", "how"),
    [
        ("nest", "IF_cond_exp", "timestep=1.0", 14.0, "in steps of 1 ms, as pyNN.nest does"),
        ("nest", "IF_curr_exp", "timestep=1.0", 13.8629436, "with exact spike times, as pyNN.nest has them"),
        ("nest", "IF_curr_exp", "timestep=1.0, spike_precision='on_grid'", 14.0, "in steps of 1 ms"),
        ("brian2", "IF_curr_exp", "timestep=0.5", 14.0, "in steps of 0.5 ms, as pyNN.brian2 does"),
        ("neuron", "IF_curr_exp", "use_cvode=True", 13.8629436, "with exact spike times, as pyNN.neuron has"),
        ("neuron", "IF_curr_exp", "timestep=2.0", 13.8629436, "pyNN.neuron has steps of 2 ms"),
        ("nest", "IF_cond_exp", "options={'tolerance': 1e-8}", 13.8629436, "with the chosen options"),
    ],
)
def test_a_script_has_the_steps_of_the_simulator_that_it_imports(
    run: Run, simulator: str, cell: str, setup: str, spike_ms: float, how: str
) -> None:
    script = SCRIPT.replace("nest", simulator).replace("IF_curr_exp", cell)
    script = script.replace("timestep=0.1, options={options}", setup)
    with redirect_stderr(StringIO()) as printed:
        assert float(run(script)) == pytest.approx(spike_ms)
    assert printed.getvalue().count(how) == 1
    assert float(run(script, "--option", "resolution=exact")) == pytest.approx(13.8629436)


STEPS = """\
import pyNN.nest as sim
sim.setup(timestep=1.0, min_delay=1.0)
cell = sim.Population(1, sim.IF_curr_exp(i_offset=1.5, tau_refrac={refractory_ms}))
source = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0]))
driven = sim.Population(1, sim.IF_curr_exp())
late = sim.FromListConnector([(0, 0, 1e6, {delay_ms})])
sim.Projection(source, driven, late, sim.StaticSynapse())
(cell + driven).record("spikes")
sim.run(40.0)
first, second = cell.get_data().segments[0].spiketrains[0].magnitude[:2]
print(second - 2 * first, driven.get_data().segments[0].spiketrains[0].magnitude[0] - 10.0)
"""
"""Of a regular neuron the refractory period, of another the time that a strong input takes, is printed."""


@pytest.mark.parametrize(
    ("refractory_ms", "in_nest_ms"),
    [(0.1, 1.0), (1.0, 1.0), (1.2, 2.0), (2.25, 3.0), (3.0 * (1 + 1e-15), 3.0)],
)
@pytest.mark.parametrize(("delay_ms", "delay_in_nest_ms"), [(1.4, 1.0), (1.5, 2.0), (2.5, 3.0)])
def test_refractory_periods_and_delays_of_nest_are_whole_steps_where_its_spikes_are_exact(
    run: Run, refractory_ms: float, in_nest_ms: float, delay_ms: float, delay_in_nest_ms: float
) -> None:
    """NEST 3.10 through PyNN 0.13 has these; it lengthens the first, and takes the nearest of the second."""
    script = STEPS.format(refractory_ms=refractory_ms, delay_ms=delay_ms)
    expected = [in_nest_ms, delay_in_nest_ms]
    assert [float(value) for value in run(script).split()] == pytest.approx(expected, abs=1e-4)
    exact = run(script, "--option", "resolution=exact")
    assert [float(value) for value in exact.split()] == pytest.approx([refractory_ms, delay_ms], abs=1e-4)


def test_a_script_that_imports_this_simulator_has_exact_times(run: Run) -> None:
    script = SCRIPT.replace("pyNN.nest", "nrp_core.pynn").replace("0.1, options={options}", "1.0")
    assert float(run(script)) == pytest.approx(13.8629436)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--option", "resolution"], "an option is written NAME=VALUE"),
        (["--option", "threads=1", "--option", "threads=2"], "given twice"),
        (["--backend", "event", "--as", "spinnaker"], "--as spinnaker chooses the backend"),
        (["--backend", "evnet"], "no brain backend is called 'evnet'; did you mean 'event'"),
    ],
)
def test_a_wrong_option_is_one_error(
    run: Run, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        run(SCRIPT.format(options="None"), *options)
    assert message in f"{ended.value} {capsys.readouterr().err}"


def test_a_submodule_of_the_library_is_imported_by_name(run: Run) -> None:
    assert run("from pyNN.utility import build\nfrom pyNN import utility\nprint(build.__name__)\n")


def test_a_script_in_python_2_runs(run: Run) -> None:
    script = SCRIPT.format(options="None").replace("print(", "print ").rstrip(")\n")
    assert float(run(script)) == pytest.approx(13.8629436)
