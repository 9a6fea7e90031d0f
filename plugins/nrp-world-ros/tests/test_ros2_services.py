"""Services of ROS 2, called through Fast DDS and Cyclone DDS, which tie answers to calls in two ways."""

from __future__ import annotations

import random
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_core import worlds
from nrp_core.errors import TopicError
from nrp_core.world import Findings, Scene
from nrp_core.world.messages import gazebo_msgs, gazebo_srvs, std_srvs
from nrp_core.world.messages.base import message
from nrp_core.world.messages.cdr import Codec

from conftest import Ros2, needs_fast_dds, needs_ros2
from nrp_world_ros.calls import Calls
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros
from nrp_world_ros.ros2.rtps import packets
from nrp_world_ros.ros2.rtps.sockets import Sockets

PEER = Path(__file__).with_name("ros2_peer.py")
SET_BOOL = "std_srvs::srv::dds_::SetBool"
ON, OFF = "0001000001", "0001000000"  # CDR of little end, and a byte
CODEC = Codec()


@message("test/msg/EchoRequest")
@dataclass(slots=True)
class EchoRequest:
    letters: str = ""


@message("test/msg/EchoResponse")
@dataclass(slots=True)
class EchoResponse:
    letters: str = ""


def done(response: memoryview) -> Future[memoryview]:
    coming: Future[memoryview] = Future()
    coming.set_result(response)
    return coming


def switch(request: bytes) -> Future[memoryview]:
    asked = CODEC.decode(request, "std_srvs/msg/SetBoolRequest")
    text = "on" if asked.data else "off"
    return done(CODEC.encode(std_srvs.SetBoolResponse(success=asked.data, message=text)))


@pytest.fixture
def node(ros2: Ros2) -> Iterator[Node]:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        node.serve(
            "/switch", CODEC.name(std_srvs.SetBoolRequest), CODEC.name(std_srvs.SetBoolResponse), switch
        )
        node.serve(
            "/echo", CODEC.name(EchoRequest), CODEC.name(EchoResponse), lambda given: done(memoryview(given))
        )
        yield node


def fast(ros2: Ros2, program: str, service: str, kind: str, *requests: str) -> subprocess.Popen[str]:
    return ros2.start(program, str(ros2.domain), "call", service, kind, *requests)


def said(process: subprocess.Popen[str]) -> list[str]:
    text, _ = process.communicate(timeout=40)
    return text.split("\n")[:-1]


def answer(done: bool, why: str) -> str:
    """Return the bytes of a SetBool response, written by hand: a byte, aligned length, text, its end."""
    data = why.encode() + b"\0"
    return (b"\0\1\0\0" + struct.pack("<B3xI", done, len(data)) + data).hex()


@needs_ros2
@needs_fast_dds
def test_fast_dds_gets_an_answer_to_each_call(ros2: Ros2, node: Node, fast_dds: str) -> None:
    answers = said(fast(ros2, fast_dds, "/switch", SET_BOOL, ON, OFF, ON))
    expected = [answer(True, "on"), answer(False, "off"), answer(True, "on")]
    assert [each[: len(right)] for each, right in zip(answers, expected, strict=True)] == expected


@needs_ros2
def test_cyclone_dds_gets_an_answer_to_each_call(ros2: Ros2, node: Node) -> None:
    caller = ros2.start(sys.executable, str(PEER), str(ros2.domain), "call", "5")
    assert said(caller) == ["1 0 5 a", "1 1 5 b", "1 2 5 c"]


@needs_ros2
@needs_fast_dds
def test_calls_and_answers_larger_than_a_packet_arrive(ros2: Ros2, node: Node, fast_dds: str) -> None:
    callers = [
        fast(ros2, fast_dds, "/echo", "test::srv::dds_::Echo", "@200000"),
        ros2.start(sys.executable, str(PEER), str(ros2.domain), "call", "200000"),
    ]
    assert said(callers[0]) == ["07" * 200_000]
    assert said(callers[1]) == ["1 0 200000 a", "1 1 200000 b", "1 2 200000 c"]


@needs_ros2
@needs_fast_dds
def test_packets_that_are_lost_are_sent_again(
    ros2: Ros2, node: Node, fast_dds: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, luck = Sockets.send, random.Random(1)

    def lossy(self: Sockets, packet: bytes, addresses: Any) -> None:
        if luck.random() > 0.4:
            whole(self, packet, addresses)

    monkeypatch.setattr(Sockets, "send", lossy)
    answers = said(fast(ros2, fast_dds, "/echo", "test::srv::dds_::Echo", *["@70000"] * 8))
    assert answers == ["07" * 70_000] * 8


@needs_ros2
@needs_fast_dds
def test_each_of_several_callers_gets_its_own_answers(ros2: Ros2, node: Node, fast_dds: str) -> None:
    callers = [fast(ros2, fast_dds, "/switch", SET_BOOL, *[each] * 20) for each in (ON, OFF, ON)]
    for caller, done in zip(callers, (True, False, True), strict=True):
        right = answer(done, "on" if done else "off")
        assert [each[: len(right)] for each in said(caller)] == [right] * 20


@needs_ros2
@needs_fast_dds
def test_a_service_of_another_type_is_not_there(ros2: Ros2, node: Node, fast_dds: str) -> None:
    assert said(fast(ros2, fast_dds, "/switch", "std_srvs::srv::dds_::Trigger", ON)) == ["no server"]


@needs_ros2
@needs_fast_dds
def test_a_node_that_has_left_is_not_called(ros2: Ros2, fast_dds: str) -> None:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        node.serve(
            "/switch", CODEC.name(std_srvs.SetBoolRequest), CODEC.name(std_srvs.SetBoolResponse), switch
        )
        assert len(said(fast(ros2, fast_dds, "/switch", SET_BOOL, ON))) == 1
    assert said(fast(ros2, fast_dds, "/switch", SET_BOOL, ON)) == ["no server"]


@needs_ros2
@needs_fast_dds
def test_no_thread_keeps_the_process_while_a_call_waits(ros2: Ros2, node: Node, fast_dds: str) -> None:
    asked = threading.Event()

    def never(_request: bytes) -> Future[memoryview]:
        asked.set()
        return Future()

    node.serve("/never", CODEC.name(std_srvs.SetBoolRequest), CODEC.name(std_srvs.SetBoolResponse), never)
    fast(ros2, fast_dds, "/never", SET_BOOL, ON)
    assert asked.wait(30)
    assert [each for each in threading.enumerate() if not each.daemon] == [threading.main_thread()]


@needs_ros2
@needs_fast_dds
@pytest.mark.slow
def test_a_program_of_ros_2_puts_the_robot_elsewhere_and_hears_what_is_wrong(
    ros2: Ros2, fast_dds: str
) -> None:
    ros2.body()

    def call(service: str, kind: str, request: Any, response: type) -> Any:
        data = bytes(CODEC.encode(request)).hex()
        (reply,) = said(fast(ros2, fast_dds, service, f"gazebo_msgs::srv::dds_::{kind}", data))
        return CODEC.decode(bytes.fromhex(reply), CODEC.name(response))

    state = gazebo_msgs.ModelState("husky")
    state.pose.position.x, state.pose.position.z, state.pose.orientation.w = 1.0, 0.2, 1.0
    service = ("/gazebo/set_model_state", "SetModelState")
    done = call(*service, gazebo_srvs.SetModelStateRequest(state), gazebo_srvs.SetModelStateResponse)
    assert (done.success, done.status_message) == (True, "")
    where = call(
        "/gazebo/get_model_state", "GetModelState",
        gazebo_srvs.GetModelStateRequest("husky"), gazebo_srvs.GetModelStateResponse,
    )  # fmt: skip
    assert where.pose.position.x == pytest.approx(1.0, abs=0.05)
    state.model_name = "huskie"
    refused = call(*service, gazebo_srvs.SetModelStateRequest(state), gazebo_srvs.SetModelStateResponse)
    assert not refused.success
    assert "did you mean 'husky'" in refused.status_message


class Offered:
    """A node of ROS 2 that keeps what it is to answer calls with."""

    returns_errors = False
    codec = CODEC

    def __init__(self) -> None:
        self.answers: dict[str, Any] = {}

    def serve(self, service: str, _request: str, _response: str, answer: Any) -> None:
        self.answers[service] = answer


@pytest.mark.parametrize(("request_", "warnings"), [(b"\0\1\0\0\0", 0), (b"\0\1\0\0husky", 1)])
def test_a_call_that_cannot_be_answered_is_reported(request_: bytes, warnings: int) -> None:
    backend, node, found = worlds().load("mujoco"), Offered(), Findings()
    with backend.open(Scene(()), seed=1, options=backend.options()) as world:
        calls = Calls(world, node, found)  # type: ignore[arg-type]
        calls.offer()
        service = "/gazebo/clear_body_wrenches" if warnings else "/gazebo/pause_physics"
        asked = node.answers[service](request_)
        calls.answer()
        assert isinstance(asked.exception(), TopicError if warnings else type(None))
    assert len(found) == warnings


# -- packets


def test_numbers_are_a_set_as_in_the_example_of_the_standard() -> None:
    """DDSI-RTPS 2.3, 9.4.2.6: 1234/12:00110 is the set of 1236 and 1237 among the twelve from 1234 on."""
    written = bytes.fromhex("00000000 d2040000 0c000000 00000030")
    assert packets._read_set("<", written, 0) == (1234, {1236, 1237})
    assert packets._set_of(1234, {1236, 1237}) == struct.pack("<II", 4, 0x30000000)


@given(st.binary(max_size=200))
def test_a_packet_of_anything_else_is_an_error_that_is_caught_or_nothing(data: bytes) -> None:
    me = bytes(range(packets.PREFIX))
    with suppress(struct.error, IndexError, ValueError):
        list(packets.parsed(b"RTPS" + data, me))
