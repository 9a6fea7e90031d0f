"""Elements of a model for MuJoCo, such as ``<mujoco:joint name="elbow" armature="0.01"/>``.

They are elements of MJCF and are read by MuJoCo's parser. Only properties that a scene cannot express are
used, because all others would contradict it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree as ET

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.origin import Native
from nrp_world_mujoco.library import mujoco

_SOLVER = {"solreflimit": "solref_limit", "solimplimit": "solimp_limit"}
_SOLVER |= {"solreffriction": "solref_friction", "solimpfriction": "solimp_friction"}
_OF_JOINT = ("armature", "margin", "springdamper", *_SOLVER)
_OF_GEOM = ("condim", "friction", "gap", "margin", "priority", "solimp", "solmix", "solref")
_KEPT = ("gravity", "integrator", "timestep")  # set by the experiment, and by servos that must stay stable
_TAGS = ("compiler", "geom", "joint", "option", "size")
_ACTING = ("boundinertia", "boundmass", "settotalmass")  # attributes of the compiler


class NativeElements:
    """Applies the elements for MuJoCo to a specification before it is compiled.

    Args:
        spec: the specification.

    Attributes:
        warnings: elements that are valid and not used.
    """

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self._options: dict[str, tuple[str, Native]] = {}
        self.warnings = Findings()

    def apply(self, model: Model, joints: Mapping[str, Any], geoms: Mapping[str, Sequence[Any]]) -> None:
        """Apply the elements of a model.

        Args:
            model: the model.
            joints: its movable joints, by name.
            geoms: its collision shapes, by link.

        Raises:
            SceneError: an element is invalid; the message names its file and line.
        """
        for element in model.native:
            if element.namespace == "mujoco":
                self._apply(element, joints, geoms)

    def _apply(self, element: Native, joints: Mapping[str, Any], geoms: Mapping[str, Sequence[Any]]) -> None:
        match element.tag:
            case "option":
                self._set_options(element)
            case "joint":
                _copy(_parsed(element, _OF_JOINT, "name"), [_named(element, "name", joints, "moving joint")])
            case "geom":
                _copy(_parsed(element, _OF_GEOM, "link"), _named(element, "link", geoms, "solid link"))
            case "compiler" | "size":
                _read(element, _written(element))
                self._warn(element, _ACTING)
            case tag:
                hint = did_you_mean(tag, _TAGS)
                raise element.error(f"not an element that is used here{hint}; valid: {', '.join(_TAGS)}")

    def _set_options(self, element: Native) -> None:
        """Set options of the whole scene, on which all models must agree."""
        parsed = _read(element, _written(element)).option
        self._warn(element, _KEPT)
        for name, value in element.attributes:
            if name in _KEPT:
                continue
            before, where = self._options.setdefault(name, (value, element))
            if before != value:
                raise element.error(
                    f"{name} is '{value}' here and '{before}' in {where.path}:{where.line}; "
                    "the option holds for the whole scene"
                )
            setattr(self._spec.option, name, getattr(parsed, name))
        self._spec.option.disableflags |= parsed.disableflags
        self._spec.option.enableflags |= parsed.enableflags

    def _warn(self, element: Native, unused: Collection[str]) -> None:
        for name in unused:
            if element.attribute(name) is not None:
                message = f"{name} of <{element.full_tag}> is not used"
                self.warnings.add(
                    Code.NRP263, message, subject=name, path=element.path, line=element.line or None
                )


def _parsed(element: Native, valid: Sequence[str], owner: str) -> dict[str, Any]:
    """Return the values of an element's attributes except ``owner``, by the fields of a specification."""
    given = {name: value for name, value in element.attributes if name != owner}
    for name in given:
        if name not in valid:
            hint = did_you_mean(name, valid)
            raise element.error(f"'{name}' cannot be set here{hint}; valid: {', '.join(valid)}")
    world = ET.Element("worldbody")
    body = ET.SubElement(world, "body")
    ET.SubElement(body, "geom", {"size": "1", **(given if element.tag == "geom" else {})})
    if element.tag == "joint":
        ET.SubElement(body, "joint", given)
    spec = _read(element, world)
    (part,) = spec.joints or spec.geoms
    fields = {name: _SOLVER.get(name, name) for name in given}
    return {field: getattr(part, field) for field in fields.values()}


def _written(element: Native) -> ET.Element:
    """Return an element as MJCF, with its children."""
    written = ET.Element(element.tag, dict(element.attributes))
    written.extend(map(_written, element.children))
    return written


def _read(element: Native, part: ET.Element) -> Any:
    """Parse an element with MuJoCo in a separate model, and return its specification."""
    root = ET.Element("mujoco")
    root.append(part)
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
        spec.compile()
    except ValueError as error:
        reason = str(error).splitlines()[0]
        for prefix in ("XML Error: ", "Schema violation: ", "Error: "):
            reason = reason.removeprefix(prefix)
        raise element.error(f"MuJoCo refuses it: {reason}") from None
    return spec


def _named(element: Native, attribute: str, parts: Mapping[str, Any], kind: str) -> Any:
    name = element.attribute(attribute)
    if name is None or name not in parts:
        wanted = f'it needs {attribute}="..."' if name is None else f"the model has no {kind} '{name}'"
        raise element.error(f"{wanted}{did_you_mean(name or '', parts)}")
    return parts[name]


def _copy(values: Mapping[str, Any], parts: Sequence[Any]) -> None:
    for part in parts:
        for name, value in values.items():
            setattr(part, name, value)
