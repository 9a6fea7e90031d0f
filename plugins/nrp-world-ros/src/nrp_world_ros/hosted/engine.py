"""A world that another process simulates behind ROS 2, only for this one.

Sensor data and commands use topics of ROS, as with any body. Operations without a topic, such as moving a
model, are requests between two steps.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import NrpError, SimulationError
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.world import (
    JOINT_CONTROL,
    Model,
    ModelMotion,
    Part,
    Scene,
    Stamped,
    TopicInfo,
)

from nrp_world_ros.engine import MODEL_STATES, ModelPoses, RemotePart, RosEngine
from nrp_world_ros.hosted.dialogue import Dialogue, Question
from nrp_world_ros.hosted.hosts import POLL_S, Order, borrow, give_back
from nrp_world_ros.node import DEPTH, Node
from nrp_world_ros.timekeeping import Timekeeper

_AT_ONCE = DEPTH // 2
"""Maximum number of steps of the body in a turn, because its messages, one per step and topic, are queued."""


def _asked(name: str) -> Any:
    """Return a method of the engine that requests data from the body."""
    return lambda engine, *arguments: engine._ask(name, *arguments)


def _ordered(name: str) -> Any:
    """Return a method of the engine that requests an operation of the body."""
    return lambda engine, *arguments: engine._order(name, *arguments)


class HostedEngine(RosEngine):
    """See :class:`~nrp_world_ros.engine.RosEngine`; here the body has all capabilities of its simulator.

    Raises:
        BackendError: ROS 2 or the simulator is not installed, or does not open.
        SceneError: the simulator cannot take this scene.
    """

    def _join(self) -> tuple[Node, Timekeeper]:
        options = self._options
        assert options.body is not None
        self._host = borrow(options.domain)
        try:
            opened = self._host.open(Order(self.scene, self.seed, options.body, options.body_options))
        except BaseException as error:
            give_back(self._host, usable=isinstance(error, NrpError))
            raise
        self.warnings += opened.warnings
        self.image_scale = opened.image_scale
        self._latest: dict[str, Any] = {}
        self._knows_motions = False
        self._told_pause = False
        self._left = self._told_left = frozenset[str]()
        patience_s = seconds(options.patience)
        self._dialogue = Dialogue(self._host.node, patience_s, self._host.notes, self.warnings)
        return self._host.node, self._dialogue

    def _find_models(self) -> None:
        self._node.listen(MODEL_STATES, ModelStates)

    def _pose_source(self, scene: Scene) -> ModelPoses:
        return ModelPoses(scene, by_odometry=False)  # the body reports it unasked

    # -- requests

    def _ask(self, name: str, *arguments: object) -> Any:
        """Request data from the body."""
        return self._dialogue.ask(self._sent, Question(name, arguments))

    def _order(self, name: str, *arguments: object) -> None:
        """Request an operation of the body, after which earlier data are invalid."""
        self._forget()
        self._ask(name, *arguments)

    def _forget(self) -> None:
        self._latest.clear()
        self._knows_motions = False

    def answer(self, service: str, request: Any, response: type) -> None:
        """Services are answered in this process; see :meth:`parts`."""

    # -- topics

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        """Services, and parts without topics, are in this process; all others are in ROS."""
        return [RemotePart(part, self) if any(map(_is_told, part.topics)) else part for part in usual]

    def is_heard(self, topic: TopicInfo) -> bool:
        """Topics without a rate have a value without new messages, too; others have received messages."""
        return topic.rate_hz is not None

    def last(self, topic: str) -> Any:
        return self._latest.get(topic)

    def _take(self, topic: str, heard: Stamped) -> None:
        super()._take(topic, heard)
        self._latest[topic] = heard.message

    def tell(self, topic: TopicInfo, message: Any) -> None:
        if not self.capabilities.joint_control and topic.name in self._joint_commands():
            raise self.lacks(JOINT_CONTROL)
        self._forget()  # it takes effect now and not in the next step
        super().tell(topic, message)

    def _joint_commands(self) -> set[str]:
        """Return the topics on which controllers of joints take commands."""
        of_joints = {each.topic for model in self.scene.models for each in model.controllers}
        return of_joints.union(
            each.command_topic for model in self.scene.models for each in model.trajectory_controllers
        )

    def _meet(self, wanted: set[str]) -> None:
        patience_s = seconds(self._options.patience)
        end_s = time.monotonic() + patience_s
        while missing := (wanted | {MODEL_STATES}).difference(self._node.met()):
            self._node.check()
            if time.monotonic() > end_s:
                raise SimulationError(
                    f"the body was not found on {', '.join(sorted(missing))} (waited {patience_s:g} s)"
                )
            time.sleep(POLL_S)

    def _attend(self) -> None:
        """Report topics without subscribers to the body, because ROS is slow to do so."""
        listened = self._attended_topics
        super()._attend()
        self._left = (self._left | listened) - self._attended_topics
        if self._left != self._told_left:
            self._ask("leave", self._left)
            self._told_left = self._left

    def _introduce(self, topic: str) -> None:
        self._meet({topic})
        self._ask("nothing")  # it has found this process before it answers

    # -- time

    def _do_advance(self, steps: int) -> None:
        self._pause(paused=False)
        self._go_on(steps)

    def _do_wait(self, steps: int) -> None:
        """The body pauses itself; its sensors continue."""
        self._pause(paused=True)
        self._go_on(steps)

    def _pause(self, *, paused: bool) -> None:
        if paused is not self._told_pause:
            self._order("pause", paused)
            self._told_pause = paused

    def _go_on(self, steps: int) -> None:
        self._forget()
        for some in range(_AT_ONCE, steps, _AT_ONCE):
            super()._do_advance(some)
        super()._do_advance(steps)
        self._knows_motions = MODEL_STATES in self._latest

    def _do_reset(self, seed: int) -> None:
        """Reset; if time continues, only the body is reset."""
        self._told_pause = False
        if self.now_ns:
            self._order("reset_state")
        else:
            self._order("reset", seed)

    def _do_save(self) -> object:
        return self._told_pause, self._ask("save")

    def _do_restore(self, saved: Any) -> None:
        self._told_pause, snapshot = saved
        self._order("restore", snapshot)

    def _do_close(self) -> None:
        if not self._dialogue.broken:
            with suppress(NrpError):
                self._ask("close")
        give_back(self._host, usable=not self._dialogue.broken)

    # -- states

    def _do_model_motion(self, model: str) -> ModelMotion:
        if not self._knows_motions:
            self._where.note(self._ask("motions"))
            self._knows_motions = True
        return super()._do_model_motion(model)

    _do_link_motion, _do_joint_states = _asked("link_motion"), _asked("joint_states")
    _do_actuator_states, _do_sensor_values = _asked("actuator_states"), _asked("sensor_values")
    _do_touches, _do_joint_wrench = _asked("touches"), _asked("joint_wrench")
    _do_render, _do_depth = _asked("render"), _asked("depth")

    # -- changes

    def _do_load(self, scene: Scene) -> None:
        self._order("load", scene)
        self._where = self._pose_source(scene)

    def _do_configuration(self, model: str) -> None:
        """The body stores it."""

    def _do_configure(self, model: str, configuration: object) -> None:
        """The body has stored it."""

    _do_place = _ordered("place")

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        self._order("set_joints", model, dict(positions))

    _do_set_lights, _do_set_glow = _ordered("set_lights"), _ordered("set_glow")
    _do_set_joint_effort, _do_set_wrench = _ordered("set_joint_effort"), _ordered("push")


def _is_told(topic: TopicInfo) -> bool:
    """Return whether the messages of a topic are in ROS; services are answered in this process."""
    return topic.response is None
