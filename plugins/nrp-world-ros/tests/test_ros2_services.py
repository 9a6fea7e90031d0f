"""Services of ROS 2, called by a node of its client library."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any

import pytest
from nrp_core import worlds
from nrp_core.errors import SimulationError, TopicError
from nrp_core.messages import std_srvs
from nrp_core.messages.cdr import Codec
from nrp_core.world import Findings, Scene

from conftest import CALLS, Ros2, needs_ros2
from nrp_world_ros.bridge import Calls
from nrp_world_ros.joining import join
from nrp_world_ros.node import Node
from nrp_world_ros.options import Ros

SET_BOOL = "std_srvs/srv/SetBool"
CODEC = Codec()


def done(response: memoryview) -> Future[memoryview]:
    coming: Future[memoryview] = Future()
    coming.set_result(response)
    return coming


def switch(request: bytes) -> Future[memoryview]:
    asked = CODEC.decode(request, CODEC.name(std_srvs.SetBoolRequest))
    text = "on" if asked.data else "off" * 50_000  # larger than a packet
    return done(CODEC.encode(std_srvs.SetBoolResponse(success=asked.data, message=text)))


def serve(node: Node, service: str, answer: Any = switch) -> None:
    node.serve(service, *map(node.codec.name, (std_srvs.SetBoolRequest, std_srvs.SetBoolResponse)), answer)


@pytest.fixture
def node(ros2: Ros2) -> Iterator[Node]:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        serve(node, "/switch")
        yield node


def discover(ros2: Ros2, node: Any, service: str) -> None:
    ros2.until(lambda: service in dict(node._node.get_service_names_and_types()))


def called(ros2: Ros2, *arguments: str) -> list[str]:
    said, _ = ros2.peer("call", *arguments).communicate(timeout=90)
    return said.splitlines()


@needs_ros2
def test_each_call_gets_its_answer(ros2: Ros2, node: Node) -> None:
    on = "std_srvs.srv.SetBool_Response(success=True, message='on')"
    callers = [ros2.peer("call", "/switch", SET_BOOL, "5", f"data={data}") for data in ("true", "false")]
    assert callers[0].communicate(timeout=90)[0].splitlines() == [on] * 5
    off = on.replace("True", "False").replace("on')", "off" * 50_000 + "')")
    assert callers[1].communicate(timeout=90)[0].splitlines() == [off] * 5


@pytest.mark.heavy
@needs_ros2
def test_a_node_that_has_left_is_not_called(ros2: Ros2) -> None:
    with join(Ros.TWO, "under_test", domain=ros2.domain) as node:
        serve(node, "/switch")
    assert called(ros2, "/switch", SET_BOOL, "1") == ["no server"]


@pytest.mark.heavy
@needs_ros2
def test_a_call_without_an_answer_holds_up_neither_the_process_nor_other_calls(
    ros2: Ros2, node: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nrp_world_ros.ros2.node.PATIENCE_S", 0.5)
    asked = threading.Event()

    def never(_request: bytes) -> Future[memoryview]:
        asked.set()
        return Future()

    serve(node, "/never", never)
    ros2.peer("call", "/never", SET_BOOL, "1")
    assert asked.wait(60)
    assert [each for each in threading.enumerate() if not each.daemon] == [threading.main_thread()]
    assert "success=True" in called(ros2, "/switch", SET_BOOL, "1", "data=true")[0]
    node.check()


@needs_ros2
def test_a_service_of_another_program_is_called(ros2: Ros2, node: Node) -> None:
    ros2.ready_peer("serve")
    discover(ros2, node, "/lamp")
    for data, text in ((True, "on"), (False, "off")):
        request = std_srvs.SetBoolRequest(data)
        answer = node.call("/lamp", request, std_srvs.SetBoolResponse, 60.0)
        assert (answer.success, answer.message) == (data, text)
    assert node.call("/nowhere", std_srvs.SetBoolRequest(True), std_srvs.SetBoolResponse, 60.0) is None


@needs_ros2
def test_a_call_without_an_answer_ends_with_an_error(
    ros2: Ros2, node: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nrp_world_ros.ros2.node.PATIENCE_S", 1.0)
    with join(Ros.TWO, "silent", domain=ros2.domain) as silent:
        serve(silent, "/never", lambda _request: Future())
        discover(ros2, node, "/never")
        with pytest.raises(SimulationError, match=r"/never.*0.5"):
            node.call("/never", std_srvs.SetBoolRequest(True), std_srvs.SetBoolResponse, 0.5)


@needs_ros2
@pytest.mark.slow
def test_a_loop_calls_the_services_of_its_body(ros2: Ros2) -> None:
    ros2.body("--lockstep")
    ros2.run(sys.executable, "-c", CALLS, "2")


@needs_ros2
@pytest.mark.slow
def test_a_ros_2_program_moves_the_robot_and_receives_the_reasons_of_refusals(ros2: Ros2) -> None:
    ros2.body()
    place = (
        "/gazebo/set_model_state", "gazebo_msgs/srv/SetModelState", "1",
        "model_state.pose.position.x=1.0", "model_state.pose.position.z=0.2",
    )  # fmt: skip
    assert "success=True" in called(ros2, *place, 'model_state.model_name="husky"')[0]
    where = called(
        ros2, "/gazebo/get_model_state", "gazebo_msgs/srv/GetModelState", "1", 'model_name="husky"'
    )[0]
    x = float(where.split("geometry_msgs.msg.Point(x=")[1].split(",")[0])
    assert x == pytest.approx(1.0, abs=0.05)
    refused = called(ros2, *place, 'model_state.model_name="huskie"')[0]
    assert "success=False" in refused
    assert "did you mean 'husky'" in refused


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
