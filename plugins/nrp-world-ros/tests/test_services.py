"""Programs of ROS call the services of Gazebo.

The client is written here, from the wiki's description of ROS's connections, and knows the check sums that
the packages of ROS have (as generated for other languages), so that nothing is compared with itself.
"""

from __future__ import annotations

import socket
import struct
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit
from xmlrpc.client import ServerProxy

import pytest
from nrp_core import worlds
from nrp_core.errors import TopicError
from nrp_core.messages import gazebo_srvs, std_srvs
from nrp_core.world import Findings, Scene, World

from conftest import CALLS, Ros, needs_ros
from nrp_world_ros.bridge import Calls
from nrp_world_ros.node import Answer
from nrp_world_ros.ros1 import CODEC

SUMS = {
    "ApplyBodyWrench": "585b9f9618aa0581b207e2f2d90866bc",
    "BodyRequest": "5eade9afe7f232d78005bd0cafeab755",
    "GetJointProperties": "7b30be900f50aa21efec4a0ec92d91c9",
    "GetModelProperties": "5717f7bd34ed990fa80e28b3015027a3",
    "GetModelState": "4c515e936d3319c9610c559c60bfc3d4",
    "SetModelState": "5b3ab0281d4f5445def017e3a2e4a07b",
    "SpawnModel": "9ed9c82c96abe1a00c3e8cdaeee24413",
}

STD_SUMS = {"SetBool": "09fb03525b03e7ea1fd3992bafd87e16", "Trigger": "937c9679a518e3a18d831e57125ea522"}


@pytest.mark.parametrize("service", STD_SUMS)
def test_the_check_sums_of_standard_services_are_those_of_std_srvs(service: str) -> None:
    names = [CODEC.name(getattr(std_srvs, service + part)) for part in ("Request", "Response")]
    assert CODEC.service_md5(*names) == STD_SUMS[service]


@pytest.mark.parametrize("service", SUMS)
def test_the_check_sums_of_services_are_those_of_gazebo(service: str) -> None:
    names = [CODEC.name(getattr(gazebo_srvs, service + part)) for part in ("Request", "Response")]
    assert CODEC.service_md5(*names) == SUMS[service]


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def call(ros: Ros, service: str, md5: str, request: bytes) -> tuple[bool, bytes]:
    """Call a service, and return whether it was done and what it answered."""
    with ServerProxy(ros.env["ROS_MASTER_URI"]) as master:
        parts = urlsplit(str(master.lookupService("/client", service)[2]))  # type: ignore[index]
    with (
        socket.create_connection((parts.hostname, parts.port), timeout=60) as line,
        line.makefile("rb") as stream,
    ):
        fields = b"".join(text(f"{key}={value}") for key, value in {
            "callerid": "/client", "service": service, "md5sum": md5, "persistent": "0"
        }.items())  # fmt: skip
        line.sendall(struct.pack("<I", len(fields)) + fields)
        header = stream.read(*struct.unpack("<I", stream.read(4)))
        assert b"error=" not in header, header
        line.sendall(struct.pack("<I", len(request)) + request)
        done = stream.read(1) == b"\x01"
        return done, stream.read(*struct.unpack("<I", stream.read(4)))


@needs_ros
@pytest.mark.slow
def test_a_ros_node_moves_the_robot_and_receives_the_reasons_of_refusals(bridged: Ros) -> None:
    motion = struct.pack("<7d", 1.0, 2.0, 0.2, 0, 0, 0, 1) + bytes(48)
    service, md5 = "/gazebo/set_model_state", SUMS["SetModelState"]
    assert call(bridged, service, md5, text("husky") + motion + text("world")) == (True, b"\x01" + text(""))
    reply = call(bridged, "/gazebo/get_model_state", SUMS["GetModelState"], text("husky") + text("world"))[1]
    frame = struct.unpack_from("<I", reply, 12)[0]
    assert struct.unpack_from("<2d", reply, 16 + frame) == pytest.approx((1.0, 2.0), abs=0.05)
    done, answer = call(bridged, service, md5, text("huskie") + motion + text("world"))
    assert done
    assert answer.startswith(b"\x00")
    assert b"no model 'huskie'; did you mean 'husky'" in answer


@needs_ros
@pytest.mark.slow
def test_answers_without_a_field_are_empty_and_have_room_for_an_error(bridged: Ros) -> None:
    empty = "d41d8cd98f00b204e9800998ecf8427e"
    for service in ("/gazebo/pause_physics", "/gazebo/unpause_physics"):
        assert call(bridged, service, empty, b"") == (True, b"")
    done, why = call(bridged, "/gazebo/clear_body_wrenches", SUMS["BodyRequest"], text("husky::nose"))
    assert not done
    assert b"no link 'nose'" in why


@needs_ros
@pytest.mark.slow
def test_a_loop_calls_the_services_of_its_body(ros: Ros) -> None:
    ros.body("--lockstep")
    ros.run(sys.executable, "-c", CALLS, "1")


class Offered:
    """A node that keeps what it is to answer calls with."""

    returns_errors = True
    codec = CODEC

    def __init__(self) -> None:
        self.answers: dict[str, Answer] = {}

    def serve(self, service: str, _request: str, _response: str, answer: Answer) -> None:
        self.answers[service] = answer


@contextmanager
def offered() -> Iterator[tuple[Calls, Answer, World]]:
    """Yield the calls of an empty world, and the service that pauses it."""
    backend, node = worlds().load("mujoco"), Offered()
    with backend.open(Scene(()), seed=1, options=backend.options()) as world:
        calls = Calls(world, node, Findings())  # type: ignore[arg-type]
        calls.offer()
        yield calls, node.answers["/gazebo/pause_physics"], world


def test_a_call_whose_caller_has_gone_is_not_executed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nrp_world_ros.bridge.PATIENCE_S", 0.01)
    with offered() as (calls, pause, world):
        asked = pause(b"")
        time.sleep(0.02)
        calls.answer()
        assert not world.paused
        assert not asked.done()


def test_calls_that_wait_are_refused_when_the_world_closes_and_later_ones_too() -> None:
    with offered() as (calls, pause, world):
        asked = pause(b"")
        calls.close()
        for each in (asked, pause(b"")):
            with pytest.raises(TopicError, match=r"pause_physics.*closed"):
                each.result(0)
        calls.answer()
        assert not world.paused


def test_calls_above_the_limit_are_refused_at_once_and_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nrp_world_ros.bridge.MOST", 2)
    with offered() as (calls, pause, world):
        asked = [pause(b"") for _ in range(3)]
        with pytest.raises(TopicError, match="pause_physics: 2"):
            asked[2].result(0)
        calls.answer()
        assert [each.done() for each in asked] == [True] * 3
        assert world.paused
        assert "1 calls were refused" in str(calls._warnings[0])
