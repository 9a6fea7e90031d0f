"""What the Virtual Coach does to a simulation: functions, machines, brain, records, experiments."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.virtual_coach import VirtualCoach

from nrp_core import Recording
from nrp_core.errors import ExperimentError, LifecycleError
from nrp_core.experiment.running.run import Run

POSE = """@nrp.MapCSVRecorder("recorder", filename="pose.csv", headers=["time", "x"])
@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.Robot2Neuron()
def record_pose(t, recorder, states):
    names = states.value.name if states.value else []
    if "robot" in names:
        recorder.record_entry(t, states.value.pose[names.index("robot")].position.x)
"""
AHEAD = """@nrp.Neuron2Robot(Topic("/robot/p3dx/cmd_vel", geometry_msgs.msg.Twist))
def drive(t):
    return geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0.4, y=0.0, z=0.0))
"""
MACHINE = """import hbp_nrp_excontrol.nrp_states as states
from smach import StateMachine
sm = StateMachine(outcomes=["done", "error", "preempted"])
with sm:
    StateMachine.add("wait", states.ClockDelayState(0.1),
                     transitions={"valid": "wait", "invalid": "paint", "preempted": "preempted"})
    StateMachine.add("paint", states.SetMaterialColorServiceState(
        "left_vr_screen", "body", "screen_glass", "Gazebo/RedGlow"),
        transitions={"succeeded": "done", "aborted": "error", "preempted": "preempted"})
"""

Launched = Callable[..., Simulation]


@pytest.fixture
def coach(corpus: Path, monkeypatch: pytest.MonkeyPatch) -> VirtualCoach:
    monkeypatch.setenv("NRP_MODELS", str(corpus / "models"))
    monkeypatch.setenv("NRP_PACE", "max")
    return VirtualCoach(environment=corpus)


@pytest.fixture
def launched(coach: VirtualCoach, monkeypatch: pytest.MonkeyPatch) -> Iterator[Launched]:
    """Launches an experiment of the corpus, which stops at the end of the test."""
    simulations: list[Simulation] = []

    def launch(name: str = "p3dx_2018", settings: str = "duration=600s") -> Simulation:
        monkeypatch.setenv("NRP_SET", settings)
        simulations.append(coach.launch_experiment(name))
        return simulations[-1]

    yield launch
    for simulation in simulations:
        simulation.stop()


def run_to(simulation: Simulation, time_s: float) -> dict[str, Any]:
    """Run a simulation until a whole second, where it is paused; return its status there."""
    reached: list[dict[str, Any]] = []

    def on_status(status: dict[str, Any]) -> None:
        if not reached and status["simulationTime"] == time_s and status["state"] == "started":
            simulation.pause()
            reached.append(status)

    simulation.register_status_callback(on_status)
    simulation.start()
    while simulation.get_state() == "started":
        time.sleep(0.01)
    return reached[0]


def xs(simulation: Simulation) -> list[float]:
    return [float(row[1]) for row in simulation.get_csv_data("pose.csv")[1:]]


def test_a_pause_in_a_callback_is_exact_and_the_clock_stands_still(launched: Launched) -> None:
    simulation = launched()
    status = run_to(simulation, 1.0)
    assert (status["simulationTime"], status["state"], status["timeout"]) == (1.0, "started", 599.0)
    rows = simulation.get_csv_data("spikes.csv")
    assert simulation.get_state() == "paused"
    time.sleep(0.3)
    assert simulation.get_csv_data("spikes.csv") == rows
    assert max(float(when) for _, when in rows[1:]) <= 1000.0


def test_an_edited_function_acts_and_keeps_its_source_and_the_state(launched: Launched, corpus: Path) -> None:
    simulation = launched()
    simulation.add_transfer_function(POSE)
    assert simulation.get_transfer_function("drive") == (corpus / "p3dx_2018" / "drive.py").read_text()
    simulation.edit_transfer_function("drive", AHEAD)
    assert simulation.get_transfer_function("drive") == AHEAD
    run_to(simulation, 1.0)
    assert xs(simulation)[-1] == pytest.approx(0.4, abs=0.04)  # 0.4 m/s for a second
    simulation.start()
    simulation.edit_transfer_function("drive", AHEAD.replace("0.4", "0.0"))
    assert simulation.get_state() == "started"
    simulation.pause()


def test_an_edit_that_gives_a_function_another_name_says_so(
    launched: Launched, caplog: pytest.LogCaptureFixture, golden: Golden
) -> None:
    simulation = launched()
    simulation.edit_transfer_function("drive", AHEAD)
    assert "is now called" not in caplog.text
    simulation.edit_transfer_function("drive", AHEAD.replace("def drive", "def steer"))
    assert "the transfer function 'drive' is now called 'steer', as in its text" in caplog.text
    with golden.raises(ExperimentError, match="'drive'"):
        simulation.delete_transfer_function("drive")


def test_an_added_function_that_reads_an_unpublished_topic_causes_a_warning(
    launched: Launched, caplog: pytest.LogCaptureFixture
) -> None:
    simulation = launched()
    simulation.add_transfer_function(POSE)
    assert "the world has no topic" not in caplog.text
    wrong = POSE.replace("/gazebo/model_states", "/gazebo/model_stats").replace("record_pose", "record_more")
    simulation.add_transfer_function(wrong)
    assert "the world has no topic '/gazebo/model_stats': it is silent unless a function" in caplog.text


def test_an_edit_that_is_wrong_changes_nothing(launched: Launched, golden: Golden) -> None:
    simulation = launched()
    before = simulation.get_transfer_function("drive")
    for name, source, said in (
        ("drve", AHEAD, "no transfer function 'drve'; did you mean 'drive'"),
        ("drive", "def drive(t:", "neither Python 3 nor Python 2"),
        ("drive", "x = 1\n", "does not declare a transfer function"),
        ("drive", AHEAD.replace("def drive", "def grab_laser"), "function 'grab_laser' already exists"),
        ("drive", AHEAD + "raise ValueError('no')\n", "no"),
    ):
        with pytest.raises(ExperimentError, match=said):
            simulation.edit_transfer_function(name, source)
        assert simulation.get_transfer_function("drive") == before
    with golden.raises(ExperimentError, match="'drive'"):
        simulation.add_transfer_function(AHEAD)
    simulation.delete_transfer_function("drive")
    with golden.raises(ExperimentError, match="'drive'"):
        simulation.get_transfer_function("drive")


def test_saved_functions_are_those_of_the_next_launch(
    launched: Launched, corpus: Path, golden: Golden
) -> None:
    simulation = launched()
    simulation.edit_transfer_function("drive", AHEAD)
    simulation.save_transfer_functions()
    assert (corpus / "p3dx_2018" / "drive.py").read_text() == AHEAD
    assert launched().get_transfer_function("drive") == AHEAD
    simulation.add_transfer_function(POSE)
    with golden.raises(ExperimentError, match="'record_pose'"):
        simulation.save_transfer_functions()


def test_resets_pause_and_bring_back_what_they_name(launched: Launched, golden: Golden) -> None:
    simulation = launched()
    simulation.add_transfer_function(POSE)
    simulation.edit_transfer_function("drive", AHEAD)
    run_to(simulation, 1.0)
    simulation.reset("robot_pose")
    assert simulation.get_state() == "paused"
    run_to(simulation, 2.0)
    path = xs(simulation)
    assert path[-1] == pytest.approx(0.4, abs=0.05)  # of the second that followed the reset
    simulation.start()
    simulation.reset("full")
    assert simulation.get_state() == "paused"
    run_to(simulation, 1.0)
    assert xs(simulation)[-1] == pytest.approx(path[49], abs=1e-9)  # the first second, once more
    simulation.reset("brain")
    assert simulation.get_state() == "paused"
    run_to(simulation, 2.0)
    assert xs(simulation)[-1] > xs(simulation)[49]  # the robot goes on from where it was
    with golden.raises(ExperimentError, match="'ful'.*'full'"):
        simulation.reset("ful")


def test_another_brain_begins_at_zero_with_the_same_functions(
    launched: Launched, caplog: pytest.LogCaptureFixture, golden: Golden
) -> None:
    simulation = launched()
    simulation.edit_transfer_function("drive", AHEAD)
    brain = simulation.get_brain()
    states: list[str] = []
    run_to(simulation, 1.0)
    simulation.register_status_callback(lambda status: states.append(status["state"]))
    simulation.edit_brain(brain + "\nmarked = True\n")
    assert simulation.get_brain().endswith("marked = True\n")
    assert simulation.get_transfer_function("drive") == AHEAD
    with golden.raises(ExperimentError):
        simulation.edit_brain("1/0")
    with golden.raises(ExperimentError, match=r"'brain\.py'"):
        simulation.edit_brain("brain.py")
    assert simulation.get_brain().endswith("marked = True\n")
    assert "stopped" not in states
    assert run_to(simulation, 1.0)["simulationTime"] == 1.0
    assert "the brain is as it was" in caplog.text
    caplog.clear()
    simulation.edit_brain(brain.replace("Population(", "Population(1 + "))
    assert "the brain is as it was" not in caplog.text


def test_populations_are_read_and_named_anew(launched: Launched, golden: Golden) -> None:
    simulation = launched()
    populations = simulation.get_populations()
    assert populations == {
        "sensors": {"from": 0, "to": 10}, "actors": {"from": 10, "to": 12}, "record": "Population",
    }  # fmt: skip
    changed = {**populations, "actors": [10, 11], "record": {"from": 0, "to": 4, "step": 1}}
    run_to(simulation, 1.0)
    assert {11.0} <= {float(row[0]) for row in simulation.get_csv_data("spikes.csv")[1:]}
    simulation.edit_populations(changed)
    assert simulation.get_populations() == changed
    run_to(simulation, 1.0)
    neurons = {float(row[0]) for row in simulation.get_csv_data("spikes.csv")[1:]}
    assert neurons
    assert neurons <= {0.0, 1.0, 2.0, 3.0}
    with golden.raises(ExperimentError, match="'actors'"):
        simulation.edit_populations({"actors": 1.5})  # type: ignore[dict-item]
    assert simulation.get_populations() == changed


def test_state_machines_are_exchanged_in_a_run(launched: Launched, golden: Golden) -> None:
    simulation = launched("screens_2016", "duration=600s world.options.image_scale=0.25")
    name = "HuskyAwareScreenControlling"
    assert "wait_for_husky" in simulation.get_state_machine(name)
    simulation.delete_state_machine(name)
    simulation.add_state_machine("painter", MACHINE)
    with golden.raises(ExperimentError, match="'painter'"):
        simulation.add_state_machine("painter", MACHINE)
    with golden.raises(ExperimentError):
        simulation.edit_state_machine("painter", "while")
    assert simulation.get_state_machine("painter") == MACHINE
    run_to(simulation, 1.0)
    topic = "/left_vr_screen/body/screen_glass/color"
    latest = simulation._runner.call(lambda run: run.world.subscribe(topic).latest)
    assert latest is not None
    assert (latest.message.r, latest.message.g, latest.message.b) == (1.0, 0.0, 0.0)


def test_a_recording_holds_the_run_since_it_began(launched: Launched, corpus: Path, golden: Golden) -> None:
    simulation = launched()
    with golden.raises(LifecycleError):
        simulation.stop_recording(True)
    simulation.start_recording()
    run_to(simulation, 1.0)
    folder = simulation.stop_recording(True, description="the first second")
    assert folder is not None
    assert folder.is_relative_to(corpus / "p3dx_2018")
    assert Recording(folder).run["result"]["sim_time_s"] == 1.0
    kept = {path.name for path in (folder / "experiment" / "p3dx_2018").iterdir()}
    assert {"drive.py", "grab_laser.py", "walls.sdf"} <= kept  # two are named by its BIBI file alone
    simulation.start_recording()
    assert simulation.stop_recording(False) is None


def test_requests_after_the_end_are_refused_and_records_stay(launched: Launched, golden: Golden) -> None:
    simulation = launched(settings="duration=1s")
    simulation.start()
    while simulation.get_state() != "stopped":
        time.sleep(0.01)
    assert len(simulation.get_csv_data("spikes.csv")) > 100
    simulation.stop()
    for action in (simulation.start, simulation.pause, simulation.print_transfer_functions):
        with golden.raises(LifecycleError):
            action()
    with golden.raises(ExperimentError, match="'spike.csv'.*'spikes.csv'"):
        simulation.get_csv_data("spike.csv")


def test_a_run_is_stopped_only_when_its_files_are_written(
    launched: Launched, corpus: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_csv = Run.write_csv

    def write_slowly(run: Run, folder: Path | None = None, *, overwrite: bool = False) -> list[Path]:
        time.sleep(0.2)
        return write_csv(run, folder, overwrite=overwrite)

    monkeypatch.setattr(Run, "write_csv", write_slowly)
    simulation = launched(settings="duration=0.1s")
    simulation.start()
    while simulation.get_state() != "stopped":
        pass
    assert (
        (corpus / "p3dx_2018" / "csv" / "run_0" / "spikes.csv")
        .read_text()
        .startswith("id,time,Simulation_reset\n")
    )


def test_a_callback_that_fails_does_not_end_the_run(
    launched: Launched, caplog: pytest.LogCaptureFixture
) -> None:
    simulation = launched()
    simulation.register_status_callback(lambda status: status["no such key"])
    assert run_to(simulation, 1.0)["simulationTime"] == 1.0
    assert "a status callback failed" in caplog.text


def test_wrong_arguments_are_refused_at_once(launched: Launched, golden: Golden) -> None:
    simulation = launched()
    with golden.raises(ExperimentError):
        simulation.register_status_callback(None)  # type: ignore[arg-type]
    with golden.raises(ExperimentError, match=r"\[1\]"):
        simulation.edit_populations([1])  # type: ignore[arg-type]


def test_experiments_are_cloned_changed_and_deleted(
    coach: VirtualCoach, corpus: Path, golden: Golden
) -> None:
    name = coach.clone_experiment_to_storage("p3dx_2018")
    assert name == "p3dx_2018_0"
    coach.set_experiment_file(name, "drive.py", AHEAD)
    assert (corpus / name / "drive.py").read_text() == AHEAD
    assert coach.clone_experiment_to_storage("braitenberg_husky") == "braitenberg_husky_0"
    assert coach.clone_experiment_to_storage("p3dx_2018") == "p3dx_2018_1"
    with golden.raises(ExperimentError):
        coach.set_experiment_file(name, "../drive.py", AHEAD)
    coach.delete_cloned_experiment(name)
    assert not (corpus / name).exists()
    with golden.raises(ExperimentError, match="'braitenberg_husky'"):
        coach.delete_cloned_experiment("braitenberg_husky")
    with golden.raises(ExperimentError, match="'p3dx_208'"):
        coach.launch_experiment("p3dx_208")


def test_accounts_and_servers_are_accepted_and_mentioned_once(
    corpus: Path, caplog: pytest.LogCaptureFixture, golden: Golden
) -> None:
    from hbp_nrp_virtual_coach.settings import say_once

    say_once.cache_clear()
    for _ in range(2):
        VirtualCoach("http://148.187.97.12", storage_username="nrpuser", storage_password="password")
    assert caplog.text.count("accounts are not needed") == 1
    assert caplog.text.count("is not a folder") == 1
    with golden.raises(ExperimentError):
        VirtualCoach(str(corpus / "nowhere"))


def test_parts_that_are_missing_and_functions_that_fail_are_logged(
    launched: Launched, caplog: pytest.LogCaptureFixture
) -> None:
    launched("arm_2017")
    assert "the simulation is not complete: " in caplog.text
    assert "room 'nowhere/biology_base.sdf' not found" in caplog.text
    simulation = launched()
    simulation.edit_transfer_function("drive", AHEAD.replace("return", "1 / 0\n    return"))
    run_to(simulation, 1.0)
    assert caplog.text.count("transfer function 'drive' is set aside") == 1
    assert "ZeroDivisionError" in caplog.text
    simulation.edit_transfer_function("drive", AHEAD)
    simulation.add_transfer_function(POSE)
    run_to(simulation, 2.0)
    assert xs(simulation)[-1] > 0.3  # it runs again


def test_an_error_of_an_engine_halts_and_a_full_reset_helps(launched: Launched, golden: Golden) -> None:
    simulation = launched(settings="duration=600s on_error=stop")
    simulation.edit_transfer_function("drive", AHEAD.replace("return", "1 / 0\n    return"))
    simulation.start()
    while simulation.get_state() == "started":
        time.sleep(0.01)
    assert simulation.get_state() == "halted"
    with golden.raises(LifecycleError):
        simulation.start()
    simulation.edit_transfer_function("drive", AHEAD)
    simulation.reset("full")
    assert run_to(simulation, 1.0)["simulationTime"] == 1.0


def test_the_available_names_are_printed(
    coach: VirtualCoach, launched: Launched, capsys: pytest.CaptureFixture[str], golden: Golden
) -> None:
    simulation = launched()
    coach.print_running_experiments()
    simulation.print_transfer_functions()
    simulation.stop()
    coach.print_running_experiments()
    coach.print_last_run_files("p3dx_2018", "csv")
    coach.print_experiment_runs_files("p3dx_2018", "csv")
    expected = """p3dx_2018: paused
grab_laser
csv_spike_monitor
drive
spikes.csv
run 0: spikes.csv
"""
    assert capsys.readouterr().out == expected
    with golden.raises(ExperimentError):
        coach.get_experiment_run_file("p3dx_2018", "csv", 3, "spikes.csv")


def test_a_warning_of_a_check_is_logged_once(
    launched: Launched, corpus: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with (corpus / "p3dx_2018" / "drive.py").open("a") as file:
        file.write("\n\n" + AHEAD.replace("def drive(", "def drive_too("))
    for _ in range(2):
        launched(settings=f"duration=600s name={corpus.parent.name}").stop()
    assert caplog.text.count("[NRP229]") == 1  # two functions command one drive
