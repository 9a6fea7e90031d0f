"""The findings of a check are one warning of an environment, in each process."""

import warnings
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from nrp_lab.gym import make_env, make_vec

from nrp_core.findings import Code

ONE = """
@nrp.Neuron2Robot(Topic("/pioneer/cmd_vel", geometry_msgs.msg.Twist))
def {}(t):
    return geometry_msgs.msg.Twist()
"""
DOUBT = f"[{Code.NRP229.name}]"
"""Two functions command one drive."""
SETTINGS: dict[str, Any] = {"observe": ["motion:pioneer"]}


@pytest.fixture
def twice(tmp_path: Path) -> list[str]:
    """The settings of the slalom with two functions that command its one drive."""
    functions = tmp_path / "twice.py"
    functions.write_text(ONE.format("drive") + ONE.format("drive_too"))
    return [f"transfer_functions=[{functions}]", "criteria=null", f"name=of {tmp_path.name}"]


def test_an_environment_repeats_the_warnings_of_checks_once(twice: list[str]) -> None:
    with pytest.warns(UserWarning, match="nrp validate warns") as told:
        made = make_env("slalom_pioneer", twice, **SETTINGS)
    with closing(made):
        for _ in range(2):
            made.reset(seed=1)
            made.step({})
        assert Code.NRP229 in {one.code for one in made.run.problems}
    assert [str(one.message).count(DOUBT) for one in told] == [1]
    with closing(make_vec("slalom_pioneer", twice, num_envs=2, **SETTINGS)) as copies:
        assert all(Code.NRP229 in {one.code for one in run.problems} for run in copies.runs)


@pytest.mark.heavy
def test_copies_in_several_processes_warn_once(twice: list[str]) -> None:
    with pytest.warns(UserWarning, match="nrp validate warns") as told:
        make_vec("slalom_pioneer", twice, num_envs=2, processes=2, **SETTINGS).close()
    assert [str(one.message).count(DOUBT) for one in told] == [1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make_vec("slalom_pioneer", twice, num_envs=2, processes=2, **SETTINGS).close()


def test_a_topic_that_only_the_agent_publishes_is_not_reported(tmp_path: Path) -> None:
    agent = {**SETTINGS, "act": {"/pioneer/cmd_vel": {"linear.x": (0, 1)}, "/pioneer/clearance": None}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make_env("slalom_pioneer", ["transfer_functions=[]"], **agent).close()
    with pytest.warns(UserWarning, match="no transfer function and no event publishes on '/pioneer/clear"):
        make_env("slalom_pioneer", ["transfer_functions=[]", f"name=of {tmp_path.name}"], **SETTINGS).close()


def test_topics_that_only_a_comparison_reads_are_not_reported() -> None:
    """Its section varies an event that these settings leave out."""
    seen = {"observe": ["motion:husky"], "act": {"/husky/cmd_vel": {"linear.x": (0, 1)}}}
    bare = ["transfer_functions=[]", "criteria=null", "events=null"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make_env("braitenberg_husky", bare, **seen).close()
