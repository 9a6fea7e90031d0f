"""Cameras of SDF that take an image for each message."""

from __future__ import annotations

import pytest

from nrp_core.messages.std_msgs import Bool
from nrp_core.scene.sdf import read_scene

ROOM = """<sdf version="1.9"><world name="w"><model name="m"><static>true</static><link name="l">
  <sensor name="s" type="{}"><topic>eye</topic><update_rate>5</update_rate><camera>
  <triggered>true</triggered>{}<image><width>4</width><height>3</height></image></camera></sensor>
  </link></model></world></sdf>"""


@pytest.mark.parametrize(
    ("kind", "given", "topic"),
    [
        ("camera", "", "/m/eye/trigger"),
        ("camera", "<trigger_topic>/shoot</trigger_topic>", "/shoot"),
        ("depth_camera", "<trigger_topic>shoot</trigger_topic>", "/m/shoot"),
    ],
)
def test_a_triggered_camera_takes_one_image_for_each_message(open_world, tmp_path, kind, given, topic):
    path = tmp_path / "room.sdf"
    path.write_text(ROOM.format(kind, given))
    world = open_world(scene := read_scene(path))
    assert not scene.warnings
    step_ns = world.engine.step_ns
    seen, trigger = world.subscribe("/m/eye"), world.advertise(topic)
    world.run_until(50 * step_ns)
    trigger.publish(Bool(False))
    world.run_until(100 * step_ns)
    assert seen.latest is None
    trigger.publish(Bool(True))
    trigger.publish(Bool(True))
    world.run_until(200 * step_ns)
    times = [stamped.t_ns for stamped in seen.take()]
    trigger.publish(Bool(True))
    world.run_until(300 * step_ns)
    times += [stamped.t_ns for stamped in seen.take()]
    assert times == [101 * step_ns, 201 * step_ns]
    assert seen.latest.message.height == 3
    saved = world.snapshot()
    trigger.publish(Bool(True))
    world.restore(saved)
    world.run_until(400 * step_ns)
    assert not seen.take()
