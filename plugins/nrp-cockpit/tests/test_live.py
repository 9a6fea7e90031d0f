"""Time goes on and back over a real websocket, with engines that save all of their state and with others."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_cockpit.command import open_run
from nrp_cockpit.session import reports
from nrp_cockpit.wire.hub import Hub
from states import plain
from visitors import SMALL, Cockpit, RefusedError, Visitor, cockpit

from nrp_core.findings import Code

COLOUR = "/left_vr_screen/body/screen_glass/color"
BACKENDS = [("mujoco", "event"), ("pybullet", "spinnaker")]


@pytest.fixture(scope="module", params=BACKENDS, ids="-".join)
def opened(request: pytest.FixtureRequest) -> Iterator[Cockpit]:
    world, brain = request.param
    with cockpit(f"world.backend={world}", f"brain.backend={brain}") as opened:
        yield opened


def state(opened: Cockpit) -> Any:
    """Return all that the run keeps, for comparison bit for bit."""
    sides, loop, own = pickle.loads(opened.session.ask(opened.run.snapshot))
    return plain((sides, loop, own[:3]))


def pose(opened: Cockpit) -> Any:
    """Return where the robot is, to 1 mm and 1 mrad."""
    return pytest.approx(opened.session.ask(opened.run.result).final_pose["husky"], abs=1e-3, rel=0)


def is_exact(opened: Cockpit) -> bool:
    """Return whether snapshots keep everything; those of PyBullet lose some of the contacts."""
    return opened.run.experiment.world.backend != "pybullet"


def now_s(opened: Cockpit) -> float:
    return float(opened.session.ask(lambda: opened.run.now_s))


# -- time


@pytest.mark.one_of(3)
def test_it_plays_until_it_is_paused(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("play")
    visitor.until(
        lambda: visitor.last("status")["state"] == "running" and visitor.last("status")["t_s"] > 0.1
    )
    visitor.call("pause")
    visitor.status(state="paused", t_s=now_s(opened))
    steps = opened.run.loop.steps
    visitor.listen(0.15)
    assert opened.run.loop.steps == steps


def test_speed_and_costs_are_unknown_until_there_is_a_step_and_while_time_stands(visitor: Visitor) -> None:
    assert visitor.last("status")["real_time_factor"] is None
    visitor.call("play")
    visitor.until(lambda: visitor.last("status")["real_time_factor"])
    assert sum(visitor.last("status")["share"].values()) == pytest.approx(1.0)
    visitor.call("pause")
    assert visitor.status(state="paused")["real_time_factor"] is None


def test_it_runs_to_a_time(visitor: Visitor, golden: Golden) -> None:
    visitor.call("run_to", t_s=0.19)
    visitor.status(state="paused", t_s=0.2)
    with golden.raises(RefusedError):
        visitor.call("run_to", t_s=0.1)


def test_it_takes_steps(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step")
    assert now_s(opened) == 0.02
    visitor.call("step", n=3)
    visitor.status(state="paused", t_s=0.08)


def test_it_is_not_said_to_be_running_while_it_takes_steps(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    states: list[tuple[float, str]] = []
    send_json = opened.session.hub.send_json

    def noting(topic: str, value: Any, t_ns: int = 0) -> None:
        if topic == "/cockpit/status":
            states.append((value["t_s"], value["state"]))
        send_json(topic, value, t_ns)

    monkeypatch.setattr(reports, "STATUS_S", 0.0)  # a report after each step
    monkeypatch.setattr(opened.session.hub, "send_json", noting)
    visitor.call("step", n=3)
    assert {state for _, state in states} == {"paused"}
    assert {0.02, 0.04, 0.06} <= {t_s for t_s, _ in states}


def test_a_step_back_restores_the_state_before_bit_for_bit(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("seek", t_s=1.1)
    before, where = state(opened), pose(opened)
    visitor.call("step")
    assert state(opened) != before
    visitor.call("step_back")
    assert opened.session.ask(opened.run.result).final_pose["husky"] == where
    assert state(opened) == before or not is_exact(opened)


def test_a_step_back_repeats_what_was_published(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=2)
    visitor.call("publish", topic=COLOUR, value="red")
    visitor.call("step", n=2)
    before = state(opened)
    visitor.call("step")
    visitor.call("step_back")
    assert state(opened) == before


def test_a_body_that_was_placed_is_still_there_after_a_step_back(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=2)
    visitor.call("place", body="husky", position=[1, 0.5, 0.3], orientation=[0, 0, 0, 1])
    visitor.call("step", n=3)
    before = state(opened)
    visitor.call("step")
    visitor.call("step_back")
    assert state(opened) == before


def test_a_move_is_not_undone_over_a_later_one_of_somebody_else(opened: Cockpit, visitor: Visitor) -> None:
    there = {"body": "left_vr_screen", "orientation": [0, 0, 0, 1]}
    first = visitor.call("place", **there, position=[1, 0, 0])["number"]
    with opened.visit() as other:
        second = other.call("place", **there, position=[2, 0, 0])["number"]
        with pytest.raises(RefusedError):
            visitor.call("place", **there, position=[0, 0, 0], undoes=first)
        assert opened.run.world.model_motion("left_vr_screen").pose.position == (2, 0, 0)
        other.call("place", **there, position=[1, 0, 0], undoes=second)
    visitor.call("place", **there, position=[0, 0, 0], undoes=first)
    assert opened.run.world.model_motion("left_vr_screen").pose.position == (0, 0, 0)
    visitor.call("reset", what="all")
    with pytest.raises(RefusedError):
        visitor.call("place", **there, position=[1, 0, 0], undoes=first)


def test_a_body_that_is_placed_while_nothing_runs_is_seen_there_at_once(visitor: Visitor) -> None:
    visitor.subscribe("/gazebo/model_states")
    visitor.call("step", n=2)
    seen = visitor.heard["/gazebo/model_states"]
    visitor.until(lambda: seen and seen[-1].t_ns == 40_000_000)
    before = len(seen)
    visitor.call("place", body="husky", position=[1, 0.5, 0.3], orientation=[0, 0, 0, 1])
    visitor.until(lambda: len(seen) > before)
    assert seen[-1].t_ns == 40_000_000
    assert seen[-1].payload != seen[-2].payload


@pytest.mark.one_of(8)
@pytest.mark.parametrize("topic", ["/tf", "/gazebo/model_states"])
def test_poses_are_those_of_the_last_step_although_not_each_step_sends_them(
    visitor: Visitor, topic: str
) -> None:
    visitor.subscribe(topic)
    for n, end_ns in ((1, 20_000_000), (1, 40_000_000), (1, 60_000_000), (17, 400_000_000)):
        visitor.call("step", n=n)
        visitor.until(lambda end_ns=end_ns: visitor.heard[topic] and visitor.heard[topic][-1].t_ns == end_ns)
    assert len({heard.t_ns for heard in visitor.heard[topic]}) < 15  # of 20 steps


def test_the_future_is_lived_as_it_was_until_somebody_steers(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=2)
    visitor.call("publish", topic=COLOUR, value="red")
    visitor.call("step", n=8)
    end = state(opened)
    visitor.call("seek", t_s=0.0)
    visitor.call("seek", t_s=0.2)
    assert state(opened) == end
    visitor.call("seek", t_s=0.0)
    visitor.call("publish", topic=COLOUR, value="blue")
    visitor.call("seek", t_s=0.2)
    assert state(opened) != end


@pytest.mark.one_of(3)
def test_a_seek_goes_forward_and_back(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("seek", t_s=0.5)
    there = state(opened)
    visitor.call("seek", t_s=2.2)
    visitor.call("seek", t_s=0.5)
    assert state(opened) == there
    visitor.status(state="paused", t_s=0.5)


def test_a_snapshot_is_restored(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=5)
    taken = visitor.call("snapshot")
    assert taken["t_s"] == 0.1
    visitor.call("step")
    after, where = state(opened), pose(opened)
    visitor.call("step", n=5)
    visitor.call("restore", id=taken["id"])
    assert now_s(opened) == 0.1
    visitor.call("step")
    assert opened.session.ask(opened.run.result).final_pose["husky"] == where
    assert state(opened) == after or not is_exact(opened)
    shown = visitor.until(lambda: (visitor.last("timeline") or {}).get("snapshots"))
    assert taken | {"left": False} in shown
    with pytest.raises(RefusedError, match="'s0'"):
        visitor.call("restore", id="s0")


def test_a_snapshot_of_another_way_has_no_past(opened: Cockpit, visitor: Visitor, golden: Golden) -> None:
    visitor.call("step", n=5)
    taken = visitor.call("snapshot")
    visitor.call("reset", what="all")
    visitor.call("publish", topic=COLOUR, value="red")
    visitor.call("step")
    visitor.call("restore", id=taken["id"])
    with golden.raises(RefusedError):
        visitor.call("step_back")


def test_a_reset_begins_again(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=4)
    after = state(opened)
    visitor.call("reset", what="all")
    assert now_s(opened) == 0.0
    visitor.call("step", n=4)
    assert state(opened) == after
    with pytest.raises(RefusedError, match="'brian'"):
        visitor.call("reset", what="brian")


def test_a_part_is_reset_alone_and_that_is_lived_again(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=10)
    resting = opened.session.ask(opened.run.brain.snapshot)
    visitor.call("reset", what="brain")
    assert now_s(opened) == pytest.approx(0.2)
    assert opened.session.ask(opened.run.brain.snapshot) != resting
    visitor.call("step", n=5)
    visitor.call("reset", what="robot")
    visitor.call("step", n=5)
    after = state(opened)
    visitor.call("seek", t_s=0.22)
    visitor.call("seek", t_s=0.4)
    assert now_s(opened) == pytest.approx(0.4)
    assert state(opened) == after or not is_exact(opened)


def test_the_pace_is_kept_and_a_slow_pace_delays_no_call(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("pace", factor=0.001)
    visitor.call("play")
    visitor.until(lambda: now_s(opened) > 0, 5)  # a step takes 20 s
    visitor.call("pause")
    assert now_s(opened) < 1
    with pytest.raises(RefusedError, match=r"0\.0001"):
        visitor.call("pace", factor=0)


def test_the_end_of_a_run_is_the_end_until_it_goes_back(
    opened: Cockpit, visitor: Visitor, golden: Golden
) -> None:
    end_ns = opened.run.experiment.duration
    opened.run.experiment.__dict__["duration"] = 200_000_000
    try:
        visitor.call("step", n=10)
        visitor.status(state="finished", t_s=0.2)
        with golden.raises(RefusedError):
            visitor.call("play")
        visitor.call("step_back")
        visitor.status(state="paused", t_s=0.18)
    finally:
        opened.run.experiment.__dict__["duration"] = end_ns


def test_the_page_shows_the_warnings_of_checks(tmp_path: Path) -> None:
    function = """
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def {}(t):
    return geometry_msgs.msg.Twist()
"""
    functions = tmp_path / "twice.py"
    functions.write_text(function.format("drive") + function.format("drive_too"))
    given = [f"transfer_functions=[{functions}]", SMALL]
    with open_run("braitenberg_husky", given, Hub()) as session:
        told = [one.code for one in session.run.problems]
        session.functions.close()
    assert told.count(Code.NRP229) == 1
