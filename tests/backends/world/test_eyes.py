"""Event cameras and retinas see through every renderer what a camera would, in both engines."""

from __future__ import annotations

from math import exp, log

import numpy as np
import pytest

from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.model import Box, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.robot_setup import AddedSensor, with_added_sensors

LENS = {"camera": {"horizontal_fov": 0.9, "image": {"width": 16, "height": 12}}}
LIGHT, DARK = ColorRGBA(0.8, 0.8, 0.8, 1.0), ColorRGBA(0.2, 0.2, 0.2, 1.0)


def scene_with(parts, sensor: AddedSensor) -> Scene:
    """Return a room with a screen that fills the view of a sensor."""
    screen = parts.prop(
        "screen", Box((0.1, 9, 9)), Pose((3.0, 0.0, 0.5)), rgba=(0.2, 0.2, 0.2, 1), solid=False
    )
    return Scene((screen, with_added_sensors(parts.husky(), (sensor,))))


def base_of(parts) -> str:
    return parts.husky().links[0].name


@pytest.mark.one_of(3)
@pytest.mark.parametrize("renderer", ["raster", "realistic"])
def test_an_event_camera_reports_that_a_screen_brightens(open_world, parts, renderer):
    link = base_of(parts)
    settings = LENS | {"event_camera": {"threshold": 0.25}}
    sensor = AddedSensor("event_camera", link, "dvs", Pose((0.6, 0.0, 0.4)), 100.0, settings)
    world = open_world(scene_with(parts, sensor), renderer=renderer)
    heard = world.subscribe(f"/husky/{link}/dvs/events")
    packed = world.subscribe(f"/husky/{link}/dvs/events/packets")
    world.run_until(100_000_000)
    assert heard.latest.message.events == []
    (color,) = [topic for topic in world.topics if topic.startswith("/screen/") and topic.endswith("/color")]
    world.advertise(color).publish(LIGHT)
    found, packets = [], []
    for n in range(1, 5):
        world.run_until(100_000_000 + n * 10_000_000)
        found += heard.latest.message.events
        packets.append(packed.latest.message)
    assert all(event.polarity for event in found)
    per_pixel = np.zeros((12, 16), int)
    for event in found:
        per_pixel[event.y, event.x] += 1
    if renderer == "raster":  # flat colours: the formula holds in each pixel
        wanted = int(log((204 / 255 + 0.001) / (51 / 255 + 0.001)) / 0.25)
        assert (per_pixel == wanted).all()
    assert per_pixel.min() > 0
    words = np.concatenate([packet.events for packet in packets]).view("<u8")
    bases = np.concatenate([np.full(packet.events.size // 8, packet.time_base) for packet in packets])
    unpacked = [
        (int(w >> np.uint64(32)) & 0xFFFF, int(w >> np.uint64(48)) & 0x7FFF, int(w) % 2**32 + int(base))
        for w, base in zip(words, bases, strict=True)
    ]
    assert unpacked == [(e.x, e.y, e.ts.sec * 10**9 + e.ts.nanosec) for e in found]


def test_a_retina_adapts_to_an_even_screen_and_responds_to_an_edge(open_world, parts):
    link = base_of(parts)
    settings = LENS | {"retina": {"baseline": 10, "gain": 50, "sustained": 0.25, "adaptation": 0.1}}
    sensor = AddedSensor("retina", link, "eye", Pose((0.6, 0.0, 0.4)), 50.0, settings)
    left = parts.prop("left", Box((0.1, 4, 9)), Pose((2.9, 2.0, 0.5)), rgba=(0.8, 0.8, 0.8, 1), solid=False)
    scene = scene_with(parts, sensor)
    world = open_world(Scene((*scene.models, left)))
    heard = world.subscribe(f"/husky/{link}/eye/rates")
    world.run_until(20_000_000)
    first = heard.latest.message.data
    assert first.shape == (12, 16, 2)
    assert first[6, 0] == pytest.approx((10, 10), abs=0.5)  # far from the edge
    on, off = first[6, :, 0], first[6, :, 1]
    assert on[:8].max() > 12 > on[8:].max()  # the left side of the edge is bright
    assert off[8:].max() > 12 > off[:8].max()
    world.run_until(520_000_000)
    assert heard.latest.message.data[6, :, 0] == pytest.approx(on, abs=1e-3)  # it began adapted
    (color,) = [topic for topic in world.topics if topic.startswith("/left/") and topic.endswith("/color")]
    world.advertise(color).publish(DARK)
    peak = on[:8].max() - 10
    world.run_until(540_000_000)
    world.run_until(560_000_000)
    sunk = 10 - heard.latest.message.data[6, :8, 0].min()
    assert sunk == pytest.approx(3 * peak * exp(-0.02 / 0.1), rel=0.2)
