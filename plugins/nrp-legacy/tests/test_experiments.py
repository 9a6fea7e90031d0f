"""Whole experiments, as they are, on real engines."""

from __future__ import annotations

import csv
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from nrp_legacy.reader import read_exc

from nrp_core.checks.validate import validate_file
from nrp_core.clock import seconds
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

Opened = Callable[..., Run]

EVERY = [
    "husky_2017/experiment_configuration.exc",
    "husky_2019/cart.exc",
    "husky_2015/ExDConf.exc",
    "bare/bare.exc",
]
SCREEN = "/left_vr_screen/body/screen_glass/color"


def color(run: Run) -> tuple[float, float, float]:
    stamped = run.world.subscribe(SCREEN).latest
    assert stamped is not None
    return stamped.message.r, stamped.message.g, stamped.message.b


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("brain", ["event", "spinnaker"])
def test_an_experiment_runs_to_its_end_on_either_brain(opened: Opened, name: str, brain: str) -> None:
    run = opened(name, f"brain.backend={brain}")
    run.run()
    result = run.result()
    assert result.error is None
    assert result.sim_time_s == run.experiment.duration / 1e9
    assert [failure["function"] for failure in result.failures] in ([], ["raises"])


def test_a_function_that_raises_is_set_aside_and_the_rest_runs_on(opened: Opened) -> None:
    run = opened(EVERY[0])
    run.run()
    (failure,) = run.result().failures
    assert (failure["function"], failure["line"], failure["t_s"]) == ("raises", 5, pytest.approx(0.12))
    assert run.result().final_pose["robot"]["yaw"] == pytest.approx(1.5 + 0.1 * 2.0, abs=0.02)


def test_everything_that_is_left_out_is_named_with_its_line(opened: Opened) -> None:
    told = "\n".join(map(str, opened(EVERY[0]).result().problems))
    assert "bibi_configuration.bibi:14: a transfer function is left out: " in told
    assert "the experiment does not have a transfer function 'lost.py'" in told
    assert "experiment_configuration.exc:15: <rosLaunch> 'start.launch': not found" in told
    assert "drive.py: leftovers of Python 2 were converted: tabs in indentation, print statements" in told
    assert "the world has no topic '/nobody/serves/this'" in told
    assert "robot 'nowhere/model.sdf' not found: left out" in "\n".join(
        map(str, opened(EVERY[1]).result().problems)
    )


def test_a_state_machine_acts_at_its_time(opened: Opened) -> None:
    run = opened(EVERY[0])
    run.run_until(0.98)
    assert color(run) == (0.0, 0.0, 1.0)
    run.run_until(1.04)
    assert color(run) == (1.0, 0.0, 0.0)


def test_a_state_machine_begins_anew_after_a_reset(opened: Opened) -> None:
    run = opened(EVERY[0])
    run.run_until(1.1)
    run.loop.reset()
    assert color(run) == (0.0, 0.0, 1.0)
    run.run_until(1.1)
    assert color(run) == (1.0, 0.0, 0.0)


def test_two_runs_of_one_experiment_are_equal(opened: Opened) -> None:
    first, second = opened(EVERY[0]), opened(EVERY[0])
    first.run()
    second.run()
    assert first.result().trajectory_digest == second.result().trajectory_digest
    assert first.result().spikes == second.result().spikes


def test_functions_see_red_and_drive_spikes_through_variables_they_share(opened: Opened) -> None:
    run = opened(EVERY[0])
    run.run_until(1.0)
    seen = {function.name: function for function in run.loop.functions}["drive"].adapters["seen"]
    assert seen.value == 0.0
    run.run()
    assert seen.value > 0.1
    assert run.result().spikes["left"] > 0


def test_records_stand_beside_the_experiment_and_quote_their_commas(opened: Opened, corpus: Path) -> None:
    run = opened(EVERY[0])
    run.run_until(0.1)
    assert run.write_csv() == [corpus / "husky_2017" / "csv" / "screen.csv"]
    with (corpus / "husky_2017" / "csv" / "screen.csv").open(newline="") as file:
        header, first, *_ = csv.reader(file)
    assert (header, first) == (["time", "x, y", "Simulation_reset"], ["0.0", "0.0, 0.0"])


def test_the_first_time_that_a_function_sees_is_zero_and_an_inactive_one_sees_none(opened: Opened) -> None:
    run = opened(EVERY[1])
    run.run_until(0.02)
    recorder = {function.name: function for function in run.loop.functions}["count_spikes"].adapters[
        "recorder"
    ]
    assert [row[0] for row in recorder.rows] == ["0.0", "0.01"]
    assert not run.result().failures


def test_functions_that_read_the_robot_run_before_those_that_write_to_it_unless_priorities_differ(
    opened: Opened,
) -> None:
    names = [function.name for function in opened(EVERY[1]).loop.functions]
    assert names == ["currents", "switched_off", "count_spikes", "all_neurons_spike_monitor", "drive"]


def test_robots_stand_where_either_spelling_of_poses_puts_them(opened: Opened) -> None:
    poses = opened(EVERY[1]).result().final_pose
    assert poses["second"]["yaw"] == pytest.approx(3.14159265)
    assert (poses["second"]["y"], poses["husky"]["y"]) == (-3.0, 0.0)
    assert opened(EVERY[2]).result().final_pose["robot"]["yaw"] == pytest.approx(1.5707963)


def test_a_monitor_shows_every_spike_once(opened: Opened) -> None:
    run = opened(EVERY[1])
    step_s, end_s = seconds(run.experiment.timestep), seconds(run.experiment.duration)
    run.run_until(end_s - step_s)
    shown = run.result().spikes["record"]  # a message reaches its function in the next step
    run.run()
    recorder = {function.name: function for function in run.loop.functions}["count_spikes"].adapters[
        "recorder"
    ]
    assert int(recorder.rows[-1][1]) == shown > 0


def test_building_blocks_drive_cells_and_wheels(opened: Opened) -> None:
    run = opened(EVERY[2])
    run.run()
    assert run.result().spikes["sensors"] > 0
    assert run.result().final_pose["robot"]["yaw"] > 1.62


def test_without_brain_body_and_room_what_is_left_runs(opened: Opened) -> None:
    run = opened(EVERY[3])
    run.run()
    count = run.loop.functions[0].adapters["count"]
    assert count.value == 5
    assert any("room 'no/such/room.sdf' not found" in warning for warning in map(str, run.result().problems))


def test_a_robot_in_an_archive_is_found(
    opened: Opened, corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    robot = corpus / "models" / "husky_model"
    with zipfile.ZipFile(corpus / "husky_2017" / "cart.zip", "w") as archive:
        for file in robot.iterdir():
            archive.write(file, f"cart/{file.name}")
            file.unlink()
    bibi = corpus / "husky_2017" / "bibi_configuration.bibi"
    bibi.write_text(bibi.read_text().replace("husky_model/model.sdf", "cart.zip"))
    assert "robot" in opened(EVERY[0]).result().final_pose


def test_a_brain_that_cannot_be_loaded_leaves_the_functions_that_need_none(
    opened: Opened, corpus: Path
) -> None:
    (corpus / "models" / "brain_model" / "two_cells.py").write_text(
        "import no_such_simulator as sim\nsim.setup()\n"
    )
    run = opened(EVERY[0])
    assert [function.name for function in run.loop.functions] == ["raises", "record"]
    assert any("the brain is left out" in warning for warning in map(str, run.result().problems))


BRAIN = "brain_model/idle_brain.py"
IT = '<bodyModel robotId="it"'
NO_TIME = "must be a time in seconds or a duration such as PT14M, not"


@pytest.mark.parametrize(
    ("exc", "bibi", "told"),
    [
        ("<timeout>0</timeout>", "", "<timeout> is 0: 600 s are used"),
        ("<timeout>soon</timeout>", "", f"<timeout> {NO_TIME} 'soon': not used"),
        ("", "<timestep>1</timestep>", ""),
        ("", "<timestep>fast</timestep>", "<timestep> must be a number of milliseconds, not 'fast'"),
        ('<environmentModel src="broken.sdf"/>', "", "the room is left out and replaced by a plain floor"),
        ("", "<bodyModel>broken.sdf</bodyModel>",
         "broken.sdf:1: the robot 'robot' is left out: this is not well-formed XML"),
        ("", f'{IT} model="husky_model"/>', ""),
        ("", f'{IT} customAsset="true" assetPath="no.zip">husky_model/model.sdf</bodyModel>', ""),
        ("", "<bodyModel>Husky_Model/model.SDF</bodyModel>", ""),
        ("", "<bodyModel>broken.zip</bodyModel>", "this is not a ZIP archive that can be read"),
        ("", '<brainModel model="braitenberg_directnest"/>', ""),
        ("", f'<brainModel><file>{BRAIN}</file><populations population="a" from="x"/></brainModel>',
         "population 'a' has no neurons in idle_brain.py"),
    ],
)  # fmt: skip
def test_an_unreadable_file_is_reported_and_the_other_experiments_run(
    opened: Opened, corpus: Path, exc: str, bibi: str, told: str
) -> None:
    folder = corpus / "odd"
    folder.mkdir()
    (folder / "broken.sdf").write_text("<sdf><world>")
    (folder / "broken.zip").write_text("no archive")
    (folder / "tf.py").write_text("@nrp.Robot2Neuron()\ndef runs(t):\n    pass\n")
    (folder / "odd.bibi").write_text(f'<bibi>{bibi}<transferFunction src="tf.py"/></bibi>')
    (folder / "odd.exc").write_text(f'<ExD><bibiConf src="other.bibi"/>{exc}</ExD>')
    run = opened("odd/odd.exc")
    run.run_until(0.04)
    result = run.result()
    assert [function.name for function in run.loop.functions] == ["runs"]
    assert not result.failures
    warnings = "\n".join(map(str, result.problems))
    assert told in warnings
    assert (
        "the experiment names 'other.bibi', which does not exist: odd.bibi in its folder is used" in warnings
    )
    assert ("it" in result.final_pose) == ("robotId" in bibi)
    assert ("runs without neurons" in warnings or "robot 'broken.zip' not found" in warnings) == (
        "broken.zip" in bibi
    )


def test_an_override_of_our_own_format_wins(corpus: Path) -> None:
    experiment = read_exc(corpus / EVERY[0], [f"models=[{corpus / 'models'}]", "duration=1 s", "seed=5"])
    assert (experiment.duration, experiment.seed) == (10**9, 5)


def test_patterns_of_a_map_take_the_population_of_its_source(opened: Opened) -> None:
    run = opened("husky_maps_2015/maps.exc")
    assert [function.name for function in run.loop.functions] == ["stimulate"]
    (group,) = [one for one in run.loop.functions[0].adapters.values() if hasattr(one, "__len__")]
    assert len(group) == 2


def test_recorders_write_files_beside_the_experiment_or_its_archive_by_default(
    corpus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = corpus / "poses_2017" / "poses.exc"
    assert load_experiment(file).csv_folder == file.parent / "csv"
    assert load_experiment(file, ["csv_folder=out"]).csv_folder == Path("out")
    archive = shutil.make_archive(str(tmp_path / "packed"), "zip", file.parent)
    monkeypatch.chdir(tmp_path)
    assert load_experiment(archive).csv_folder == tmp_path / "packed" / "csv"
    assert load_experiment(archive, ["csv_folder=out"]).csv_folder == Path("out")


def test_a_start_pose_in_degrees_is_reported_once_with_its_line(corpus: Path) -> None:
    file = corpus / "poses_2017" / "poses.exc"
    file.write_text(file.read_text().replace('yaw="0"', 'yaw="45"'))
    found = [
        finding
        for finding in validate_file(str(file), [f"models=[{corpus / 'models'}]"])
        if "45" in finding.message
    ]
    assert [(finding.line, finding.message) for finding in found] == [
        (5, "the yaw of 'robot' is 45 rad, more than a turn; 45 degrees are 0.7854 rad")
    ]
