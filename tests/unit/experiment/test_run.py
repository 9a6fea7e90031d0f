"""A whole run on two engines without a simulator."""

import json
import math
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import (
    BackendLoadError,
    DivergedError,
    ExperimentError,
    LifecycleError,
    SimulationError,
    TimestepError,
    TopicError,
    TransferFunctionRaisedError,
)
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, InvalidExperimentError
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.rigid import ModelMotion, Pose
from nrp_core.simulation import State

pytestmark = pytest.mark.usefixtures("fakes")

Open = Callable[..., Run]
Raising = Callable[[str], str]


@pytest.fixture
def open_run(drive_to_the_wall: Path) -> Iterator[Open]:
    """Open the experiment with overrides."""
    runs: list[Run] = []

    def opened(*overrides: str) -> Run:
        runs.append(Run(load_experiment(drive_to_the_wall, overrides)))
        return runs[-1]

    yield opened
    for run in runs:
        run.close()


def test_events_for_missing_things_are_reported_and_left_out_unless_the_experiment_is_strict(
    open_run: Open,
    golden: Golden,
) -> None:
    events = "events.nowhere={at: 0 s, publish: {topic: /no/such/color, value: red}}"
    with golden.raises(InvalidExperimentError, match="'/no/such/color'"):
        open_run(events)
    run = open_run(events, "strict=false", "aliases./lamp=/no/lamp")
    run.run()
    assert run.result().complete
    told = "\n".join(map(str, run.problems))
    assert told.count("no topic '/no/such/color'") == told.count("no topic '/no/lamp'") == 1


def test_the_whole_story_runs_and_passes(open_run: Open) -> None:
    run = open_run()
    run.run()
    result = run.result()
    assert result.passed is True
    assert result.events == {"go": 0.0, "red": 0.5, "arrived": 2.01}
    assert result.criteria["arrives"].took_s == 1.51
    assert (result.sim_time_s, result.steps, result.seed) == (3.0, 150, 7)
    assert (result.experiment, result.brain, result.world) == ("drive_to_the_wall", "counting", "disc")
    assert result.final_pose["husky"]["x"] == pytest.approx(2.02)
    assert result.spikes == {"sensors": 600, "actors": 0, "circuit": 600}
    assert sum(result.time_share.values()) == pytest.approx(1.0)
    assert run.world.engine.colors["wall/body/glass"] == (0.0, 0.0, 1.0, 1.0)  # type: ignore[attr-defined]


def test_a_result_is_plain_data(open_run: Open) -> None:
    run = open_run()
    run.run()
    data = json.loads(json.dumps(run.result().to_dict(), allow_nan=False))
    assert data["criteria"]["arrives"]["passed"] is True
    assert data["real_time_factor"] == pytest.approx(data["sim_time_s"] / data["wall_time_s"])


def compared(run: Run) -> dict[str, Any]:
    """What must not differ between two equal runs."""
    run.run()
    data = run.result().to_dict()
    for key in ("wall_time_s", "real_time_factor", "time_share"):
        del data[key]
    return data


def test_two_runs_are_equal_and_so_is_one_after_a_reset(open_run: Open) -> None:
    first, second = open_run(), open_run()
    expected = compared(first)
    assert compared(second) == expected
    second.loop.reset()
    assert second.result().events == {"go": None, "red": None, "arrived": None}
    assert compared(second) == expected


def test_a_result_says_where_robots_are_after_a_reset_without_a_step(open_run: Open) -> None:
    run = open_run()
    run.run_until(0.5)
    assert run.result().final_pose["husky"]["x"] > 0.3
    run.loop.reset()
    assert run.result().final_pose["husky"]["x"] == 0.0


def test_how_a_run_is_split_makes_no_difference(open_run: Open) -> None:
    whole, split = open_run(), open_run()
    split.run_until(0.5)
    for _ in range(7):
        split.step()
    split.run_until(1.0)
    assert compared(split) == compared(whole)


def test_the_trajectory_digest_distinguishes_runs(open_run: Open) -> None:
    slow = open_run("events.go.publish.value=0.9")
    assert compared(slow)["trajectory_digest"] != compared(open_run())["trajectory_digest"]


def test_a_criterion_that_is_not_met_fails_the_run(open_run: Open) -> None:
    run = open_run("criteria.arrives.within_of.time=1 s")
    run.run()
    assert run.result().passed is False


def test_a_run_that_is_cut_short_decides_nothing_more(open_run: Open) -> None:
    run = open_run()
    run.run(1.0)
    assert run.result().passed is None
    run.run()
    assert run.result().passed is True


def test_a_run_without_criteria_is_complete_and_has_nothing_to_pass(open_run: Open) -> None:
    run = open_run("criteria=null")
    run.run(0.1)
    assert (run.result().complete, run.result().passed) == (True, None)


def test_the_end_of_the_experiment_decides_however_it_is_reached(open_run: Open) -> None:
    whole, steps = open_run("events.red.at=9 s"), open_run("events.red.at=9 s")
    whole.run()
    steps.run_until(2.98)
    assert steps.result().passed is None
    steps.step()
    assert whole.result().passed is steps.result().passed is False
    assert whole.result().criteria == steps.result().criteria


def test_a_run_goes_on_after_its_result_was_asked_for_at_the_end(open_run: Open, golden: Golden) -> None:
    run = open_run("events.red.at=4 s", "criteria.arrives.within_of.time=1 s", "criteria.stays_near=null")
    run.run()
    assert run.result().passed is False
    assert Code.NRP279 not in {one.code for one in run.problems}
    run.run_until(4.5)
    assert run.result().passed is True
    (problem,) = (one for one in run.problems if one.code is Code.NRP279)
    assert "4.5" in problem.message
    golden(problem.message)


@pytest.mark.parametrize(("t_s", "doubted"), [(0.2, False), (4.5, False), (31.0, True)])
def test_a_time_far_beyond_the_experiment_causes_a_warning(
    open_run: Open, t_s: float, doubted: bool, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level("WARNING", "nrp_core.experiment"):
        open_run().run_until(t_s)
    assert ("write 0.031 for 31 ms" in caplog.text) is doubted


def test_a_run_can_be_looked_at_before_its_first_step(open_run: Open) -> None:
    result = open_run().result()
    assert (result.sim_time_s, result.steps, result.real_time_factor, result.passed) == (0.0, 0, 0.0, None)
    assert result.final_pose["husky"]["x"] == 0.0


def test_observers_see_every_step_with_its_events(open_run: Open) -> None:
    run = open_run()
    seen: list[tuple[float, bool]] = []
    run.on_step(lambda run: seen.append((run.now_s, run.result().events["red"] is not None)))
    run.run_until(0.54)
    assert seen[-4:] == [(0.48, False), (0.5, True), (0.52, True), (0.54, True)]


# -- from outside


@pytest.mark.parametrize(
    "value", ["red", "Gazebo/RedGlow", [1, 0, 0], {"r": 1}, ColorRGBA(1.0, 0.0, 0.0, 1.0)]
)
def test_a_screen_can_be_turned_red_while_it_runs(open_run: Open, value: Any) -> None:
    run = open_run("events.red=null", "events.arrived=null", "criteria=null")
    run.run_until(0.2)
    run.publish("/glass", value)
    run.step()
    assert run.world.engine.colors["wall/body/glass"] == (1.0, 0.0, 0.0, 1.0)  # type: ignore[attr-defined]


@pytest.mark.parametrize("seed", [1.5, "3", True])
def test_a_seed_that_is_not_an_integer_is_refused(open_run: Open, seed: Any, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=f"{seed!r}"):
        open_run("events=null", "criteria=null").reset(seed=seed)


def test_another_thread_may_publish(open_run: Open) -> None:
    run = open_run("events=null", "criteria=null")
    thread = threading.Thread(target=run.publish, args=("/speed", 2))
    thread.start()
    thread.join()
    run.run_until(1.0)
    assert run.result().final_pose["husky"]["x"] > 1.9


@pytest.mark.parametrize(
    ("topic", "value"),
    [("/glas", "red"), ("/glass", "rde"),
     ("/gazebo/model_states", {}), ("/speed", float("nan"))],
)  # fmt: skip
def test_an_invalid_message_is_refused_when_it_is_published(
    open_run: Open, topic: str, value: Any, golden: Golden
) -> None:
    with golden.raises(TopicError):
        open_run().publish(topic, value)


# -- when something fails


def test_a_time_between_two_steps_is_refused(open_run: Open, golden: Golden) -> None:
    with golden.raises(TimestepError, match=r"0\.01"):
        open_run().run_until(0.01)


def test_a_transfer_function_that_raises_stops_the_run_which_can_still_be_summed_up(
    open_run: Open, raising: Raising, drive_to_the_wall: Path, golden: Golden
) -> None:
    run = open_run(raising("raise ValueError('deep')"))
    with golden.raises(TransferFunctionRaisedError):
        run.run()
    result = run.result()
    assert result.passed is False
    assert result.sim_time_s == 1.02
    assert "ValueError: deep" in str(result.error)
    assert result.failures == [
        {"function": "wrong", "path": str(drive_to_the_wall / "wrong.py"), "line": 4, "t_s": 1.02,
         "error": "ValueError: deep"}
    ]  # fmt: skip


def test_with_quarantine_the_rest_runs_on(open_run: Open, raising: Raising) -> None:
    run = open_run(raising("return 3"), "on_error=quarantine", "criteria=null")
    run.run()
    result = run.result()
    assert (result.complete, result.passed, result.sim_time_s, result.error) == (False, None, 3.0, None)
    assert [failure["function"] for failure in result.failures] == ["wrong"]


def test_an_engine_that_fails_is_reported_and_what_was_reached_is_kept(
    open_run: Open, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    run = open_run()
    run.run_until(0.6)

    def fail(steps: int) -> None:
        raise ZeroDivisionError("deep inside")

    monkeypatch.setattr(run.world.engine, "_do_advance", fail)
    with golden.raises(SimulationError, match=r"DiscEngine.*0\.6.*ZeroDiv"):
        run.run()
    assert run.result().passed is False
    assert run.result().events["red"] == 0.5
    assert run.result().final_pose["husky"]["x"] == pytest.approx(0.6, abs=0.03)


def test_a_robot_that_flies_apart_ends_the_run_where_it_was_last_seen(
    open_run: Open, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    run = open_run()
    run.run_until(0.6)
    nowhere = ModelMotion(Pose((math.nan, 0.0, 0.0)))
    monkeypatch.setattr(run.world.engine, "_do_model_motion", lambda model: nowhere)
    with golden.raises(DivergedError, match="'husky'"):
        run.run()
    json.dumps(run.result().to_dict(), allow_nan=False)
    assert run.result().final_pose["husky"]["x"] == pytest.approx(0.58)


def test_an_interrupted_run_has_failed_nothing(open_run: Open) -> None:
    run = open_run()

    def interrupt(run: Run) -> None:
        if run.now_s >= 0.5:
            raise KeyboardInterrupt

    run.on_step(interrupt)
    with pytest.raises(KeyboardInterrupt):
        run.run()
    result = run.result()
    assert (result.passed, result.error, result.sim_time_s) == (None, "interrupted", 0.5)


def test_a_backend_that_does_not_open_is_named_and_the_other_one_closed(
    drive_to_the_wall: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    from experiment_fakes import CountingBackend, DiscBackend

    worlds: list[Any] = []
    open_world = DiscBackend.open

    def fail(*args: Any, **settings: Any) -> None:
        raise OSError("no such library")

    def remember(*args: Any, **settings: Any) -> Any:
        worlds.append(open_world(*args, **settings))
        return worlds[-1]

    monkeypatch.setattr(CountingBackend, "open", fail)
    monkeypatch.setattr(DiscBackend, "open", remember)
    with golden.raises(BackendLoadError, match="'counting'.*OSError"):
        Run(load_experiment(drive_to_the_wall))
    assert [world.state for world in worlds] == [State.CLOSED]


def test_after_closing_the_result_stays_and_nothing_else_works(open_run: Open) -> None:
    run = open_run()
    run.run()
    run.close()
    run.close()
    assert run.result().passed is True
    with pytest.raises(LifecycleError):
        run.step()


def test_a_waiting_user_sees_the_current_task(drive_to_the_wall: Path) -> None:
    told: list[str] = []
    Run(load_experiment(drive_to_the_wall), told.append).close()
    assert told == [
        "reading the room and the robots",
        "executing the brain script brain.py",
        "opening the world (disc)",
        "opening the brain (counting)",
    ]


READER = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

@nrp.MapRobotSubscriber("heard", nrp.Topic("/nobody", Float64))
@nrp.Robot2Neuron()
def listen(t, heard):
    pass
"""
WRITER = """
import hbp_nrp_client.tf_framework as nrp
from std_msgs.msg import Float64

@nrp.Neuron2Robot(nrp.Topic("/nobody", Float64))
def speak(t):
    return Float64(t)
"""


def test_a_topic_that_only_a_function_added_later_reads_is_a_problem_as_long_as_it_does(
    open_run: Open, tmp_path: Path, golden: Golden
) -> None:
    run = open_run("strict=false")
    for name, text in (("reader", READER), ("writer", WRITER)):
        (tmp_path / f"{name}.py").write_text(text)
    silent = lambda: [one for one in run.problems if one.code is Code.NRP212]  # noqa: E731
    assert silent() == []
    run.change([tmp_path / "reader.py"])
    (problem,) = silent()
    assert "'/nobody'" in problem.message
    golden(problem.message)
    assert (problem.path, problem.line) == (tmp_path / "reader.py", 5)
    run.change([tmp_path / "writer.py"])
    assert silent() == []
    run.change(remove=["speak"])
    assert len(silent()) == 1
    run.change(remove=["listen"])
    assert silent() == []


@pytest.mark.parametrize("kind", [str, Path])
def test_one_file_of_functions_is_changed_like_a_list_of_one(
    open_run: Open, tmp_path: Path, kind: type, golden: Golden
) -> None:
    run = open_run("strict=false")
    (tmp_path / "reader.py").write_text(READER)
    run.change(kind(tmp_path / "reader.py"))
    assert "listen" in {function.name for function in run.loop.functions}
    run.change(remove="listen")
    with golden.raises(ExperimentError, match=r"\[3\]"):
        run.change([3])  # type: ignore[list-item]
