"""Sections of MJCF for MuJoCo: contact pairs, equality constraints, tendons, actuators and sensors.

They are written as in MJCF, such as ``<mujoco:adhesion name="pad" body="foot"/>`` in a ``<mujoco:actuator>``,
and name the parts of the scene: a link or joint by its name, a collision as ``link/collision``, with
``model/`` before it if it is in another model. Sites and the shapes that tendons wrap around are elements
with a ``link``, which may be ``world``: their pose is then relative to the model's. All are added when all
models are built, because they may connect models.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree import ElementTree as ET

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.scene.model import Model
from nrp_core.scene.origin import Native
from nrp_core.scene.rigid import Pose
from nrp_world_mujoco.library import mujoco, pos_quat

SECTIONS = ("site", "wrap", "tendon", "equality", "contact", "actuator", "sensor")
"""The elements that are read here, in the order in which they are added."""
_EQUALITIES = ("connect", "weld", "joint", "tendon")
_ENDS = {"connect": ("site",), "weld": ("site",), "joint": ("joint",), "tendon": ("tendon",)}
_TARGETS = {"joint": "joint", "jointinparent": "joint", "tendon": "tendon", "site": "site", "refsite": "site",
            "body": "link", "cranksite": "site", "slidersite": "site"}  # fmt: skip
_MEASURED = {"joint": "joint", "tendon": "tendon", "site": "site", "body": "link", "objname": "site",
             "refname": "site"}  # fmt: skip
FREE = "free"
"""The name of the free joint of a body, after that of its link: ``base/free``."""
_SERVOS = ("position", "velocity")
WORLD = "world"
"""The link of a place that does not move, unless the model has a link of this name."""
_HIDDEN = 5
"""A group of geoms that nobody draws."""
_OF_PAIR = ("condim", "friction", "solref", "solimp", "margin", "gap", "adhesion")
"""What a contact pair and a shape have both."""
PLACE = ("pos", "quat", "axisangle", "euler", "xyaxes", "zaxis")
"""Attributes of an element that has a pose."""
_OWN = ("classname", "compiler", "id", "info", "name", "path", "plugin", "signature", "userdata")
"""Attributes of an element of a specification that are not copied."""


@dataclass(frozen=True, slots=True)
class BuiltParts:
    """The parts of a model in the specification.

    Args:
        model: the model.
        links: the body of each link, and the pose of the link in it.
        joints: its movable joints.
        geoms: its collision shapes, by link.
    """

    model: Model
    links: Mapping[str, tuple[Any, Pose]]
    joints: Mapping[str, Any]
    geoms: Mapping[str, Sequence[Any]]


@dataclass(slots=True)
class _Names:
    """The names of the parts of the scene in the specification, by kind and by their full names."""

    kinds: dict[str, dict[str, str]] = field(
        default_factory=lambda: {
            kind: {} for kind in ("link", "joint", "collision", "site", "tendon", "wrap")
        }
    )

    def add(self, parts: BuiltParts) -> None:
        of = parts.model.name
        self.kinds["link"] |= {f"{of}/{name}": body.name for name, (body, _) in parts.links.items()}
        self.kinds["joint"] |= {f"{of}/{name}": joint.name for name, joint in parts.joints.items()}
        self.kinds["joint"] |= {f"{of}/{name}/{FREE}": joint.name for name, (body, _) in parts.links.items()
                                for joint in body.joints
                                if joint.type == mujoco.mjtJoint.mjJNT_FREE}  # fmt: skip
        self.kinds["collision"] |= {geom.name: geom.name for each in parts.geoms.values() for geom in each}

    def find(self, kind: str, name: str, of: str) -> str | None:
        """Return the name in the specification of a part of a model, or of another one."""
        known = self.kinds[kind]
        return known.get(f"{of}/{name}", known.get(name))

    def require(self, element: Native, attribute: str, kind: str, of: str) -> str:
        """Return the name of the part that an attribute names."""
        name = element.attribute(attribute)
        found = None if name is None else self.find(kind, name, of)
        if found is None:
            valid = [full.removeprefix(f"{of}/") for full in self.kinds[kind]]
            wanted = f'it needs {attribute}="..."' if name is None else f"the scene has no {kind} '{name}'"
            raise element.error(f"{wanted}{did_you_mean(name or '', valid)}")
        return found


class Mechanisms:
    """Collects the sections of all models, and adds them to a specification.

    Args:
        spec: the specification.
        warnings: receives a finding for each part that is not added as its file describes it.
    """

    def __init__(self, spec: Any, warnings: Findings) -> None:
        self._spec, self._warnings = spec, warnings
        self._names = _Names()
        self._parts: dict[str, BuiltParts] = {}
        self._found: list[tuple[str, Native]] = []
        self._actuators: dict[tuple[str, str], Any] = {}
        self.sensors: dict[tuple[str, str], Any] = {}
        """The sensors by model and name."""
        self.declared: dict[tuple[str, str], list[tuple[float, float]]] = {}
        """Stiffness and damping of the servos that a file has as actuators of its own, by model and joint."""

    def add_model(self, parts: BuiltParts) -> None:
        """Note the parts of a model."""
        self._parts[parts.model.name] = parts
        self._names.add(parts)

    def add(self, model: str, section: Native) -> None:
        """Note a section of a model."""
        self._found.append((model, section))

    def finish(self) -> Mapping[tuple[str, str], Any]:
        """Add all sections, and return the actuators by model and name.

        Raises:
            SceneError: an element is invalid; the message names its file and line.
        """
        add = {"site": self._add_site, "wrap": self._add_wrap, "tendon": self._add_tendons,
               "equality": self._add_equalities, "contact": self._add_contacts,
               "actuator": self._add_actuators, "sensor": self._add_sensors}  # fmt: skip
        for tag in SECTIONS:
            for model, section in self._found:
                if section.tag == tag:
                    add[tag](model, section)
        return self._actuators

    # -- places on links

    def _add_site(self, of: str, element: Native) -> None:
        body, place = self._holder(of, element)
        where = _compiled(element, "site")
        pose = place @ _pose(where.site_pos[0], where.site_quat[0])
        shape = {"type": mujoco.mjtGeom(where.site_type[0]), "size": where.site_size[0]}
        body.add_site(name=self._new_name(of, element, "site"), **shape, **pos_quat(pose))

    def _add_wrap(self, of: str, element: Native) -> None:
        """Add the shape that a tendon wraps around; it has no contacts."""
        body, place = self._holder(of, element)
        where = _compiled(element, "geom")
        pose = place @ _pose(where.geom_pos[0], where.geom_quat[0])
        shape = {"type": mujoco.mjtGeom(where.geom_type[0]), "size": where.geom_size[0]}
        name = self._new_name(of, element, "wrap")
        body.add_geom(name=name, mass=0, group=_HIDDEN, contype=0, conaffinity=0, **shape, **pos_quat(pose))

    def _holder(self, of: str, element: Native) -> tuple[Any, Pose]:
        if element.attribute("link") == WORLD and WORLD not in self._parts[of].links:
            return self._spec.worldbody, self._parts[of].model.pose
        self._names.require(element, "link", "link", of)
        return self._parts[of].links[element.attribute("link") or ""]

    def _new_name(self, of: str, element: Native, kind: str) -> str:
        name = element.attribute("name")
        if not name:
            raise element.error('it needs name="..."')
        full = f"{of}/{name}"
        if full in self._names.kinds[kind]:
            raise element.error(f"the model has two of the name '{name}'")
        self._names.kinds[kind][full] = f"{full}/{kind}"
        return self._names.kinds[kind][full]

    # -- tendons

    def _add_tendons(self, of: str, section: Native) -> None:
        for element in _children(section, ("fixed", "spatial")):
            alone = ET.Element("tendon")
            given = {name: value for name, value in element.attributes if name != "name"}
            ET.SubElement(alone, element.tag, given)
            tendon = self._spec.add_tendon(name=self._new_name(of, element, "tendon"))
            copy_all(parse_element(element, alone).tendons[0], tendon)
            for part in element.children:
                self._wrap(of, tendon, part)

    def _wrap(self, of: str, tendon: Any, part: Native) -> None:
        match part.tag:
            case "joint":
                tendon.wrap_joint(self._names.require(part, "joint", "joint", of), number_of(part, "coef"))
            case "site":
                tendon.wrap_site(self._names.require(part, "site", "site", of))
            case "geom":
                side = part.attribute("sidesite")
                beside = self._names.require(part, "sidesite", "site", of) if side else ""
                tendon.wrap_geom(self._names.require(part, "geom", "wrap", of), beside)
            case "pulley":
                tendon.wrap_pulley(number_of(part, "divisor"))
            case tag:
                raise part.error(f"a tendon goes along a joint, site, geom or pulley, not a <{tag}>")

    # -- constraints and contacts

    def _add_equalities(self, of: str, section: Native) -> None:
        for element in _children(section, _EQUALITIES):
            (kind,) = _ENDS[element.tag]
            ends = {f"{kind}{n}": kind for n in (1, 2) if n == 1 or element.attribute(f"{kind}2")}
            part = self._renamed(of, element, ends)
            equality = self._spec.add_equality()
            copy_all(self._parsed_in("equality", element, part).equalities[0], equality)

    def _add_contacts(self, of: str, section: Native) -> None:
        in_vain = list[tuple[Native, str]]()
        for element in _children(section, ("pair", "exclude")):
            ends = ("geom1", "geom2") if element.tag == "pair" else ("body1", "body2")
            kind = "collision" if element.tag == "pair" else "link"
            names = [element.attribute(end) or "" for end in ends]
            if away := [name for name in names if self._elsewhere(kind, name, of)]:
                if element.tag == "pair" and len(away) < len(ends):
                    here = next(end for end, name in zip(ends, names, strict=True) if name not in away)
                    self._touch_everything(of, element, here, away[0])
                continue
            if element.tag == "exclude" and (absent := [n for n in names if self._is_absent(n, of)]):
                in_vain.append((element, absent[0]))
                continue
            part = self._renamed(of, element, dict.fromkeys(ends, kind))
            read = self._parsed_in("contact", element, part)
            if element.tag == "pair":
                copy_all(read.pairs[0], self._spec.add_pair())
            elif read.excludes[0].bodyname1 != read.excludes[0].bodyname2:  # which may be one body here
                copy_all(read.excludes[0], self._spec.add_exclude())
        if in_vain:
            self._report_excludes(in_vain, of)

    def _is_absent(self, link: str, of: str) -> bool:
        """Return whether a link is missing; MuJoCo reports an empty name itself."""
        return bool(link) and self._names.find("link", link, of) is None

    def _report_excludes(self, in_vain: Sequence[tuple[Native, str]], of: str) -> None:
        """Report excludes that name absent links: they do no harm, and MuJoCo reads none in URDF."""
        element, link = in_vain[0]
        valid = [full.removeprefix(f"{of}/") for full in self._names.kinds["link"]]
        more = f" (and {len(in_vain) - 1} more)" if len(in_vain) > 1 else ""
        hint = did_you_mean(link, valid)
        message = f"the scene has no link '{link}'{hint}: the <exclude> has no effect{more}"
        self._warnings.add(Code.NRP383, message, subject=link, path=element.path, line=element.line or None)

    def _elsewhere(self, kind: str, name: str, of: str) -> bool:
        """Return whether a name is that of a part of a model that is not in the scene."""
        model, inside, _ = name.partition("/")
        return bool(inside) and self._names.find(kind, name, of) is None and model not in self._parts \
            and name.count("/") >= (2 if kind == "collision" else 1)  # fmt: skip

    def _touch_everything(self, of: str, element: Native, end: str, away: str) -> None:
        """Let a shape touch everything, because the only shape that it touches in its file is missing."""
        name = self._names.require(element, end, "collision", of)
        geom = next(each for each in self._spec.geoms if each.name == name)
        if not (geom.contype or geom.conaffinity):
            read = self._parsed_in("contact", element, self._renamed(of, element, {end: "collision"})).pairs[
                0
            ]
            geom.contype = geom.conaffinity = 1
            for attribute in _OF_PAIR:
                value = getattr(read, attribute)
                setattr(geom, attribute, value[[0, 2, 3]] if attribute == "friction" else value)
        message = (
            f"'{away}' is not in the scene: the collisions that touch only it in their file touch everything"
        )
        if all(message != each.message for each in self._warnings):
            self._warnings.add(Code.NRP264, message, subject=away, path=element.path)

    # -- actuators

    def _add_actuators(self, of: str, section: Native) -> None:
        for element in _children(section, None):
            name = element.attribute("name")
            if not name and element.tag in _SERVOS and element.attribute("joint"):
                self._declare(of, element)
                continue
            if not name:
                raise element.error('it needs name="...", under which it is commanded')
            if (of, name) in self._actuators:
                raise element.error(f"the model has two actuators of the name '{name}'")
            ends = {each: kind for each, kind in _TARGETS.items() if element.attribute(each)}
            part = self._renamed(of, element, ends)
            actuator = self._spec.add_actuator()
            copy_all(self._parsed_in("actuator", element, part).actuators[0], actuator)
            actuator.name = f"{of}/{name}/actuator"
            self._actuators[of, name] = actuator

    def _declare(self, of: str, element: Native) -> None:
        """Note that an actuator of the file implements the controllers with these gains, without changes."""
        self._names.require(element, "joint", "joint", of)
        stiffness = number_of(element, "kp") if element.tag == "position" else 0.0
        gains = stiffness, number_of(element, "kv")
        self.declared.setdefault((of, element.attribute("joint") or ""), []).append(gains)

    # -- sensors

    def _add_sensors(self, of: str, section: Native) -> None:
        for element in _children(section, None):
            name = element.attribute("name")
            if not name or (of, name) in self.sensors:
                wrong = f"the model has two sensors of the name '{name}'" if name else 'it needs name="..."'
                raise element.error(wrong)
            ends = {each: kind for each, kind in _MEASURED.items() if element.attribute(each)}
            part = self._renamed(of, element, ends)
            if (actuator := element.attribute("actuator")) is not None:
                if (of, actuator) not in self._actuators:
                    known = [each for model, each in self._actuators if model == of]
                    raise element.error(
                        f"the model has no actuator '{actuator}'{did_you_mean(actuator, known)}"
                    )
                part.set("actuator", self._actuators[of, actuator].name)
            sensor = self._spec.add_sensor()
            copy_all(self._parsed_in("sensor", element, part).sensors[0], sensor)
            sensor.name = f"{of}/{name}/sensor"
            self.sensors[of, name] = sensor

    # -- reading

    def _renamed(self, of: str, element: Native, ends: Mapping[str, str]) -> ET.Element:
        """Return an element with the names of the specification."""
        part = write_element(element)
        part.attrib.pop("name", None)
        for end, kind in ends.items():
            part.set(end, self._names.require(element, end, kind, of))
        return part

    @staticmethod
    def _parsed_in(section: str, element: Native, part: ET.Element) -> Any:
        alone = ET.Element(section)
        alone.append(part)
        return parse_element(element, alone)


def touches_itself(model: Model) -> bool:
    """Return whether the parts of a model touch each other, by ``<mujoco:contact self="true"/>``."""
    contacts = (each for each in model.native if (each.namespace, each.tag) == ("mujoco", "contact"))
    return any(each.attribute("self") == "true" for each in contacts)


def parse_element(element: Native, part: ET.Element, *, compiles: bool = False) -> Any:
    """Parse a part of an MJCF file in a separate model, and return its specification.

    Args:
        element: the element of the part, for errors.
        part: a child of ``<mujoco>``.
        compiles: whether it is complete, so that MuJoCo can check its values.

    Raises:
        SceneError: MuJoCo refuses it.
    """
    root = ET.Element("mujoco")
    root.append(part)
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
        if compiles:
            spec.compile()
    except ValueError as error:
        reason = str(error).splitlines()[0]
        for prefix in ("XML Error: ", "Schema violation: ", "Error: "):
            reason = reason.removeprefix(prefix)
        raise element.error(f"MuJoCo refuses it: {reason}") from None
    return spec


def write_element(element: Native) -> ET.Element:
    """Return an element as MJCF, with its children."""
    result = ET.Element(element.tag, dict(element.attributes))
    result.extend(map(write_element, element.children))
    return result


def _children(section: Native, valid: Iterable[str] | None) -> Iterator[Native]:
    for element in section.children:
        if valid is not None and element.tag not in valid:
            hint = did_you_mean(element.tag, valid)
            raise element.error(f"not an element of a <{section.tag}> that is used here{hint}")
        yield element


def number_of(element: Native, attribute: str) -> float:
    """Return the number in an attribute."""
    try:
        return float(element.attribute(attribute) or "")
    except ValueError:
        raise element.error(f"it needs a number as its {attribute}") from None


def pose_of(element: Native) -> Pose:
    """Return the pose that an element states, in any way of MJCF.

    Raises:
        SceneError: MuJoCo refuses it.
    """
    stated = tuple((name, value) for name, value in element.attributes if name in PLACE)
    where = _compiled(replace(element, attributes=stated), "site")
    return _pose(where.site_pos[0], where.site_quat[0])


def _compiled(element: Native, tag: str) -> Any:
    """Return a model with one part on a body, from an element that has its pose."""
    given = {name: value for name, value in element.attributes if name not in ("link", "name")}
    world = ET.Element("worldbody")
    ET.SubElement(ET.SubElement(world, "body"), tag, given)
    return parse_element(element, world, compiles=True).compile()


def _pose(position: Any, turn: Any) -> Pose:
    (x, y, z), (qw, qx, qy, qz) = position.tolist(), turn.tolist()
    return Pose((x, y, z), (qx, qy, qz, qw))


def copy_all(source: Any, target: Any) -> None:
    """Copy the values of an element of a specification to another one of its kind."""
    for name in dir(source):
        value = None if name.startswith("_") or name in _OWN else getattr(source, name)
        if value is not None and not callable(value):
            setattr(target, name, value)
