"""Joints that a world does not have are refused, in one sentence, before anything moves wrongly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import CapabilityError, SceneError
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Joint, Link, Mimic, Model, Scene
from nrp_core.world.drives.wheels import WheelDrive

TURNS = Joint("first", "continuous", "base", "one")
BALL = Joint("second", "ball", "base", "two")
BACK = replace(TURNS, name="back", child="two")
FOLLOWS = replace(BALL, kind="continuous", mimic=Mimic("first"))


def pair(joint: Joint, *, static: bool = False) -> Scene:
    """Return a scene with a model of two joints."""
    links = tuple(Link(name) for name in ("base", "one", "two"))
    return Scene((Model("pair", links, (TURNS, joint), static=static),))


@pytest.mark.parametrize(("joint", "lacking"), [(BALL, "ball joints"), (FOLLOWS, "coupled joints")])
def test_a_joint_that_the_world_does_not_have_is_refused(
    room: Any, joint: Joint, lacking: str, golden: Golden
) -> None:
    engine = type(room.engine)
    with golden.raises(CapabilityError, match=f"PointEngine.*{lacking}.*'pair/second'"):
        engine(pair(joint))
    assert engine(pair(joint, static=True)).scene.models  # nothing of it moves
    assert engine(pair(BACK)).scene.models


def test_a_ball_that_the_world_cannot_lead_is_refused(room: Any) -> None:
    (model,) = pair(BALL).models
    led = replace(model, controllers=(JointController("second", "position", "/cmd", None),))
    has = replace(room.engine.capabilities, ball_joints=True)
    assert not has.lacking_for(pair(BALL))
    assert has.lacking_for(Scene((led,))) == "has no ball control, such as 'pair/second'"
    assert not replace(has, ball_control=True).lacking_for(Scene((led,)))


@pytest.mark.parametrize(
    ("parts", "what"),
    [
        ({"controllers": (JointController("second", "effort", "/cmd"),)}, "a controller"),
        ({"joints": (replace(TURNS, mimic=Mimic("second")), BALL)}, "the joint 'first'"),
        ({"drives": (WheelDrive("d", "/cmd_vel", ("first",), ("second",), 0.5, 0.2),)}, "the drive 'd'"),
    ],
)
def test_nothing_leads_or_follows_a_ball(parts: dict[str, Any], what: str) -> None:
    (model,) = pair(BALL).models
    message = f"{what} of the model 'pair' names the joint 'second', a ball joint, which has no single axis"
    with pytest.raises(SceneError, match=message):
        Scene((replace(model, **parts),))
