"""A Gazebo engine: its datapacks read and command the world of a run; and the plugins in its models."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isnan
from typing import Any, Literal

import numpy as np
from google.protobuf.message import Message

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.world import Actuators, JointController, Model, ModelMotion, ModelParts, Pid, Pose, World
from nrp_core.world.topics import Subscription
from nrp_ebrains.datapacks import DataPack, JsonData, plain
from nrp_ebrains.loop import Engine
from nrp_ebrains.messages import message_classes

CAMERA = "camera"
"""The tag of flat colour cameras."""
Kind = Literal["position", "velocity"]
_KINDS: tuple[Kind, ...] = ("position", "velocity")
_VECTORS = ("position", "rotation", "linearVelocity", "angularVelocity")
_IMAGE = {
    "imageHeight": "image_height", "imageWidth": "image_width", "imageDepth": "image_depth",
    "imageData": "image_data",
}  # fmt: skip
"""Fields of an image in messages, and in JSON."""


# -- plugins in models


def read_joints(plugin: Element, model: ModelParts, reading: Reading) -> Actuators:
    """Read a plugin with a controller for each joint: gains ``P``, ``I``, ``D``, ``Type`` and ``Target``.

    Settings are attributes or elements, as in SDF. ``Target`` is 0 rad or rad/s by default, as the joints
    are at rest at the start.
    """
    controllers = []
    known = {joint.name for joint in model.joints}
    for joint in plugin.children:
        if joint.tag not in known:
            raise joint.error(f"there is no joint '{joint.tag}'{did_you_mean(joint.tag, known)}")
        controllers.append(_controller(joint, reading))
    return Actuators(controllers=tuple(controllers))


def _controller(joint: Element, reading: Reading) -> JointController:
    def setting(name: str, default: str = "0") -> str:
        child = joint.find(name)
        return joint.attributes.get(name) or (child.text if child else default)

    kind = setting("Type", "").lower()
    if kind not in _KINDS:
        raise joint.error(f"the Type of a joint's controller is position or velocity, not '{kind}'")
    p, i, d, target, limit = (float(setting(name)) for name in ("P", "I", "D", "Target", "IMax"))
    topic = resolve_name(f"{joint.tag}/cmd", reading.robot)
    return JointController(joint.tag, kind, topic, Pid(p, i, d, limit), target)


def is_inert(plugin: str) -> bool:
    """Return whether a plugin only adds a datapack to a part of a model or world; all parts have one."""
    return re.fullmatch(r"NRPGazebo\w+(Link|Model|Camera|World)(Controller)?Plugin", plugin) is not None


# -- the engine


class GazeboEngine(Engine):
    """The world of a run, which advances with the run.

    Datapacks are ``model::joint``, ``model::link``, ``model`` and ``model::link::camera``.

    Args:
        name: its name.
        step_ns: its time step.
        world: the world.
        in_json: whether datapacks are JSON and not messages.
        warn: reports a command that has no effect.
    """

    def __init__(
        self, name: str, step_ns: int, world: World, *, in_json: bool, warn: Callable[[Code, str], object]
    ) -> None:
        super().__init__(name, step_ns)
        self._world, self._in_json, self._warn = world, in_json, warn
        self._readers: dict[str, Callable[[], Any]] = {}
        self._without_effect: set[tuple[str, str]] = set()

    def initialize(self) -> None:
        """Do nothing, because the world is open."""

    def read(self, names: Iterable[str]) -> Mapping[str, Any]:
        found: dict[str, Any] = {}
        for name in names:
            if name not in self._readers:
                self._readers[name] = self._reader(name)
            data = self._readers[name]()
            if data is not None:
                found[name] = data
        return found

    def reset(self) -> None:
        self._readers.clear()

    # -- reading

    def _reader(self, name: str) -> Callable[[], Any]:
        """Return a function that reads a datapack; it returns None without new data."""
        model, part = self._split(name)
        if not part:
            return lambda: self._motion("Model", self._world.model_motion(model.name))
        if part in {joint.name for joint in model.joints}:
            return lambda: self._joint(model.name, part)
        if part in {link.name for link in model.links}:
            return lambda: self._motion("Link", self._world.link_motion(model.name, part))
        link, _, sensor = part.rpartition("::")
        cameras = {
            f"{each.name}::{one.name}": one
            for each in model.links
            for one in each.sensors
            if one.tag == CAMERA
        }
        if f"{link}::{sensor}" in cameras:
            return _ImageReader(
                self._world.subscribe(cameras[part].topic), self._message, in_json=self._in_json
            )
        joints, links = ([one.name for one in each] for each in (model.joints, model.links))
        known = [*joints, *links, *cameras]
        raise ExperimentError(
            f"the engine '{self.name}' has no datapack '{name}': '{model.name}' has no joint, link or camera "
            f"'{part}'{did_you_mean(part, known)}"
        )

    def _split(self, name: str) -> tuple[Model, str]:
        head, _, part = name.partition("::")
        return self._world.scene.model(head), part

    def _message(self, kind: str, values: Mapping[str, Any]) -> Any:
        if self._in_json:
            return JsonData({_IMAGE.get(key, key): value for key, value in values.items()})
        return message_classes()["Gazebo"][kind](**values)

    def _joint(self, model: str, joint: str) -> Any:
        states = self._world.joint_states(model)
        if joint not in states.names:
            return self._message("Joint", {"position": 0.0, "velocity": 0.0, "effort": 0.0})  # a fixed one
        i = states.names.index(joint)
        values = states.positions[i], states.velocities[i], states.efforts[i]
        return self._message(
            "Joint", dict(zip(("position", "velocity", "effort"), map(float, values), strict=True))
        )

    def _motion(self, kind: str, motion: ModelMotion) -> Any:
        values = motion.pose.position, motion.pose.orientation, motion.linear, motion.angular
        return self._message(kind, {name: list(one) for name, one in zip(_VECTORS, values, strict=True)})

    # -- writing

    def write(self, packs: Sequence[DataPack]) -> None:
        for pack in packs:
            model, part = self._split(pack.name)
            values = _given(pack.data)
            if not part:
                self._place(model.name, values)
            elif part in {joint.name for joint in model.joints}:
                self._command(model, part, values)

    def _command(self, model: Model, joint: str, values: Mapping[str, Any]) -> None:
        for quantity in _KINDS:
            if quantity not in values:
                continue
            topics = [one.topic for one in model.controllers if one.joint == joint and one.kind == quantity]
            if topics:
                self._world.advertise(topics[0]).publish(Float64(float(values[quantity])))
            elif (joint, quantity) not in self._without_effect:
                self._without_effect.add((joint, quantity))
                message = f"'{model.name}::{joint}' has no controller for its {quantity}: commands do nothing"
                self._warn(Code.NRP265, message)
        if values.get("effort"):
            step_s = self._world.engine.capabilities.step_ns / 1e9
            self._world.call(
                "/gazebo/apply_joint_effort", joint_name=f"{model.name}::{joint}",
                effort=float(values["effort"]), duration=step_s,
            )  # fmt: skip

    def _place(self, model: str, values: Mapping[str, Any]) -> None:
        now = self._world.model_motion(model)
        position, rotation = now.pose.position, now.pose.orientation
        pose = Pose(tuple(values.get("position", position)), tuple(values.get("rotation", rotation)))
        linear = tuple(values.get("linearVelocity", now.linear))
        angular = tuple(values.get("angularVelocity", now.angular))
        self._world.place(model, ModelMotion(pose, linear, angular))


class _ImageReader:
    """Reads a camera; its datapack is new when an image has arrived."""

    def __init__(
        self, images: Subscription, message: Callable[[str, Mapping[str, Any]], Any], *, in_json: bool
    ) -> None:
        self._images, self._message, self._in_json = images, message, in_json
        self._last: object = None

    def __call__(self) -> Any:
        latest = self._images.latest
        if latest is None or latest is self._last:
            return None
        self._last = latest
        image = latest.message
        pixels = np.asarray(image.data, np.uint8).reshape(image.height, image.width, -1)
        data: Any = pixels.ravel() if self._in_json else pixels.tobytes()
        return self._message(
            "Camera",
            {"imageHeight": image.height, "imageWidth": image.width, "imageDepth": pixels.shape[2],
             "imageData": data},
        )  # fmt: skip


def _given(data: Any) -> dict[str, Any]:
    """Return the fields of a command that are set: numbers that are not NaN, lists that are not empty."""
    if isinstance(data, Message):
        values = {field.name: getattr(data, field.name) for field in data.DESCRIPTOR.fields}
    else:
        values = dict(plain(data) or {})
    return {
        name: value if isinstance(value, float | int) else list(value)
        for name, value in values.items()
        if value is not None and (not isnan(value) if isinstance(value, float | int) else len(value))
    }
