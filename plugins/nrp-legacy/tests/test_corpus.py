"""Each experiment of the corpus does what it is about, on every pair of engines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from recorded import rows

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.scene.merged_bodies import STIFF_TIME_CONSTANT_S
from nrp_core.scene.model import Box

Opened = Callable[..., Run]


def test_an_arm_reaches_the_commanded_joint_positions(played: Callable[..., Run]) -> None:
    run = played("arm_2017/arm.exc")
    last = {name: float(position) for name, _, position in rows(run, "record_joints", "recorder")}
    assert last == {"arm_1_joint": pytest.approx(0.5, abs=0.03), "arm_2_joint": pytest.approx(-0.4, abs=0.03)}
    told = "\n".join(map(str, run.result().problems))
    assert "the mesh 'model://arm_robot/meshes/arm_1.dae' is not there" in told
    assert "; also 'model://arm_robot/meshes/arm_1.stl' (and 1 more) [" in told
    assert "room 'nowhere/biology_base.sdf' not found: a plain floor is used" in told


def test_a_pioneer_sees_a_wall_and_moves(played: Callable[..., Run]) -> None:
    run = played("p3dx_2018/p3dx.exc", "duration=0.4 s")
    result = run.result()
    assert not result.failures
    assert result.spikes["sensors"] > 100
    assert result.final_pose["robot"]["x"] > 0.02
    assert abs(result.final_pose["robot"]["pitch"]) < 0.1
    assert len(rows(run, "csv_spike_monitor", "recorder")) == result.spikes["record"]
    assert any("no 'model://no_such_model'" in warning for warning in map(str, result.problems))


def test_eyes_turn_by_topics_that_no_known_plugin_serves(played: Callable[..., Run]) -> None:
    run = played("icub_2017/icub.exc")
    _, eye, plotted = rows(run, "look", "out")[-1]
    assert (float(eye), plotted) == (pytest.approx(0.2, abs=0.05), "True")
    assert not run.result().failures


def test_machines_switch_screens_move_things_and_call_services(played: Callable[..., Run]) -> None:
    run = played("screens_2016/ExDBraitenbergHuskyScreens.exc")
    result = run.result()
    assert not result.failures
    told = "\n".join(map(str, result.problems))
    assert "state machine" not in told
    assert "service /gazebo" not in told
    screen = run.world.subscribe("/left_vr_screen/body/screen_glass/color").latest
    assert screen is not None
    assert (screen.message.r, screen.message.g) == (1.0, 0.0)
    assert "sphere" not in [model.name for model in run.world.scene.models]
    height = float(rows(run, "screen", "recorder")[-1][1])
    assert height == pytest.approx(0.1, abs=0.02)
    assert result.spikes["sensors"] > 50
    assert np.hypot(result.final_pose["husky"]["x"], result.final_pose["husky"]["y"]) > 0.05


def test_a_brain_in_nest_takes_currents_in_pa(played: Callable[..., Run]) -> None:
    run = played("directnest_2019/husky.exc", "duration=0.5 s")
    result = run.result()
    assert not result.failures
    assert result.spikes["sensors"] > 50
    assert result.spikes["actors"] > 20
    functions = {function.name: function.adapters for function in run.loop.functions}
    current = functions["eye_sensor_transmit"]["red_left_eye"]
    assert (current.amplitude, current.port.amplitude) == (pytest.approx(150.0), pytest.approx(0.15))


def test_every_idiom_of_transfer_functions_runs(played: Callable[..., Run]) -> None:
    run = played("floreano_2018/experiment.exc")
    result = run.result()
    assert not result.failures
    assert [function.name for function in run.loop.functions] == [
        "sources", "rostopics", "triggered", "sinks", "voltages", "rates", "other_robot", "tabs",
    ]  # fmt: skip
    time, text, rate = rows(run, "other_robot", "rows")[-1]
    assert (float(time), text) == (pytest.approx(0.38), "3")
    assert float(rate) > 0
    assert result.final_pose["rat"]["x"] > 3.1
    assert result.final_pose["husky"]["y"] > 0.05
    told = "\n".join(map(str, result.problems))
    for left_out in (
        "no_such_library",
        "does not declare a transfer function",
        "gone.py",
        "gets no messages",
    ):
        assert left_out in told


def test_a_missing_machine_is_named(opened: Opened, corpus: Path) -> None:
    assert any(
        "state machine 'gone.exd' not found" in text
        for text in map(str, opened("icub_2017/icub.exc").problems)
    )


def test_code_of_python_2_of_old_libraries_and_of_no_library_runs(played: Callable[..., Run]) -> None:
    run = played("students_2018/students.exc")
    result = run.result()
    assert [failure["function"] for failure in result.failures] == ["learns"]
    assert "the module 'tensorflow' is not installed" in result.failures[0]["error"]
    assert rows(run, "python2", "rows")[-1][1] == "7"
    seen = rows(run, "libraries", "rows")[-1]
    assert seen[1:] == ["2304", "16", "3", "1", "18.0", "(12, 16)"]
    ticks, names, speed = rows(run, "messages", "rows")[-1]
    assert (ticks, names) == ("6", "4")
    assert 0.5 < float(speed) < 0.6
    first, last = (rows(run, "root_of_brain", "rows")[i] for i in (0, -1))
    assert (first[:3], float(first[3])) == (["10", "-50.0", "25"], pytest.approx(0.02, rel=1e-3))
    assert (last[:3], float(last[3])) == (["10", "-40.0", "25"], pytest.approx(0.03, rel=1e-3))
    assert result.spikes["sensors"] > 50
    told = "\n".join(map(str, result.problems))
    assert "module 'keras' is not installed" in told
    assert "the message package 'tigrillo_msgs' is not known" in told
    assert "'yaw' of <robotPose> must be a number, not 'north': not used" in told


def test_machines_iterate_go_side_by_side_and_change_models(played: Callable[..., Run]) -> None:
    run = played("students_2018/students.exc")
    assert [row[0] for row in rows(run, "said", "rows")] == ["0", "1", "fast", "slow", "end"]
    box = run.world.scene.model("box")
    assert box.links[0].collisions[0].geometry == Box((2.0, 1.0, 3.0))
    assert run.world.model_motion("box").pose.rpy[2] == pytest.approx(1.5)


def test_random_numbers_of_student_code_follow_from_the_seed(opened: Opened) -> None:
    def drawn(seed: int) -> list[list[str]]:
        run = opened("students_2018/students.exc", f"seed={seed}")
        run.run_until(0.15)
        return rows(run, "libraries", "rows")

    assert drawn(1) == drawn(1) != drawn(2)


def test_a_joint_turns_with_the_velocity_that_is_asked_for_whatever_brakes_it(
    played: Callable[..., Run], corpus: Path
) -> None:
    (corpus / "icub_2017" / "turn.py").write_text(
        """
@nrp.Neuron2Robot(Topic('/icub/eye_version/vel', std_msgs.msg.Float64))
def turn(t):
    return std_msgs.msg.Float64(0.2)
"""
    )
    bibi = next((corpus / "icub_2017").glob("*.bibi"))
    body = "<bodyModel robotId='icub'>icub_model/icub.sdf</bodyModel>"
    bibi.write_text(f"<bibi>{body}<transferFunction src='turn.py'/></bibi>")
    run = played("icub_2017/icub.exc", "duration=1 s")
    joints = run.world.joint_states("icub")
    # from the end of the first step on, at 0.2 rad/s but for a delay of the time constant of 40 ms
    turned = 0.2 * (1 - 0.02 - STIFF_TIME_CONSTANT_S)
    assert joints.positions[joints.names.index("eye_version")] == pytest.approx(turned, abs=0.002)


def test_copies_of_models_of_nest_fire_and_their_synapses_recover_at_once(opened: Opened) -> None:
    run = opened("copies_2016/copies.exc")
    run.run()
    result = run.result()
    assert result.complete
    assert not result.failures
    (projection,) = run.brain.network.projections
    assert set(projection.synapse_parameters["tau_rec"].tolist()) == {1e-6}
    assert not [problem for problem in result.problems if problem.code is Code.NRP297]
    assert 0.01 <= projection.weight.min() <= projection.weight.max() <= 0.02
    # at 0.2 nA the membrane of 25 pF passes 0.5 mV in 0.06 ms; then it rests for 9 ms: 110 spikes a second
    assert result.spikes["eyes"] == pytest.approx(0.4 / 9.1e-3, abs=3)
    assert result.spikes["wheels"] > 10


def test_a_course_of_2019_goes_to_a_point_of_a_grid_that_it_reads_by_texts_and_floats(
    played: Callable[..., Run],
) -> None:
    run = played("course_2019/course.exc")
    result = run.result()
    assert result.complete
    assert not result.failures
    # the grid's values are 0.1 times x and y, the way ends at (1, 0), 7 / 2 is 3 or 3.5, and a list was sent
    assert rows(run, "steer", "recorder")[-1] == ["0.1", "0.0", "3", "3.5", "2.0"]
    assert result.final_pose["robot"]["x"] == pytest.approx(0.1, abs=0.005)


def test_its_machine_receives_each_message_and_waits_for_activity(played: Callable[..., Run]) -> None:
    run = played("course_2019/course.exc")
    assert not [problem for problem in run.problems if problem.code in (Code.NRP272, Code.NRP280)]
    (sun,) = (light for light in run.world.scene.lights if light.name == "sun")
    assert sun.diffuse[:2] == (0.1, 0.2)
    assert run.world.model_motion("left_vr_screen").pose.position == pytest.approx((3.0, 2.0, 0.5))


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    ("name", "right", "wrong"),
    [
        ("places.exd", "rate < 1.0", "rate < 1e6"),  # waits for more spikes than there are
        ("places.exd", "len(heard) < 4", "len(heard) < 401"),  # 2 in each of 200 steps
        ("places.exd", "'actors_rate'", "'sensors_rate'"),  # nothing has this name
    ],
)
def test_the_machine_does_not_go_on_before_it_should(
    played: Callable[..., Run], corpus: Path, name: str, right: str, wrong: str
) -> None:
    file = corpus / "course_2019" / name
    text = file.read_text()
    assert right in text
    file.write_text(text.replace(right, wrong))
    run = played("course_2019/course.exc")
    assert run.world.model_motion("left_vr_screen").pose.position == pytest.approx((0.0, 2.0, 1.0))


def test_currents_that_a_run_adds_to_the_network_are_not_called_unused(opened: Opened) -> None:
    told = "\n".join(map(str, opened("p3dx_2018/p3dx.exc").problems))
    assert "is never injected" not in told
