"""Faults that owners of old experiments met: each runs as it ran on the platform."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_legacy.brains import load_script
from nrp_legacy.documents import FileNamed
from nrp_legacy.files import Library
from nrp_legacy.reader import read_exc
from recorded import rows
from scipy.integrate import solve_ivp

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import VoltageRecorder
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.xml import parse_xml

GRID: dict[str, Any] = {"resolution": "0.1 ms"}
CELLS = "from hbp_nrp_cle.brainsim import simulator as sim\ncircuit = sim.Population(2, sim.IF_cond_exp())\n"
FUNCTIONS = """
import numpy as np

@nrp.MapCSVRecorder("rows", filename="rows.csv", headers=["t", "n"])
@nrp.Robot2Neuron(throttling_rate={rate})
def sampled(t, rows):
    n = len(np.linspace(0, 1, 10.0)) + len(np.logspace(0, 1, 3.0)) + len(np.geomspace(1, 2, 2.0))
    rows.record_entry(t, n)
"""


@pytest.fixture
def experiment(written: Callable[..., Path]) -> Callable[..., Run]:
    def opened(functions: str) -> Run:
        return Run(read_exc(written(CELLS, functions), ["duration=1 s"]))

    return opened


@pytest.mark.parametrize("rate", [30.0, 50.0, 7.0, 5.0, 10.0, 1000.0])
def test_a_throttled_function_waits_for_its_period_since_the_last_call(
    experiment: Callable[..., Run], rate: float
) -> None:
    # the platform added the steps in floating point, so 5 Hz in steps of 20 ms has gaps of 0.22 and 0.2 s
    expected = [0.0]
    for t in np.cumsum([0.02] * 49):
        expected += [t] if expected[-1] + 1 / rate <= t else []
    with experiment(FUNCTIONS.format(rate=rate)) as run:
        run.run()
        assert [float(t) for t, _ in rows(run, "sampled", "rows")] == pytest.approx(expected)


def test_records_name_resets_and_numbers_of_samples_may_be_floats(
    experiment: Callable[..., Run], tmp_path: Path
) -> None:
    with experiment(FUNCTIONS.format(rate=30.0)) as run:
        run.run()
        assert not run.result().failures
        (path,) = run.write_csv(tmp_path / "csv")
        assert path.read_text().splitlines()[:2] == ["t,n,Simulation_reset", "0.0,15"]
        run.reset("all")
        run.run_until(0.1)
        run.write_csv(tmp_path / "csv", overwrite=True)
    assert [line for line in path.read_text().splitlines() if "RESET" in line] == ["0.0,15,RESET"]


def test_a_selection_cannot_be_initialized_in_a_run(experiment: Callable[..., Run]) -> None:
    functions = (
        "@nrp.Robot2Neuron()\ndef reset(t):\n    nrp.config.brain_root.circuit.initialize(v=-65)\n"
        "@nrp.MapRetina('retina', 'retina.py')\n@nrp.Robot2Neuron()\ndef see(t, retina):\n    pass\n"
    )
    with experiment(functions) as run:
        assert any("MapRetina" in problem.message for problem in run.problems)
    with experiment(functions.partition("@nrp.MapRetina")[0]) as run:
        run.run()
        (failure,) = run.result().failures
        assert "initialize()" in str(failure)


def named(name: str) -> FileNamed:
    return FileNamed.of(parse_xml(f"<it>{name}</it>".encode(), Path("x.bibi"), ValueError))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "there"),
    [
        ("husky_model.zip", "husky_model/model.sdf"),
        ("icub_model/model.sdf", "icub/model.sdf"),
        ("p3dx/pioneer3dx.sdf", "PioneerModel/p3dx/pioneer3dx.xacro"),
        ("p3dx/pioneer3dx.sdf", "description/urdf/pioneer3dx.urdf.xacro"),
    ],
)
def test_a_robot_is_found_where_owners_have_it(tmp_path: Path, name: str, there: str) -> None:
    path = tmp_path / there
    path.parent.mkdir(parents=True)
    path.write_text("<sdf version='1.6'/>")
    assert Library(tmp_path).find_sdf(named(name)) == path.resolve()


def test_the_only_model_of_another_name_is_no_robot(tmp_path: Path) -> None:
    for name in ("room", "icub", "icub_2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "model.sdf").touch()
        if name != "icub":
            assert Library(tmp_path).find_sdf(named("icub_model/model.sdf")) is None


ROBOT = """<sdf version="1.6"><model name="box"><link name="body">
<inertial><mass>2</mass><inertia><ixx>0.02</ixx><iyy>0.02</iyy><izz>0.02</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.4 0.4 0.3</size></box></geometry></collision></link></model>
</sdf>"""
ROOM = """<sdf version="1.6"><world name="w"><model name="floor"><static>1</static><link name="l">
<collision name="c"><geometry>{floor}</geometry></collision></link></model>
<model name="table"><static>1</static><pose>0 0 2 0 0 0</pose><link name="l">
<collision name="c"><geometry><box><size>1 1 0.1</size></box></geometry></collision></link></model></world>
</sdf>"""
PLANE, SLAB = "<plane><normal>0 0 1</normal></plane>", "<box><size>9 9 0.2</size></box>"


@pytest.mark.parametrize(("floor", "top"), [(PLANE, 0.0), (SLAB, 0.1)])
def test_a_robot_in_the_floor_is_lifted_onto_it(tmp_path: Path, floor: str, top: float) -> None:
    (tmp_path / "box.sdf").write_text(ROBOT)
    (tmp_path / "room.sdf").write_text(ROOM.format(floor=floor))
    (tmp_path / "x.bibi").write_text("<bibi><bodyModel robotId='box'>box.sdf</bodyModel></bibi>")
    pose = f'<robotPose robotId="box" x="0" y="0" z="{top}" roll="0" pitch="0" yaw="0"/>'
    room = f'<environmentModel src="room.sdf">{pose}</environmentModel>'
    (tmp_path / "x.exc").write_text(f'<ExD>{room}<bibiConf src="x.bibi"/></ExD>')
    with Run(read_exc(tmp_path / "x.exc", ["duration=1 s"])) as run:
        (told,) = [one for one in run.problems if "lifted" in one.message]
        assert told.code is Code.NRP204
        heights = [run.world.model_motion("box").pose.position[2]]
        for t_s in (0.1, 0.2, 0.3):
            run.run_until(t_s)
            heights.append(run.world.model_motion("box").pose.position[2])
        assert heights == pytest.approx([top + 0.15] * 4, abs=2e-3)


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("model", "receptor", "end"),
    [("iaf_cond_exp_cs", "COMPLEX_SPIKE", "cs"), ("iaf_cond_exp_cos", "TEACHING_SIGNAL", "ts")],
)
def test_a_cerebellar_cell_has_a_third_receptor(tmp_path: Path, model: str, receptor: str, end: str) -> None:
    (tmp_path / "b.py").write_text(f"""
import pyNN.nest as sim
sim.setup(timestep=0.1)
spikes = sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0]))
cells = sim.native_cell_type("{model}")
circuit = sim.Population(1, cells(tau_syn_{end}=4.0, e_{end}=-20.0, V_th=0.0))
for receptor, weight in (("{receptor}", 0.01), ("AMPA", 0.02), ("GABA", 0.005)):
    sim.Projection(spikes, circuit, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight, delay=1.0),
                   receptor_type=receptor)
""")
    network = load_script(tmp_path / "b.py", 1)
    backend = brains().load("event")
    with backend.open(network, seed=1, options=backend.options(**GRID)) as brain:
        port = brain.add_sink(VoltageRecorder(dt=0.5), network.ids_of(list(network.populations)[1]), name="v")
        brain.run_until(40_000_000)
        times_ms, values = port.samples()  # type: ignore[attr-defined]

    def slope(t: float, v: np.ndarray) -> np.ndarray:
        on = t >= 6.0
        own, ampa, gaba = (
            on * g * np.exp(-max(t - 6.0, 0.0) / tau) for g, tau in ((10, 4.0), (20, 0.2), (5, 2.0))
        )
        return np.asarray((16.6667 * (-70 - v) + own * (-20 - v) + ampa * (0 - v) + gaba * (-85 - v)) / 250)

    kwargs = {"rtol": 1e-10, "atol": 1e-10, "dense_output": True}
    before = solve_ivp(slope, (0.0, 6.0 - 1e-12), [-70.0], **kwargs)
    after = solve_ivp(slope, (6.0, 40.0), before.y[:, -1], **kwargs)
    expected = [(before if t < 6.0 else after).sol(t)[0] for t in times_ms]
    assert max(expected) > -68.0
    np.testing.assert_allclose(values[:, 0], expected, atol=1e-4)


def test_a_driven_source_fires_at_the_rate_of_its_current(tmp_path: Path) -> None:
    (tmp_path / "b.py").write_text("""
import pyNN.nest as sim
sim.setup(timestep=1.0)
source = sim.native_cell_type("cd_poisson_generator")
circuit = sim.Population(200, source(min_rate=10.0, max_rate=50.0, min_current=0.0, max_current=1000.0))
sim.DCSource(amplitude=0.5).inject_into(circuit)
""")
    network = load_script(tmp_path / "b.py", 1)
    backend = brains().load("event")
    from nrp_core.brain.devices.sinks import SpikeRecorder

    with backend.open(network, seed=1, options=backend.options(**GRID)) as brain:
        port = brain.add_sink(SpikeRecorder(), np.arange(200), name="s")
        brain.run_until(1_000_000_000)
        count = len(port.spikes())  # type: ignore[attr-defined]
    assert count / 200 == pytest.approx(30.0, abs=4 * (30 / 200) ** 0.5)


def test_an_experiment_with_such_cells_runs_on_a_grid(written: Callable[..., Path]) -> None:
    brain = CELLS.replace("sim.IF_cond_exp()", "sim.native_cell_type('iaf_cond_exp_cs')()")
    with Run(read_exc(written(brain, FUNCTIONS.format(rate=30.0)), ["duration=0.1 s"])) as run:
        run.run()
        assert run.brain.capabilities.resolution_ns == 100_000
        assert not run.result().failures


def test_notebooks_and_modules_elsewhere_find_the_coach(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import json

    from hbp_nrp_virtual_coach.script import run_script

    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "of_others.py").write_text("from pynrp.virtual_coach import VirtualCoach as Coach\n")
    monkeypatch.syspath_prepend(tmp_path / "lib")
    cells = [
        {"cell_type": "markdown", "source": ["# a title"], "metadata": {}},
        {
            "cell_type": "code",
            "source": ["%matplotlib inline\n", "from of_others import Coach\n"],
            "outputs": [],
        },
        {
            "cell_type": "code",
            "source": ["coach = Coach(environment='local')\n", "print(coach.print_available_servers())"],
        },
    ]
    (tmp_path / "n").mkdir()
    path = tmp_path / "n" / "script.ipynb"
    path.write_text(json.dumps({"cells": cells, "metadata": {"collapsed": False}, "nbformat": 4}))
    run_script(path)
    assert capsys.readouterr().out.splitlines() == ["localhost", "['localhost']"]


def test_an_archive_without_the_robot_is_no_folder(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "husky_model.zip", "w") as archive:
        archive.writestr("husky/model.sdf", "<sdf version='1.6'/>")
    found = Library(tmp_path).find_sdf(named("husky_model.zip"))
    assert found is not None
    assert found.name == "model.sdf"
