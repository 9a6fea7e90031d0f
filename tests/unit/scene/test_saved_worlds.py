"""The <state> of saved worlds: where things, links and joints were last."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import pytest

from nrp_core.scene.model import Scene
from nrp_core.scene.posture import start_positions

WorldReader = Callable[..., Scene]

LINK = '<link name="l"><inertial/></link>'
ARM = (
    f'<model name="arm"><pose>1 0 0 0 0 {pi / 2}</pose><link name="base"><inertial/></link>'
    '<model name="hand"><pose>0 0 1 0 0 0</pose><link name="palm"><inertial/></link>'
    '<link name="finger"><pose>0 0.2 0 0 0 0</pose><inertial/></link>'
    '<joint name="slide" type="prismatic"><parent>palm</parent><child>finger</child>'
    "<axis><xyz>0 1 0</xyz></axis></joint></model>"
    '<joint name="wrist" type="revolute"><pose>0 0 -0.5 0 0 0</pose><parent>base</parent>'
    "<child>hand::palm</child>"
    "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis></joint></model>"
)


def test_the_names_of_states_of_sdf_1_12_are_read(world: WorldReader) -> None:
    scene = world(
        f'<model name="ball">{LINK}</model>'
        '<light name="lamp" type="point"><pose>0 0 1 0 0 0</pose></light>'
        '<state world_name="room"><model_state name="ball"><pose>1 2 3 0 0 0</pose></model_state>'
        '<light_state name="lamp"><pose>0 0 2 0 0 0</pose></light_state></state>',
        version="1.12",
    )
    assert scene.models[0].pose.position == (1, 2, 3)
    assert scene.lights[0].pose.position == (0, 0, 2)


def test_a_thing_whose_state_has_no_pose_stays(world: WorldReader) -> None:
    scene = world(
        f'<model name="ball"><pose>1 2 3 0 0 0</pose>{LINK}</model>'
        '<state world_name="room"><model name="ball"><scale>1 1 1</scale></model></state>'
    )
    assert scene.models[0].pose.position == (1, 2, 3)


JOINTS = {
    "up to 1.11": (
        '<joint name="wrist"><angle axis="0">0.7</angle></joint>'
        '<model name="hand"><joint name="slide"><angle>0.05</angle></joint></model>'
    ),
    "1.12": (
        '<joint_state name="wrist"><axis_state><position degrees="true">40.107</position></axis_state>'
        '</joint_state><model_state name="hand"><joint_state name="slide"><axis_state><position>0.05'
        "</position></axis_state></joint_state></model_state>"
    ),
    # the arm stands at x = 1 turned a quarter to the left: its y axis points along -x. The wrist, half a
    # metre below the palm, is at 0.7 rad, so the palm leans by 0.5 m * (sin 0.7, cos 0.7) along y and z
    "links": (
        f'<link name="base"><pose>1 0 0 0 0 {pi / 2}</pose></link>'
        f'<link name="hand::palm"><pose>1 0.322109 0.882421 0 0.7 {pi / 2}</pose></link>'
        f'<model name="hand"><link name="palm"><pose>1 0.322109 0.882421 0 0.7 {pi / 2}</pose></link>'
        f'<link name="finger"><pose>0.75 0.322109 0.882421 0 0.7 {pi / 2}</pose></link></model>'
    ),
}


@pytest.mark.parametrize("state", JOINTS.values(), ids=JOINTS)
def test_joints_of_a_saved_world_start_where_they_were(world: WorldReader, state: str) -> None:
    tag = "model_state" if "joint_state" in state else "model"
    scene = world(f'{ARM}<state world_name="room"><{tag} name="arm">{state}</{tag}></state>')
    starts = start_positions(scene.models[0])
    assert starts == pytest.approx({"wrist": 0.7, "hand::slide": 0.05}, abs=1e-5)


def test_a_joint_that_was_beyond_its_limit_starts_at_it(world: WorldReader) -> None:
    state = '<model name="arm"><joint name="wrist"><angle axis="0">2.00001</angle></joint></model>'
    scene = world(f'{ARM}<state world_name="room">{state}</state>')
    assert start_positions(scene.models[0]) == {"wrist": 2.0}


def test_poses_that_are_only_rounded_leave_joints_at_0(world: WorldReader) -> None:
    state = (
        '<model name="arm"><link name="base"><pose>1 0 0 0 0 1.5708</pose></link>'
        '<model name="hand"><link name="palm"><pose>1 0 1 0 2e-6 1.5708</pose></link></model></model>'
    )
    assert not start_positions(world(f'{ARM}<state world_name="room">{state}</state>').models[0])
