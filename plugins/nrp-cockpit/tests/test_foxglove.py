"""Programs that know the protocol and nothing of the cockpit understand what it sends."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from visitors import Cockpit, Visitor, cockpit

SDK, SPECIFICATION = "foxglove.sdk.v1", "foxglove.websocket.v1"


@pytest.fixture(scope="module")
def opened() -> Iterator[Cockpit]:
    with cockpit() as opened:
        opened.session.ask(lambda: opened.session.set_pace(None))
        yield opened


@pytest.fixture(scope="module")
def visitor(opened: Cockpit) -> Iterator[Visitor]:
    """Somebody who heard two seconds of everything."""
    with opened.visit() as visitor:
        visitor.subscribe(*visitor.channels)
        visitor.until(lambda: visitor.heard["/scene"])  # the subscriptions are in force
        visitor.call("publish", topic="/left_vr_screen/body/screen_glass/color", value="red")
        visitor.call("seek", t_s=2.0)
        before, now = -1, 0
        while now > before:  # nothing is on its way any more
            visitor.listen(0.5)
            before, now = now, sum(map(len, visitor.heard.values()))
        yield visitor


def decoded(visitor: Visitor, topic: str) -> list[tuple[int, Any]]:
    """Return the messages on a topic, read by another implementation with the schema that was sent along."""
    decode = decoder_of(visitor.channels[topic])
    return [(heard.t_ns, decode(heard.payload)) for heard in visitor.heard[topic]]


def decoder_of(channel: dict[str, Any]) -> Callable[[bytes], Any]:
    schema = Schema(
        id=channel["id"],
        name=channel["schemaName"],
        encoding=channel["schemaEncoding"],
        data=channel["schema"].encode(),
    )
    decode = DecoderFactory().decoder_for(channel["encoding"], schema)
    assert decode is not None
    return decode


@pytest.mark.parametrize(
    ("offered", "chosen"),
    [
        ((SPECIFICATION,), SPECIFICATION),
        ((SDK,), SDK),
        ((SPECIFICATION, SDK), SDK),
        (("other.v1", SPECIFICATION), SPECIFICATION),
    ],
)
def test_the_first_of_its_names_of_the_protocol_is_chosen(
    opened: Cockpit, offered: tuple[str, ...], chosen: str
) -> None:
    with opened.visit(protocols=offered) as visitor:
        assert visitor.connection.subprotocol == chosen


def test_every_schema_can_be_read(visitor: Visitor) -> None:
    cdr = [channel for channel in visitor.channels.values() if channel["encoding"] == "cdr"]
    assert len(cdr) > 10
    for channel in cdr:
        assert decoder_of(channel)


def test_every_message_can_be_read(visitor: Visitor) -> None:
    cdr = [topic for topic, channel in visitor.channels.items() if channel["encoding"] == "cdr"]
    read = {topic for topic in cdr if decoded(visitor, topic)}
    assert {"/scene", "/tf", "/gazebo/model_states", "/husky/camera", "/husky/cmd_vel"} <= read
    assert any(topic.endswith("/spikes") for topic in read)
    assert any(topic.startswith("/brain/devices/") for topic in read)


def test_spikes_are_those_that_the_result_counts(opened: Cockpit, visitor: Visitor) -> None:
    populations = opened.run.brain.network.populations
    heard = {
        label: sum(len(message.ids) for _, message in decoded(visitor, f"/brain/{label}/spikes"))
        for label in populations
    }
    assert sum(heard.values()) > 0
    assert heard == {label: opened.session.ask(opened.run.result).spikes[label] for label in populations}


def test_an_image_is_the_one_that_the_robot_saw(opened: Cockpit, visitor: Visitor) -> None:
    camera = opened.session.ask(lambda: opened.run.world.subscribe("/husky/camera"))
    visitor.call("step", n=3)
    visitor.listen(0.3)
    seen = camera.since(-1)[-1]
    t_ns, image = decoded(visitor, "/husky/camera")[-1]
    assert t_ns == seen.t_ns
    assert (image.encoding, image.width, image.height) == ("rgb8", seen.message.width, seen.message.height)
    assert np.array_equal(np.frombuffer(image.data, np.uint8), seen.message.data.ravel())
    assert len(np.unique(seen.message.data)) > 3


def test_the_scene_has_the_frames_that_move(visitor: Visitor) -> None:
    _, scene = decoded(visitor, "/scene")[0]
    _, transforms = decoded(visitor, "/tf")[-1]
    frames = {entity.frame_id for entity in scene.entities}
    moving = {each.child_frame_id for each in transforms.transforms}
    assert "world" in frames
    assert frames - {"world"} <= moving
    assert {each.header.frame_id for each in transforms.transforms} == {"world"}
    assert any(entity.models for entity in scene.entities) or any(entity.cubes for entity in scene.entities)


def test_times_go_forward(visitor: Visitor) -> None:
    for topic in ("/tf", "/husky/camera", "/gazebo/model_states"):
        times = [t_ns for t_ns, _ in decoded(visitor, topic)]
        assert len(times) > 10
        assert times == sorted(times)
