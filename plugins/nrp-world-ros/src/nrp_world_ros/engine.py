"""A scene whose body is reached by ROS: it sends sensor data on topics and receives commands on topics."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

from nrp_core.clock import NS_PER_MS, milliseconds, seconds
from nrp_core.errors import CapabilityError, SimulationError
from nrp_core.messages.cv_bridge import CvBridge, CvBridgeError
from nrp_core.messages.gazebo_msgs import ModelStates
from nrp_core.messages.geometry_msgs import Twist
from nrp_core.messages.nav_msgs import Odometry
from nrp_core.messages.sensor_msgs import Image
from nrp_core.world import (
    BodyPath,
    BodyVelocity,
    Code,
    Direction,
    Engine,
    Model,
    ModelMotion,
    Part,
    PartProxy,
    Pose,
    Rgba,
    Scene,
    ServoTarget,
    Stamped,
    TopicInfo,
    WorldCapabilities,
    Wrench,
)

from nrp_world_ros.guard import UNSTAMPED, Guard, TwistStamped, velocity
from nrp_world_ros.joining import join
from nrp_world_ros.node import DEPTH, Node, Publisher
from nrp_world_ros.options import RosOptions, TimeSource
from nrp_world_ros.timekeeping import GO, Sent, Timekeeper, timekeeper

_BRIDGE = CvBridge()


def shaped(message: Any) -> Any:
    """Return an image of ROS as a shaped array without padding of rows; other messages unchanged.

    An image in an unknown encoding or with a wrong size stays unchanged, too.
    """
    if not isinstance(message, Image):
        return message
    try:
        image = _BRIDGE.imgmsg_to_cv2(message)
    except (CvBridgeError, ValueError):
        return message
    image.flags.writeable = False
    return replace(message, data=image, step=image.strides[0])


MODEL_STATES = "/gazebo/model_states"
"""The topic with the poses and velocities of all models, in Gazebo and in every world of the platform."""


class ModelPoses:
    """The last known states: from a simulator's topic, else from a drive's odometry, else from the files.

    Args:
        scene: the models, at the poses of their files.
        by_odometry: whether to use odometry.

    Attributes:
        topics: the topics of poses, with the types of their messages.
    """

    def __init__(self, scene: Scene, *, by_odometry: bool = True) -> None:
        self._motions = {model.name: ModelMotion(model.pose) for model in scene.models}
        self._homes = dict(self._motions)
        self._odometers = {
            drive.odometry_topic: model.name
            for model in scene.models
            for drive in model.drives
            if by_odometry and drive.odometry_topic is not None
        }
        self._seen: set[str] = set()
        self.topics: dict[str, type] = {MODEL_STATES: ModelStates, **dict.fromkeys(self._odometers, Odometry)}

    def motion(self, model: str) -> ModelMotion:
        """Return pose and velocity of a model's frame, in the frame of the world."""
        return self._motions[model]

    def note(self, motions: Mapping[str, ModelMotion]) -> None:
        """Set states of models from another source."""
        self._motions.update(motions)

    def take(self, topic: str, message: Any) -> None:
        """Update the states from a message."""
        if topic == MODEL_STATES:
            for name, pose, twist in zip(message.name, message.pose, message.twist, strict=True):
                if name in self._motions:
                    self._motions[name] = _motion(pose, twist)
                    self._seen.add(name)
        elif (name := self._odometers[topic]) not in self._seen:
            motion = _motion(message.pose.pose, message.twist.twist)
            pose = self._homes[name].pose @ motion.pose  # odometry begins where the model did,
            linear, angular = (
                pose.rotate(motion.linear),
                pose.rotate(motion.angular),
            )  # its twist is the body's
            self._motions[name] = ModelMotion(pose, linear, angular)


def _motion(pose: Any, twist: Any) -> ModelMotion:
    p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
    return ModelMotion(Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w)), (v.x, v.y, v.z), (w.x, w.y, w.z))


class Post(Protocol):
    """Transfers messages between parts and ROS."""

    def is_heard(self, topic: TopicInfo) -> bool:
        """Return whether the messages of an outgoing topic are passed on at once."""

    def attend(self, topics: Iterable[TopicInfo], subscribed: frozenset[str]) -> None:
        """Subscribe to those of the topics that are subscribed to here."""

    def arrived(self, topic: str) -> list[Stamped]:
        """Return the messages of a topic in the last step."""

    def last(self, topic: str) -> Any:
        """Return the current message of a topic, or None."""

    def tell(self, topic: TopicInfo, message: Any) -> None:
        """Publish a message."""


class RemotePart(PartProxy):
    """A part whose topics are in ROS. A bidirectional topic is also handled here.

    Args:
        inner: the core's part.
        post: transfers messages.
    """

    def __init__(self, inner: Part, post: Post) -> None:
        super().__init__(inner)
        self._post = post
        self._infos = {topic.name: topic for topic in inner.topics}
        self._remote = [topic for topic in inner.topics if topic.direction is not Direction.BOTH]
        outgoing = [topic for topic in self._remote if Direction.OUT in topic.direction]
        self.number_topics = frozenset()
        self.pushed_topics = frozenset(topic.name for topic in outgoing if post.is_heard(topic))

    def begin(self) -> None:
        """The body does this."""

    def on_subscriptions_changed(self, subscribed: frozenset[str]) -> None:
        self._post.attend(self._remote, subscribed)

    def poll(self) -> Iterable[tuple[str, Stamped]]:
        for topic in self._infos:
            if topic in self.pushed_topics:
                for stamped in self._post.arrived(topic):
                    yield topic, stamped

    def read(self, topic: str, now_ns: int) -> Any:
        message = self._post.last(topic)
        return super().read(topic, now_ns) if message is None else message

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        info = self._infos[topic]
        if info.direction is Direction.BOTH:
            super().write(topic, message, now_ns)
        self._post.tell(info, message)


_MUCH_NS = 500 * NS_PER_MS
"""Minimum delay behind a simulator for a warning; shorter ones, as from compiling, are soon made up."""

_HANDED_OVER_S = 0.1
"""Time for ROS to send the last messages, s."""


class RosEngine(Engine):
    """A body behind ROS. It reads poses of models from ``/gazebo/model_states`` or from odometry.

    It also transfers messages for its parts, see :class:`~nrp_world_ros.engine.Post`.

    Raises:
        BackendLoadError: ROS is not installed, or no master was found.
    """

    stops_between_steps = False  # the body advances as far as the loop asks, and reports then

    def __init__(self, scene: Scene, seed: int, capabilities: WorldCapabilities, options: RosOptions) -> None:
        identity = f"ros:{options.body}:{options.body_options}"
        super().__init__(scene, capabilities, seed=seed, identity=identity)
        self._options = options
        self._where = self._pose_source(scene)
        self._sent: Sent = {}
        self._told: set[str] = set()
        self._remote: dict[str, TopicInfo] = {}
        self._subscribed: frozenset[str] = frozenset()
        self._must_attend = True
        self._attended_topics: set[str] = set()
        self._arrived: dict[str, list[Stamped]] = {}
        self._begun = False
        self._was_late = False
        self._drives = {drive.command_topic for model in scene.models for drive in model.drives}
        self._driven: dict[str, Publisher] = {}
        self._guard: Guard | None = None
        self._stops, self._period_ns = 0, capabilities.step_ns
        self._heard_s = 0.0
        self._node, self._time = self._join()
        self._find_models()

    def _join(self) -> tuple[Node, Timekeeper]:
        options = self._options
        queue = 0 if options.time is TimeSource.LOCKSTEP else DEPTH
        node = join(options.ros, "nrp_loop", queue=queue, domain=options.domain)
        return node, timekeeper(options, node)

    def _pose_source(self, scene: Scene) -> ModelPoses:
        return ModelPoses(scene)

    # -- parts with messages in ROS

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        """All parts of models; other parts follow from poses or are services, and stay in this process."""
        return usual if model is None else [RemotePart(part, self) for part in usual]

    def is_heard(self, topic: TopicInfo) -> bool:
        return True

    def attend(self, topics: Iterable[TopicInfo], subscribed: frozenset[str]) -> None:
        if not self._must_attend:  # the first of the parts that report now
            self._must_attend, self._remote = True, {}
        self._remote.update({topic.name: topic for topic in topics})
        self._subscribed = subscribed

    def arrived(self, topic: str) -> list[Stamped]:
        return self._arrived.pop(topic, [])

    def last(self, topic: str) -> Any:
        return None

    def tell(self, topic: TopicInfo, message: Any) -> None:
        publisher, place = self._outlet(topic), self._place(topic)
        if place not in self._told:
            self._told.add(place)
            self._introduce(place)
            if self._is_drive(topic):
                self._driven[place] = publisher
                if self._guard is not None:
                    self._guard.arm(place)
        if self._was_late and self._guard is not None and place in self._driven:
            message = Twist()  # until it has caught up
        if publisher.peers():
            publisher.publish(velocity(message, stamped=True) if self._is_stamped(topic) else message)
            self._sent.setdefault(place, []).append(self.now_ns)

    def _is_drive(self, topic: TopicInfo) -> bool:
        """Return whether a topic has the velocities of a drive; others, of rotors and muscles, have no 0."""
        return topic.type is Twist and topic.name in self._drives

    def _is_stamped(self, topic: TopicInfo) -> bool:
        return self._options.stamped and topic.type is Twist

    def _place(self, topic: TopicInfo) -> str:
        """Return the name of a topic in ROS."""
        return topic.name.removesuffix(UNSTAMPED) if self._is_stamped(topic) else topic.name

    def _outlet(self, topic: TopicInfo) -> Publisher:
        return self._node.publisher(
            self._place(topic), TwistStamped if self._is_stamped(topic) else topic.type
        )

    def _watch(self) -> None:
        """Start the guard of the drives, before time begins."""
        options = self._options
        drives = {
            self._place(each): self._outlet(each) for each in self._remote.values() if self._is_drive(each)
        }
        if not drives or self._guard is not None or options.time is not TimeSource.WALL:
            return
        silent_s = seconds(options.stop_after + self._period_ns)
        self._guard = Guard(options.ros, options.domain, silent_s)
        for topic, publisher in sorted(drives.items()):
            self._guard.watch(topic, stamped=options.stamped, present=publisher.peers() > 0)
        for topic in sorted(self._driven):  # before the first step
            self._guard.arm(topic)

    # -- services

    def answer(self, service: str, request: Any, response: type) -> Any:
        """Return the answer of a node in ROS that offers a service, such as Gazebo, or None."""
        return self._node.call(service, request, response, seconds(self._options.patience))

    # -- one step

    def _do_advance(self, steps: int) -> None:
        self._period_ns = steps * self.step_ns
        if self._must_attend:
            self._attend()
            self._must_attend = False
            self._watch()
        if not self._begun:
            self._time.start(self._sent)
            self._begun, self._heard_s = True, time.monotonic()
        t_ns = self.now_ns + steps * self.step_ns
        taken = self._time.reach(t_ns, self._sent, self._attended_topics)
        if self._guard is not None:
            self._guard.beat()
        self._note_lateness()
        times = {topic: iter(times_ns) for topic, times_ns in taken.items()}
        letters = self._node.inbox.take()
        self._check_silence(bool(letters))
        for letter in letters:
            if letter.topic in self._attended_topics:
                taken_ns = next(times.get(letter.topic, iter(())), t_ns)
                self._take(letter.topic, Stamped(taken_ns, shaped(letter.message)))

    def _check_silence(self, heard: bool) -> None:
        """Stop the run if a robot at wall time sends nothing any more."""
        now_s, patience_s = time.monotonic(), seconds(self._options.patience)
        if heard or not self._attended_topics or self._options.time is not TimeSource.WALL:
            self._heard_s = now_s
        elif now_s > self._heard_s + patience_s:
            raise SimulationError(f"the robot has sent nothing for {patience_s:g} s")

    def _take(self, topic: str, heard: Stamped) -> None:
        if topic in self._where.topics:
            self._where.take(topic, heard.message)
        if topic in self._remote:
            self._arrived.setdefault(topic, []).append(heard)

    def _note_lateness(self) -> None:
        clock, is_wall = self._time, self._options.time is TimeSource.WALL
        late = clock.late_ns > (self._options.stop_after if is_wall else _MUCH_NS)
        self._stops += late and not self._was_late
        self._was_late = late
        if is_wall and clock.late_ns and clock.worst_ns > self._period_ns:
            stopped = f"; its drives were stopped {self._stops} times" if self._guard and self._stops else ""
            self._replace_lateness(
                f"{clock.missed} of {clock.steps} steps were late, up to "
                f"{milliseconds(clock.worst_ns):.0f} ms{stopped}"
            )
        elif late and not is_wall:
            self._replace_lateness(
                f"the loop does not keep up with the body: at {seconds(self.now_ns):g} s it was "
                f"{milliseconds(clock.late_ns):.0f} ms late"
            )

    def _replace_lateness(self, message: str) -> None:
        """Report the delays until now, once."""
        others = [each for each in self.warnings if each.subject != "time"]
        self.warnings.clear()
        self.warnings.extend(others)
        self.warnings.add(Code.NRP278, message, subject="time")

    # -- subscriptions

    def _find_models(self) -> None:
        """Receive the poses of models before the first step, if the body does not wait for that step."""
        for name, kind in self._where.topics.items():
            self._node.listen(name, kind)
        patience_s = seconds(self._options.patience)
        reported = self._where.topics.keys() - self._node.settle(patience_s)
        if reported and self._options.time is not TimeSource.LOCKSTEP:
            inbox = self._node.inbox
            inbox.wait(lambda: any(map(inbox.last, reported)), patience_s, self._node.check)
            for letter in inbox.take():
                if letter.topic in reported:
                    self._where.take(letter.topic, letter.message)

    def _attend(self) -> None:
        """Subscribe to all topics that are subscribed to here, and wait for their publishers."""
        wanted = set(self._subscribed & self._remote.keys())
        self._attended_topics = wanted | self._where.topics.keys()
        for name in wanted:
            self._node.listen(name, self._remote[name].type)
        if self._options.time is TimeSource.LOCKSTEP:
            wanted.add(GO)
        for info in self._remote.values():
            if info.direction is Direction.IN:
                self._outlet(info)  # so that commands are not sent before the connection
        self._meet(wanted)

    def _meet(self, wanted: set[str]) -> None:
        patience_s = seconds(self._options.patience)
        end_s = time.monotonic() + patience_s
        while missing := wanted & (alone := self._node.settle(patience_s)):
            if time.monotonic() > end_s:
                names = ", ".join(sorted(missing))
                raise SimulationError(
                    f"no node in ROS is connected to {names} (waited {patience_s:g} s); "
                    f"{self._node.tool} list shows the topics"
                )
            self._node.check()
            time.sleep(0.05)
        if self._where.topics.keys() <= alone:
            self._warn_of_poses()

    def _warn_of_poses(self) -> None:
        reported = " and ".join(sorted(self._where.topics))
        self.warnings.add(Code.NRP212, f"the poses of models are unknown: no node publishes {reported}")

    def _introduce(self, topic: str) -> None:
        """Wait for the subscribers of a new topic."""
        if topic in self._node.settle(seconds(self._options.patience)):
            self.warnings.add(Code.NRP212, f"no node in ROS subscribes to {topic}", subject=topic)

    # -- required by the interface

    def _do_reset(self, seed: int) -> None:
        """The time restarts; the body stays where it is."""
        self._node.inbox.take()
        self._begun = False

    def _do_model_motion(self, model: str) -> ModelMotion:
        return self._where.motion(model)

    def _do_close(self) -> None:
        """Stop driven robots, and leave ROS."""
        for publisher in self._driven.values():
            publisher.publish(velocity(Twist(), stamped=self._options.stamped))
        if self._guard is not None:
            self._guard.close()
        time.sleep(_HANDED_OVER_S)
        self._node.close()

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """The body does this when it receives the message."""

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """The room does this."""

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Joints do this."""

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        raise CapabilityError("forces cannot be applied to a body behind ROS")

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        raise CapabilityError("forces cannot be applied to a body behind ROS")
