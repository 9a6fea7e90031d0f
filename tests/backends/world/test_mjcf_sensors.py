"""Sensors of MJCF are messages with the numbers of MuJoCo alone."""

from __future__ import annotations

from copy import copy
from math import inf
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from nrp_world_mujoco.muscles import COMPLETE, PresentState

from nrp_core import World, worlds
from nrp_core.findings import Code
from nrp_core.messages.base import type_name
from nrp_core.scene.sdf import read_scene

BODY = """<mujoco model="body"><compiler angle="radian"/>
  <option cone="elliptic" integrator="implicitfast" timestep="0.002" magnetic="0.2 -0.5 0.1"/>
  <worldbody><geom name="floor" type="plane" size="5 5 0.1"/><site name="room" pos="1 2 0.5" euler="0 0 0.4"/>
    <body name="torso" pos="0 0 0.6" euler="0.1 0.2 0.3"><freejoint/>
      <geom name="trunk" type="box" size="0.2 0.15 0.1" mass="3"/>
      <site name="chip" pos="0.1 0.05 0.02" euler="0.3 0 0.2"/>
      <site name="belly" type="box" size="0.3 0.3 0.3"/>
      <site name="eye" pos="0 0 -0.12" euler="3.14159 0 0"/>
      <camera name="view" pos="0.2 0 0" euler="0 0.5 0"/>
      <body name="leg" pos="0.1 0 -0.1"><joint name="hip" axis="0 1 0" ref="0.3" damping="0.5"/>
        <geom name="shin" type="capsule" fromto="0 0 0 0 0 -0.3" size="0.03" mass="0.5"/>
        <site name="knee" pos="0 0 -0.1"/></body>
      <body name="arm" pos="-0.1 0.1 0.1"><joint name="slide" type="slide" axis="0 0 1" damping="4"/>
        <geom name="fist" type="sphere" size="0.05" pos="0 0.1 0.2" mass="0.2"/>
        <site name="tip" pos="0 0.1 0.3"/></body>
    </body></worldbody>
  <tendon><spatial name="cord"><site site="chip"/><site site="knee"/></spatial></tendon>
  <actuator><muscle name="pull" tendon="cord" lengthrange="0.1 0.4" force="40"/></actuator>
  <sensor>
    <accelerometer name="acc" site="chip"/><gyro name="turn" site="chip"/>
    <magnetometer name="compass" site="chip"/><velocimeter name="speed" site="chip"/>
    <force name="load" site="knee"/><torque name="strain" site="knee"/>
    <touch name="landing" site="belly"/><rangefinder name="height" site="eye" cutoff="4"/>
    <rangefinder name="sky" site="tip"/>
    <jointpos name="angle" joint="hip"/><jointvel name="rate" joint="slide"/>
    <tendonpos name="span" tendon="cord"/><actuatorfrc name="tension" actuator="pull"/>
    <framepos name="where" objtype="xbody" objname="torso"/>
    <framequat name="attitude" objtype="xbody" objname="torso"/>
    <framepos name="mass" objtype="body" objname="leg" reftype="site" refname="room"/>
    <framequat name="gaze" objtype="camera" objname="view" reftype="site" refname="room"/>
    <framezaxis name="up" objtype="geom" objname="shin"/>
    <framelinvel name="flight" objtype="site" objname="tip"/>
    <frameangacc name="jerk" objtype="xbody" objname="leg"/>
    <subtreecom name="balance" body="torso"/><subtreeangmom name="spin" body="leg"/>
    <clock name="clock"/><contact name="pair" geom1="floor"/><user name="mine" dim="2"/>
  </sensor></mujoco>"""
NUMBERS = {
    "acc": ("chip/imu", "linear_acceleration"), "turn": ("chip/imu", "angular_velocity"),
    "compass": ("compass", "magnetic_field"), "speed": ("speed", "twist.linear"),
    "load": ("knee/wrench", "wrench.force"), "strain": ("knee/wrench", "wrench.torque"),
    "landing": ("landing", "data"), "height": ("height", "range"), "rate": ("rate", "data"),
    "span": ("span", "data"), "tension": ("tension", "data"),
    "where": ("torso/pose", "pose.position"), "attitude": ("torso/pose", "pose.orientation"),
    "mass": ("leg/pose", "pose.position"), "gaze": ("view/pose", "pose.orientation"),
    "up": ("up", "vector"), "flight": ("tip/twist", "twist.linear"),
    "jerk": ("leg/accel", "accel.angular"), "balance": ("balance", "point"), "spin": ("spin", "vector"),
    "clock": ("clock", "data"),
}  # fmt: skip
"""The topic, below that of the model, and the field of each sensor."""


def opened(folder: Path, engine: str = "mujoco") -> World:
    (folder / "body.xml").write_text(BODY)
    backend = worlds().load(engine)
    return backend.open(
        read_scene(folder / "body.xml"), seed=1, options=backend.options.model_validate({"timestep": "2 ms"})
    )


def numbers(message: Any, path: str) -> list[float]:
    for name in path.split("."):
        message = getattr(message, name)
    if isinstance(message, float):
        return [message]
    return [getattr(message, axis) for axis in ("wxyz" if hasattr(message, "w") else "xyz")]


@pytest.mark.parametrize("steps", [50, 250])
def test_every_sensor_has_the_numbers_of_mujoco_alone(tmp_path: Path, steps: int) -> None:
    model = mujoco.MjModel.from_xml_string(BODY)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, steps)
    mujoco.mj_forward(model, data)
    with opened(tmp_path) as world:
        heard = {topic: world.subscribe(f"/torso/{topic}") for topic, _ in NUMBERS.values()}
        world.run_until(steps * 2_000_000)
        for name, (topic, path) in NUMBERS.items():
            assert heard[topic].latest is not None, topic
            found = numbers(heard[topic].latest.message, path)
            np.testing.assert_allclose(found, data.sensor(name).data, rtol=1e-6, atol=1e-8, err_msg=name)
    assert (data.sensor("landing").data[0] > 0) == (steps == 250)


def test_messages_have_frames_units_and_what_is_not_measured(tmp_path: Path) -> None:
    with opened(tmp_path) as world:
        topics = ("chip/imu", "torso/pose", "leg/pose", "sky", "height", "angle")
        heard = {name: world.subscribe(f"/torso/{name}") for name in topics}
        world.run_until(100_000_000)
        imu, pose, relative, sky, height, angle = (heard[name].latest.message for name in topics)
        assert imu.header.frame_id == "torso/chip"
        assert (imu.orientation_covariance[0], imu.angular_velocity_covariance[0]) == (-1.0, 0.0)
        assert (pose.header.frame_id, relative.header.frame_id) == ("world", "torso/room")
        assert (sky.range, sky.max_range) == (inf, inf)
        assert (height.range < 1, height.max_range) == (True, 4.0)
        assert world.topics["/torso/angle"].unit == "rad"
        assert world.topics["/torso/rate"].unit == "m/s"
        joints = world.joint_states("torso")
        assert angle.data == pytest.approx(joints.positions[joints.names.index("hip")], abs=1e-12)
        assert type_name(world.topics["/torso/balance"].type) == "geometry_msgs/msg/PointStamped"


def test_sensors_without_a_message_are_counted_in_one_line(tmp_path: Path) -> None:
    with opened(tmp_path) as world:
        (line,) = [each.message for each in world.warnings if each.code is Code.NRP260]
    assert "2 sensors (contact, user)" in line


def test_an_engine_without_them_says_so_and_has_no_topic(tmp_path: Path) -> None:
    with opened(tmp_path, "pybullet") as world:
        lacking = {each.subject for each in world.warnings if each.code is Code.NRP260}
        assert {"chip/imu", "landing", "clock"} <= lacking
        assert "/torso/clock" not in world.topics


def test_frames_of_one_body_have_messages_of_their_own(tmp_path: Path) -> None:
    """Its origin, its centre of mass, and the latter relative to a site, which has the name of the body."""
    frames = {"heart": "body", "origin": "xbody"}
    more = "".join(
        f'<framepos name="{name}" objtype="{kind}" objname="leg"/>' for name, kind in frames.items()
    )
    text = BODY.replace("</sensor>", more + "</sensor>")
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(text))
    mujoco.mj_forward(mujoco.MjModel.from_xml_string(text), data)
    (tmp_path / "body.xml").write_text(text)
    backend = worlds().load("mujoco")
    with backend.open(read_scene(tmp_path / "body.xml"), seed=1, options=backend.options()) as world:
        heard = {name: world.subscribe(f"/torso/{name}") for name in (*frames, "leg/pose")}
        world.run_until(2_000_000)
        for name in frames:
            found = numbers(heard[name].latest.message, "pose.position")
            np.testing.assert_allclose(found, data.sensor(name).data, atol=1e-3)
        assert heard["leg/pose"].latest.message.header.frame_id == "torso/room"


def test_sensors_of_the_same_state_depend_on_the_gains_of_a_copy():
    weak = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody><actuator>"
        "<position name='a' joint='j' kp='1'/></actuator>"
        "<sensor><actuatorfrc actuator='a'/></sensor></mujoco>"
    )
    strong = copy(weak)
    strong.actuator_biasprm[:, 1] = -5.0
    state, present = np.zeros(mujoco.mj_stateSize(weak, COMPLETE)), PresentState(weak)
    data = mujoco.MjData(weak)
    data.qpos[0] = 0.5
    mujoco.mj_getState(weak, data, state, COMPLETE)
    assert [present.sensor(m, state, 0).item() for m in (weak, strong, weak)] == [-0.5, -2.5, -0.5]
