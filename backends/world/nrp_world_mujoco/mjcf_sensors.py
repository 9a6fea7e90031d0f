"""The sensors of an MJCF file: elements for MuJoCo, and plugins that publish them as messages."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol
from xml.sax.saxutils import escape, quoteattr

from nrp_core.world.sensors.engine_sensor import FORMS
from nrp_world_mujoco.library import mujoco

_KINDS = mujoco.mjtObj
_TAGS = {"JOINTACTFRC": "jointactuatorfrc", "TENDONACTFRC": "tendonactuatorfrc", "GEOMDIST": "distance",
         "GEOMNORMAL": "normal", "GEOMFROMTO": "fromto"}  # fmt: skip
"""Elements that are not named as their kind."""
_FORM_OF = {tag: name for name, form in FORMS.items() for tag in form.fields}
_SHARED = ("imu", "wrench", "pose", "twist", "accel")
"""Messages for which several sensors at one place are joined."""
_HELD = ("force", "torque")
"""What is measured where a body is held: if it is held firmly, it is a part of another body in a scene."""
_FRAMES: dict[Any, tuple[str, str, str]] = {
    _KINDS.mjOBJ_BODY: ("", "body_ipos", "body_iquat"),
    _KINDS.mjOBJ_XBODY: ("", "", ""),
    _KINDS.mjOBJ_GEOM: ("geom_bodyid", "geom_pos", "geom_quat"),
    _KINDS.mjOBJ_CAMERA: ("cam_bodyid", "cam_pos", "cam_quat"),
    _KINDS.mjOBJ_SITE: ("site_bodyid", "site_pos", "site_quat"),
}
"""Fields with the bodies and the poses of what has a frame."""
_UNITS = {"pos": ("rad", "m"), "vel": ("rad/s", "m/s"), "frc": ("N m", "N")}
"""Units of joints that turn and that slide, by the ends of kinds."""


class Parts(Protocol):
    """The parts of a file by :class:`~nrp_world_mujoco.mjcf_native.NativeElements`."""

    names: Any
    controlled: dict[int, Any]
    tops: dict[str, int]

    def name(self, kind: str, number: int) -> str:
        """Return the name of a part."""

    def holder(self, owner: str, body: int) -> str:
        """Return the model that has a place on a body, used by another model."""

    def place(self, owner: str, body: int, position: Any, turn: Any) -> dict[str, str]:
        """Return the link and the pose of a place."""

    def placed(self, owner: str, body: int, name: str) -> str:
        """Return the name of a place as the elements of a model use it."""

    def used_site(self, owner: str, site: int) -> str:
        """Add a site of the file, and return its name."""

    def body_of_tendon(self, tendon: int) -> int:
        """Return the body in whose model a tendon is."""

    def target(self, number: int) -> tuple[str, dict[str, str], float]:
        """Return the model of an actuator, and more."""


@dataclass(slots=True)
class _Message:
    """A message to be: the model that has it, its name, and the elements in its plugin."""

    owner: str
    name: str
    inner: list[tuple[str, str]] = field(default_factory=list)


class SensorElements:
    """The sensors of a file.

    Args:
        model: the compiled model.
        parts: the names of its parts.

    Attributes:
        left_out: number of sensors of each kind without a message, or of a quantity that scenes lack.
        touched_sites: the sites in whose shape sensors feel contacts.
    """

    def __init__(self, model: Any, parts: Parts) -> None:
        self._m, self._parts = model, parts
        self._messages: dict[object, _Message] = {}
        self.left_out = Counter[str]()
        self.touched_sites: set[int] = set()

    def plugins(self, model: str) -> Iterator[tuple[str, str]]:
        """Yield the name and the elements of each plugin of a model."""
        for each in self._messages.values():
            if each.owner == model:
                yield each.name, "".join(f"<{tag}>{escape(value)}</{tag}>" for tag, value in each.inner)

    def lines(self) -> Iterator[tuple[str, str]]:
        """Yield the elements for MuJoCo with their models."""
        m = self._m
        for number in range(m.nsensor):
            kind = mujoco.mjtSensor(m.sensor_type[number]).name.removeprefix("mjSENS_")
            tag = _TAGS.get(kind, kind.lower())
            measured = self._measured(number, tag) if self._has_message(number, tag) else None
            if measured is None:
                self.left_out[tag] += 1
                continue
            owner, body, ends = measured
            if tag.startswith("frame"):
                for end in ("obj", "ref"):
                    yield from self._frame(number, end, owner, ends)
            values = {"name": self._parts.name("sensor", number), **ends}
            if cutoff := float(m.sensor_cutoff[number]):
                values["cutoff"] = f"{cutoff:.17g}"
            attributes = "".join(f" {key}={quoteattr(value)}" for key, value in values.items())
            yield owner, f"<mujoco:sensor><{tag}{attributes}/></mujoco:sensor>"
            self._publish(number, tag, owner, body, ends)

    def _has_message(self, number: int, tag: str) -> bool:
        """Return whether a sensor has a message: a ray, not an image, and present values."""
        m = self._m
        one = tag != "rangefinder" or (
            m.sensor_dim[number] == 1 and m.sensor_objtype[number] == _KINDS.mjOBJ_SITE
        )
        return tag in _FORM_OF and one and not m.sensor_history[number].any()

    def _measured(self, number: int, tag: str) -> tuple[str, int, dict[str, str]] | None:
        """Return the model of a sensor, its body, and where it is attached; None if the scene lacks that."""
        m, parts = self._m, self._parts
        kind, part = _KINDS(m.sensor_objtype[number]), int(m.sensor_objid[number])
        if tag.startswith("frame"):
            body = self._body(kind, part)
            return parts.names.model(body), body, {}
        if kind == _KINDS.mjOBJ_SITE:
            body = int(m.site_bodyid[part])
            owner = parts.names.model(body)
            if tag in _HELD and (not body or m.body_weldid[body] != body):
                return None
            if tag == "touch":
                self.touched_sites.add(part)
            return owner, body, {"site": parts.used_site(owner, part)}
        if kind == _KINDS.mjOBJ_JOINT:
            body = int(m.jnt_bodyid[part])
            return parts.names.model(body), body, {"joint": parts.names.joint(part)}
        if kind == _KINDS.mjOBJ_TENDON:
            body = parts.body_of_tendon(part)
            return parts.names.model(body), body, {"tendon": parts.name("tendon", part)}
        if kind == _KINDS.mjOBJ_ACTUATOR and part not in parts.controlled and m.actuator_ctrlnum[part] == 1:
            owner = parts.target(part)[0]
            return owner, parts.tops[owner], {"actuator": parts.name("actuator", part)}
        if kind == _KINDS.mjOBJ_BODY and m.body_weldid[part] == part != 0:
            return parts.names.model(part), part, {"body": parts.names.body(part)}
        if kind == _KINDS.mjOBJ_UNKNOWN:  # of the whole world
            owner, body = max(parts.tops.items(), key=lambda top: bool(top[1]))
            return owner, body, {}
        return None

    def _body(self, kind: Any, part: int) -> int:
        """Return the body that has a frame."""
        field, *_ = _FRAMES[kind]
        return int(getattr(self._m, field)[part]) if field else part

    def _frame(self, number: int, end: str, owner: str, ends: dict[str, str]) -> Iterator[tuple[str, str]]:
        """Let a sensor measure a frame, or relative to it, which is a site in a scene."""
        m, parts = self._m, self._parts
        kind, part = (getattr(m, f"sensor_{end}{field}")[number] for field in ("type", "id"))
        if part < 0:
            return
        kind, part, ends[f"{end}type"] = _KINDS(kind), int(part), "site"
        if kind == _KINDS.mjOBJ_SITE:
            ends[f"{end}name"] = parts.used_site(owner, part)
            return
        body, name, (_, place, turn) = self._body(kind, part), f"sensor_{number}_{end}", _FRAMES[kind]
        position = getattr(m, place)[part] if place else _ORIGIN
        orientation = getattr(m, turn)[part] if turn else _NO_TURN
        values = {"name": name, **parts.place(owner, body, position, orientation)}
        attributes = "".join(f" {key}={quoteattr(value)}" for key, value in values.items())
        yield parts.holder(owner, body), f"<mujoco:site{attributes}/>"
        ends[f"{end}name"] = parts.placed(owner, body, name)

    def _publish(self, number: int, tag: str, owner: str, body: int, ends: dict[str, str]) -> None:
        """Add a sensor to the message of its place, or create a new message."""
        m, form, name = self._m, _FORM_OF[tag], self._parts.name("sensor", number)
        fields = (m.sensor_objtype, m.sensor_objid, m.sensor_reftype, m.sensor_refid)
        key: object = (form, *(int(each[number]) for each in fields))
        shared = form in _SHARED
        if not shared or any(tag == each for each, _ in self._messages.get(key, _NONE).inner):
            key, shared = name, False
        if key not in self._messages:
            title = f"{self._place_name(number)}/{form}" if shared else name
            if any((owner, title) == (each.owner, each.name) for each in self._messages.values()):
                title = name  # of two frames of a body, which have one name
            topic = re.sub(r"[^\w/]+", "_", title)
            message = self._messages[key] = _Message(owner, title)
            message.inner += [("link", self._parts.names.body(body)), ("topic", topic), ("message", form)]
            message.inner += self._details(number, tag, ends)
        self._messages[key].inner.append((tag, name))

    def _place_name(self, number: int) -> str:
        kind, part = _KINDS(self._m.sensor_objtype[number]), int(self._m.sensor_objid[number])
        if kind in (_KINDS.mjOBJ_BODY, _KINDS.mjOBJ_XBODY):
            return str(self._parts.names.body(part))
        return self._parts.name(kind.name.removeprefix("mjOBJ_").lower().replace("camera", "cam"), part)

    def _details(self, number: int, tag: str, ends: dict[str, str]) -> Iterator[tuple[str, str]]:
        """Yield the other elements of a plugin: frame, rate, unit, and range."""
        m = self._m
        frame = ends.get("refname", "" if tag.startswith("frame") else ends.get("site", ""))
        if frame:
            yield "frame", frame
        if interval := float(m.sensor_interval[number][0]):
            yield "update_rate", f"{1 / interval:.17g}"
        if tag.startswith("joint"):
            slides = m.jnt_type[m.sensor_objid[number]] == mujoco.mjtJoint.mjJNT_SLIDE
            yield "unit", _UNITS[tag[-3:]][int(slides)]
        elif tag == "touch":
            yield "unit", "N"
        if tag == "rangefinder" and (cutoff := float(m.sensor_cutoff[number])):
            yield "max_range", f"{cutoff:.17g}"


_NONE = _Message("", "")
_ORIGIN, _NO_TURN = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
