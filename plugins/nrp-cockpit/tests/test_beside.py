"""A second run goes in step with the first: another future of it, or the same on other engines."""

from __future__ import annotations

import json
import pickle
from collections.abc import Iterator
from pathlib import Path

import pytest
from golden import Golden
from nrp_cockpit.session import reports
from states import plain
from visitors import Cockpit, RefusedError, Visitor, cockpit

from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code

BREAKS = """

@nrp.MapRobotSubscriber("states", Topic("/gazebo/model_states", gazebo_msgs.msg.ModelStates))
@nrp.Robot2Neuron()
def divides(t, states):
    if t > 0.5:
        1 / len(states.value.name[99:])
"""


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit("world.backend=mujoco", "brain.backend=event", "events.left_red.at=0.1 s") as opened:
        yield opened


@pytest.fixture
def visitor(opened: Cockpit) -> Iterator[Visitor]:
    """Somebody who steers a run that is at 0.6 s."""
    with opened.visit() as visitor:
        visitor.subscribe("/cockpit/status", "/cockpit/comparison")
        visitor.call("reset", what="all")
        visitor.call("pace", factor=None)
        visitor.call("step", n=30)
        yield visitor
        if opened.session.beside is not None:
            visitor.call("part")


TWICE = """

@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drives_too(t):
    return geometry_msgs.msg.Twist()
"""


def runs(opened: Cockpit) -> tuple[Run, Run]:
    assert opened.session.beside is not None
    return opened.run, opened.session.beside.run  # type: ignore[attr-defined]


def states(opened: Cockpit) -> tuple[object, object]:
    """Return all that the loops, brains and worlds of both keep, but for what is kept to be shown."""

    def state(run: Run) -> object:
        session = opened.session if run is opened.run else opened.session.beside
        session.stream.close()  # type: ignore[union-attr]
        sides, loop, own = pickle.loads(run.snapshot())
        return plain((sides, loop, own[:2]))

    one, other = opened.session.ask(lambda: tuple(state(run) for run in runs(opened)))
    return one, other


def test_a_branch_in_which_nothing_changes_is_the_same_to_the_last_bit(
    opened: Cockpit, visitor: Visitor
) -> None:
    visitor.call("branch")
    visitor.call("step", n=25)
    one, other = states(opened)
    assert one == other
    shown = visitor.until(lambda: visitor.last("comparison"))
    visitor.until(lambda: visitor.last("comparison")["distances"][-1][0] == pytest.approx(1.1))
    shown = visitor.last("comparison")
    assert (shown["labels"], shown["since_s"]) == (["The run", "Branch of 0.60 s"], 0.6)
    assert (shown["first"], shown["distance_m"]) == ([], 0)
    assert all(each["one"] == each["other"] for each in shown["spikes"])


def test_a_change_in_a_branch_of_the_past_leaves_the_run_as_it_was(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("step", n=20)
    expected = opened.session.ask(opened.run.result).trajectory_digest
    visitor.call("branch", t_s=0.5)
    with opened.visit(run="beside") as there:
        there.call("place", body="husky", position=[0, 1, 0.2], orientation=[0, 0, 0, 1])
    visitor.call("step", n=25)
    assert opened.session.ask(opened.run.result).trajectory_digest == expected
    visitor.until(lambda: (visitor.last("comparison") or {}).get("distance_m", 0) > 0.5)
    first = {each["what"]: each["t_s"] for each in visitor.last("comparison")["first"]}
    assert first["trajectory"] == pytest.approx(0.52)


def test_both_go_back_together_and_forward_again(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("branch")
    with opened.visit(run="beside") as there:
        there.call("publish", topic="/right_vr_screen/body/screen_glass/color", value="red")
        visitor.call("step", n=60)
        before = states(opened)
        there.call("seek", t_s=0.9)  # whoever looks at the branch moves both
    assert [run.now_s for run in runs(opened)] == [0.9, 0.9]
    visitor.call("seek", t_s=0.2)
    assert [run.now_s for run in runs(opened)] == [0.2, 0.6]  # the branch begins at 0.6 s
    visitor.call("seek", t_s=1.8)
    assert states(opened) == before


def test_edited_functions_are_those_of_the_branch_too(opened: Cockpit, visitor: Visitor) -> None:
    path, source = next(iter(opened.session.functions.texts.items()))
    assert visitor.call("functions/apply", files={path: source + "\n# edited\n"})["applied"]
    visitor.call("branch")
    assert opened.session.beside.functions.texts[path].endswith("# edited\n")  # type: ignore[union-attr]
    visitor.call("step", n=5)
    one, other = states(opened)
    assert one == other
    visitor.call("functions/revert")


def test_a_comparison_begins_at_zero_on_the_other_engines(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("compare", brain="spinnaker", world="pybullet")
    visitor.call("step", n=20)
    one, other = runs(opened)
    assert (one.now_s, other.now_s) == (0.4, 0.4)
    assert (other.brain.capabilities, other.world.capabilities) != (
        one.brain.capabilities,
        one.world.capabilities,
    )
    shown = visitor.until(lambda: visitor.last("comparison"))
    assert shown["labels"] == ["event + mujoco", "spinnaker + pybullet"]
    visitor.call("reset", what="all")
    assert (one.now_s, other.now_s) == (0.0, 0.0)


def test_a_branch_that_fails_leaves_the_run_going(opened: Cockpit, visitor: Visitor) -> None:
    visitor.call("branch")
    beside = opened.session.beside
    with opened.visit(run="beside") as there:
        path, source = next(iter(opened.session.functions.texts.items()))
        broken = source + BREAKS
        assert there.call("functions/apply", files={path: broken})["applied"]
    visitor.call("step", n=5)
    assert (opened.run.now_s, opened.session.mode) == (pytest.approx(0.7), "paused")
    assert beside.mode == "failed"  # type: ignore[union-attr]


def test_impossible_second_runs_are_refused_with_the_reason(
    opened: Cockpit, visitor: Visitor, golden: Golden
) -> None:
    for call, said in (
        (lambda: visitor.call("part"), "there is no second run"),
        (lambda: visitor.call("compare"), "needs a different brain or world"),
        (lambda: visitor.call("compare", brain="evnt"), "evnt"),
        (lambda: visitor.call("branch", id="s999"), "there is no snapshot 's999'"),
    ):
        with pytest.raises(RefusedError, match=said):
            call()
    visitor.call("branch")
    with golden.raises(RefusedError):
        visitor.call("branch")


@pytest.mark.one_of(3)
@pytest.mark.parametrize(("how", "engines"), [("branch", {}), ("compare", {"brain": "spinnaker"})])
def test_a_second_run_shows_the_warnings_of_checks(
    opened: Cockpit, visitor: Visitor, how: str, engines: dict[str, str]
) -> None:
    (name,) = (one for one, text in opened.session.functions.texts.items() if "cmd_vel" in text)
    text = opened.session.functions.texts[name]
    assert visitor.call("functions/apply", files={name: text + TWICE})["applied"]
    try:
        visitor.call(how, **engines)
        assert all(Code.NRP229 in [one.code for one in run.problems] for run in runs(opened))
        visitor.call("part")
        visitor.call("functions/revert")
        visitor.call(how, **engines)
        assert not any(Code.NRP229 in [one.code for one in run.problems] for run in runs(opened))
    finally:
        visitor.call("functions/revert")


def test_a_second_run_shows_the_warnings_about_unedited_files(tmp_path: Path) -> None:
    functions = tmp_path / "twice.py"
    functions.write_text(TWICE + TWICE.replace("drives_too", "drives"))
    with cockpit(f"transfer_functions=[{functions}]") as opened, opened.visit() as visitor:
        visitor.call("branch")
        _, beside = runs(opened)
        assert [one.code for one in beside.problems].count(Code.NRP229) == 1


def test_all_that_is_compared_is_of_one_step(
    opened: Cockpit, visitor: Visitor, monkeypatch: pytest.MonkeyPatch
) -> None:
    visitor.call("branch")
    monkeypatch.setattr(reports, "SLOW_S", 0.0)
    visitor.call("step", n=25)
    visitor.until(lambda: visitor.last("comparison")["distances"][-1][0] == pytest.approx(1.1))
    shown = [json.loads(one.payload) for one in visitor.heard["/cockpit/comparison"]]
    compared = [pair for one in shown if one for pair in one["spikes"]]
    assert len({pair["one"] for pair in compared}) > 10
    assert all(pair["one"] == pair["other"] for pair in compared)
