"""Scripts for the Virtual Coach run unchanged, with plain Python; ``nrp run`` says what they must find."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest
from hbp_nrp_virtual_coach.__main__ import main
from nrp_experiments import braitenberg_husky

from nrp_core.cli import app

SCRIPTS = Path(__file__).with_name("coach_scripts")

Ran = Callable[..., str]

SPIKES = """import hbp_nrp_client.tf_framework as nrp


@nrp.MapCSVRecorder("recorder", filename="all_spikes.csv", headers=["id", "time"])
@nrp.MapSpikeSink("spikes", nrp.brain.actors, nrp.spike_recorder)
@nrp.Robot2Neuron()
def all_spikes(t, recorder, spikes):
    for neuron, time in spikes.times:
        recorder.record_entry(neuron, time)
"""


@pytest.fixture
def ran(corpus: Path, tmp_path: Path) -> Ran:
    """Runs a program in an empty folder and returns its output."""

    def run(*command: str | Path, **variables: str) -> str:
        folders = {"NRP_EXPERIMENTS": str(corpus), "NRP_MODELS": str(corpus / "models"), "NRP_PACE": "max"}
        done = subprocess.run(
            [str(part) for part in command], cwd=tmp_path, env={**os.environ, **folders, **variables},
            capture_output=True, text=True, check=False, timeout=300,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def nrp_run(corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Runs an experiment by ``nrp run``, in this process and in an empty folder."""

    def run(*arguments: str | Path) -> None:
        assert app.run_app(["run", *map(str, arguments)]) == 0

    monkeypatch.setenv("NRP_MODELS", str(corpus / "models"))
    monkeypatch.chdir(tmp_path)
    return run


@pytest.mark.heavy
@pytest.mark.slow
def test_a_status_callback_ends_a_trial_at_its_second(
    ran: Ran, warm: Path, nrp_run: Callable[..., None], corpus: Path, tmp_path: Path
) -> None:
    experiment = corpus / "p3dx_2018"
    nrp_run(experiment, "--allow-incomplete", "--until", "1s", "-s", "duration=2 s")
    expected = (experiment / "csv" / "spikes.csv").read_text()
    assert expected.count("\n") > 100
    said = ran(warm / "python", SCRIPTS / "trial.py", tmp_path, NRP_SET="duration=2s")
    assert (tmp_path / "spikes.csv").read_text() == expected
    assert "p3dx_2018\n" in said
    assert (experiment / "csv" / "run_0" / "spikes.csv").read_text() == expected


@pytest.fixture
def ran_here(
    corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Ran:
    """Runs a script in this process, which starts sooner, and returns its output."""

    def run(script: str, **variables: str) -> str:
        folders = {"NRP_EXPERIMENTS": str(corpus), "NRP_MODELS": str(corpus / "models"), "NRP_PACE": "max"}
        for name, value in {**folders, **variables}.items():
            monkeypatch.setenv(name, value)
        monkeypatch.chdir(tmp_path)
        capsys.readouterr()
        main([str(SCRIPTS / script)])
        return capsys.readouterr().out

    return run


@pytest.mark.heavy
def test_generations_edit_functions_and_reset(ran_here: Ran) -> None:
    said = ran_here("generations.py", NRP_SET="duration=60s", NRP_PACE="realtime")
    generations = [[float(word) for word in line.split()] for line in said.splitlines()]
    assert [gain for gain, _, _ in generations] == [0.25, 0.5]
    for gain, time, speed in generations:
        assert 1.0 <= time < 20.0
        assert speed == pytest.approx(gain * time)  # of this step: what was added runs last


@pytest.mark.slow
def test_a_script_of_python_2_speaks_to_each_simulation_by_rospy(
    ran: Ran, warm: Path, tmp_path: Path
) -> None:
    said = ran(
        warm / "python", "-m", "hbp_nrp_virtual_coach", SCRIPTS / "topics.py", tmp_path,
        NRP_SET="duration=600s",
    )  # fmt: skip
    assert said.splitlines() == [
        "put at 0.25", "True True", "['one', 'two', 'one'] True seen at 0.25",
        "put at 0.50", "True True", "['one', 'two', 'one'] True seen at 0.50",
    ]  # fmt: skip
    assert (tmp_path / "rows.csv").read_text() == "trials,2\n"


def test_rospy_of_a_script_stays_within_it_and_knows_no_simulation_before_a_launch(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "alone.py"
    script.write_text(
        "import rospy\nfrom std_srvs.srv import Empty\nprint(rospy.get_time())\nrospy.sleep(100.0)\n"
        "rospy.Publisher('/a', rospy.AnyMsg).publish()\n"
        "try:\n    rospy.ServiceProxy('/gazebo/pause_physics', Empty)()\n"
        "except rospy.ServiceException as error:\n    print(error)\n"
    )
    before = set(sys.modules)
    main([str(script)])
    assert capsys.readouterr().out == (
        "0.0\nservice /gazebo/pause_physics is available only while a simulation is open\n"
    )
    assert not {"rospy", "std_srvs", "std_srvs.srv"} & (set(sys.modules) - before)
    with pytest.raises(SystemExit):
        main([str(tmp_path / "none.py")])
    assert f"there is no file {tmp_path / 'none.py'}" in capsys.readouterr().err


def test_an_installed_experiment_runs_with_a_function_more(
    ran_here: Ran, nrp_run: Callable[..., None], tmp_path: Path
) -> None:
    (tmp_path / "spikes.py").write_text(SPIKES)
    small = "duration=1s world.options.image_scale=0.25"
    said = ran_here("shipped.py", NRP_SET=small)
    folder = Path(str(braitenberg_husky.__file__)).parent
    files = f"{folder}/listing1.py, {folder}/listing2.py, spikes.py"
    (tmp_path / "twin.yaml").write_text(
        f"{{extends: braitenberg_husky/no_red, transfer_functions: [{files}]}}"
    )
    nrp_run(tmp_path / "twin.yaml", *(part for one in small.split() for part in ("-s", one)))
    assert said == (tmp_path / "csv" / "all_spikes.csv").read_text()
    assert said.count("\n") > 10


NEWER = "from pynrp.virtual_coach import VirtualCoach\nprint(VirtualCoach)\n"


def test_an_installed_pynrp_is_never_shadowed(ran: Ran, tmp_path: Path) -> None:
    package = tmp_path / "site" / "pynrp"
    package.mkdir(parents=True)
    (package / "__init__.py").touch()
    (package / "virtual_coach.py").write_text("VirtualCoach = 'theirs'\n")
    (tmp_path / "script.py").write_text(NEWER)
    command = sys.executable, "-m", "hbp_nrp_virtual_coach", tmp_path / "script.py"
    assert ran(*command, PYTHONPATH=str(package.parent)) == "theirs\n"


def test_the_newer_name_is_ours_only_in_scripts_that_the_coach_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "script.py").write_text(NEWER)
    main([str(tmp_path / "script.py")])
    assert capsys.readouterr().out == "<class 'hbp_nrp_virtual_coach.virtual_coach.VirtualCoach'>\n"
    assert find_spec("pynrp") is None


@pytest.mark.slow
def test_a_script_that_ends_early_ends_its_simulation(ran: Ran, warm: Path, corpus: Path) -> None:
    script = """if True:
        from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach
        VirtualCoach().launch_experiment('p3dx_2018').start()"""
    ran(warm / "python", "-c", script, NRP_SET="duration=600s", NRP_PACE="realtime")
    assert (
        (corpus / "p3dx_2018" / "csv" / "run_0" / "spikes.csv")
        .read_text()
        .startswith("id,time,Simulation_reset\n")
    )


SERVED = """
import rospy
from std_srvs.srv import SetBool, SetBoolResponse, Trigger
learning = {"on": "not yet", "heard": ""}

def learn(request):
    before, learning["on"] = learning["on"], request.data
    return SetBoolResponse(True, "%s %s" % (before, learning["heard"]))

service = rospy.Service("/learn", SetBool, learn)
reward = rospy.ServiceProxy("/reward", Trigger)

@nrp.Robot2Neuron()
def hear(t):
    learning["heard"] = reward().message
"""


def test_services_of_the_experiment_and_of_the_script_reach_each_other(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    folder = tmp_path / "served"
    folder.mkdir()
    (folder / "tf.py").write_text(SERVED)
    (folder / "x.bibi").write_text('<bibi><transferFunction src="tf.py"/></bibi>')
    (folder / "x.exc").write_text('<ExD><timeout>600</timeout><bibiConf src="x.bibi"/></ExD>')
    monkeypatch.setenv("NRP_EXPERIMENTS", str(tmp_path))
    monkeypatch.setenv("NRP_PACE", "realtime")
    caplog.clear()
    main([str(SCRIPTS / "services.py")])
    assert "nothing subscribes to '/nobody/hears', so its commands have no effect" in caplog.text
    assert capsys.readouterr().out.splitlines() == [
        "not yet ", "True reward 0",
        "not yet ", "False reward 1",
        "service /learn is available only while a simulation is open",
    ]  # fmt: skip
