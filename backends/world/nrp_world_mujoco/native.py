"""Elements of a model for MuJoCo, such as ``<mujoco:joint name="elbow" armature="0.01"/>``.

They are elements of MJCF and are read by MuJoCo's parser. Only properties that a scene cannot express are
used, because all others would contradict it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code, Findings
from nrp_core.scene.inertia import LEAST_MOMENT
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.origin import Native
from nrp_core.scene.reading.repairs import LEAST_MASS
from nrp_world_mujoco.library import mujoco, pos_quat
from nrp_world_mujoco.mechanisms import (
    PLACE,
    SECTIONS,
    BuiltParts,
    Mechanisms,
    copy_all,
    number_of,
    parse_element,
    pose_of,
    write_element,
)
from nrp_world_mujoco.one_file import FILE
from nrp_world_mujoco.schema import attributes_of, field_of, text_of

_HARDLY_ANY = 4 * LEAST_MOMENT


def is_between(body: Body) -> bool:
    """Return whether a body may be a link between two joints of one body."""
    inertial = body.inertial
    return inertial is not None and inertial.mass <= LEAST_MASS and max(inertial.inertia) < _HARDLY_ANY


def neighbours(bodies: Sequence[Body]) -> Iterator[tuple[int, int, bool]]:
    """Yield the bodies of one model with their parents, between which MJCF excludes contacts.

    Bodies that are fixed to each other have the same neighbours. MuJoCo does not see through links between
    the joints of one body, so each pair comes with whether it sees this one.
    """
    groups: list[list[int]] = []
    for index, body in enumerate(bodies):
        fixed = body.joint is not None and body.joint.kind == "fixed" and body.parent is not None
        groups.append(groups[body.parent or 0] if fixed else [])
        groups[-1].append(index)
    for index, body in enumerate(bodies):
        holder = body.parent if groups[index][0] == index else None
        while holder is not None and is_between(bodies[holder]):
            holder = bodies[holder].parent
        if holder is not None:
            for one, other in product(groups[index], groups[holder]):
                yield one, other, holder == body.parent


def let_weigh_nothing(model: Any, bodies: Iterable[tuple[Body, int]]) -> None:
    """Take their mass from the bodies of the least mass that carry another one.

    A scene has no body without mass, and MuJoCo compiles none; but with several joints a body of MJCF is here
    a chain of bodies, whose mass, however small, is much of an insect's and is dragged through a medium.

    Args:
        model: the compiled model, which is changed.
        bodies: the bodies of the scene with their ids.
    """
    carrying = set(model.body_parentid.tolist())
    light = [place for body, place in bodies if is_between(body) and place in carrying]
    if light:
        model.body_mass[light], model.body_inertia[light] = 0.0, 0.0
        mujoco.mj_setConst(model, mujoco.MjData(model))
        assert np.isfinite(model.dof_invweight0).all()


def files_of(spec: Any, model: Any, path: Path) -> dict[str, dict[str, str]]:
    """Return the attributes of the meshes of an MJCF file, by name.

    Args:
        spec: the specification that MuJoCo read.
        model: its model, which has the corners of meshes of attached models, whose folders are not known.
        path: the file; those of meshes are given relative to it.
    """
    usual = mujoco.MjSpec().add_mesh()
    found = {}
    for mesh in spec.meshes:
        file = Path(spec.meshdir) / (Path(mesh.file).name if spec.strippath else mesh.file)
        changes = {"scale", "refpos", "refquat", "maxhullvert"}
        if mesh.file and (path.parent / file).is_file():
            values = {"file": str(file)}
        else:
            lists = {"vertex": mesh.uservert, "face": mesh.userface}
            if mesh.file:
                lists = dict(zip(lists, _corners(model, model.mesh(mesh.name)), strict=True))
                changes = {"maxhullvert"}
            values = {
                name: " ".join(f"{each:.9g}" for each in given) for name, given in lists.items() if len(given)
            }
        for name in sorted(changes):
            given = getattr(mesh, name)
            if np.any(given != getattr(usual, name)):
                values[name] = " ".join(f"{number:.17g}" for number in np.ravel(given))
        if mesh.inertia != usual.inertia:
            values["inertia"] = mesh.inertia.name.rpartition("_")[2].lower()
        found[mesh.name] = values
    return found


def _corners(model: Any, mesh: Any) -> tuple[Any, Any]:
    """Return the corners of a mesh, where its file has them, and their numbers in its triangles, as lists."""
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh.id])
    first, face = mesh.vertadr[0], mesh.faceadr[0]
    corners = (
        model.mesh_vert[first : first + mesh.vertnum[0]] @ turn.reshape(3, 3).T + model.mesh_pos[mesh.id]
    )
    return corners.ravel(), model.mesh_face[face : face + mesh.facenum[0]].ravel()


class FileMeshes:
    """Adds meshes from files to a specification.

    Args:
        spec: the specification.
    """

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self._names: dict[str, str] = {}

    def add(self, model: str, element: Native) -> None:
        """Add the mesh of a ``<mujoco:mesh>``: a file, relative to that of the element, or its corners.

        Raises:
            SceneError: the element is invalid.
        """
        name, file = element.attribute("name"), element.attribute("file")
        if not name or not (file or element.attribute("vertex")):
            raise element.error('it needs name="...", and file="..." or vertex="..."')
        section = ET.Element("asset")
        part = write_element(element)
        if file:
            part.set("file", str((element.path or Path()).parent.resolve() / file))
        section.append(part)
        mesh = self._spec.add_mesh(name=f"{model}/{name}/mesh")
        copy_all(parse_element(element, section).meshes[0], mesh)
        self._names[f"{model}/{name}"] = mesh.name

    def use(self, element: Native, geoms: Iterable[Any], parts: BuiltParts) -> None:
        """Give shapes the mesh, and the pose, that a ``<mujoco:geom>`` states.

        Raises:
            SceneError: the element is invalid.
        """
        model, name = parts.model.name, element.attribute("mesh") or ""
        mesh = self._names.get(f"{model}/{name}")
        if mesh is None:
            known = [full.removeprefix(f"{model}/") for full in self._names]
            raise element.error(f"the model has no <mujoco:mesh> '{name}'{did_you_mean(name, known)}")
        _, place = parts.links[element.attribute("link") or ""]
        for geom in geoms:
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, mesh
            for field, value in pos_quat(place @ pose_of(element)).items():
                setattr(geom, field, value)

    def finish(self) -> None:
        """Delete the meshes that no shape has any more."""
        used = {geom.meshname for geom in self._spec.geoms} if self._names else set()
        for mesh in [mesh for mesh in self._spec.meshes if self._names and mesh.name not in used]:
            self._spec.delete(mesh)


def pose_in_file(model: Any, geom: int) -> Mapping[str, Any]:
    """Return the pose of a shape with a mesh as its file has it, before MuJoCo moves it with the mesh."""
    mesh = int(model.geom_dataid[geom])
    back, turn, position, offset = np.empty(4), np.empty(4), np.empty(3), np.empty(3)
    mujoco.mju_negQuat(back, model.mesh_quat[mesh])
    mujoco.mju_mulQuat(turn, model.geom_quat[geom], back)
    mujoco.mju_rotVecQuat(offset, model.mesh_pos[mesh], turn)
    np.subtract(model.geom_pos[geom], offset, out=position)
    return {"pos": position, "quat": turn}


_SOLVER = ("solreflimit", "solimplimit", "solreffriction", "solimpfriction")
OF_SCENE_JOINT = ("axis", "damping", "frictionloss", "group", "limited", "pos", "range", "ref", "springref",
                  "stiffness", "type", "user")  # fmt: skip
"""Attributes that the joint of a scene has, and those that do not act."""
_OF_JOINT = (*(name for name in attributes_of("joint") if name not in OF_SCENE_JOINT), "damping", "stiffness")
_LIMITS = ("limited", "range")  # those of a ball joint bound its angle, which a scene does not
_OF_FREE_JOINT = ("armature", "damping", "frictionloss", "stiffness", *_SOLVER)
OF_SCENE_GEOM = ("axisangle", "castshadow", "density", "euler", "fitscale", "fromto", "group", "hfield",
                 "mass", "material", "mesh", "pos", "quat", "rgba", "shellinertia", "size", "type", "user",
                 "xyaxes", "zaxis")  # fmt: skip
"""Attributes that the shape of a scene has, and those that do not act."""
_OF_GEOM = tuple(name for name in attributes_of("geom") if name not in OF_SCENE_GEOM)
_RUBS = ("condim", "friction", "priority")
_KEPT = ("gravity", "integrator", "timestep")  # set by the experiment, and by servos that must stay stable
_TAGS = ("body", "compiler", "freejoint", "geom", "joint", "mesh", "option", "size", *SECTIONS)
_WITHOUT_FRICTION = mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
_ACTING = ("boundinertia", "boundmass", "settotalmass")  # attributes of the compiler


class NativeElements:
    """Applies the elements for MuJoCo to a specification before it is compiled.

    Args:
        spec: the specification.

    Attributes:
        warnings: elements that are valid and not used.
        without_friction: an element that disables dry friction, if any.
    """

    def __init__(self, spec: Any) -> None:
        self._spec = spec
        self.without_friction: Native | None = None
        self._options: dict[str, dict[str, Native]] = {}
        self._set = set[str]()
        self.warnings = Findings()
        self._mechanisms, self._meshes = Mechanisms(spec, self.warnings), FileMeshes(spec)

    def apply(self, parts: BuiltParts) -> None:
        """Apply the elements of a model to its parts.

        Raises:
            SceneError: an element is invalid; the message names its file and line.
        """
        self._mechanisms.add_model(parts)
        own = [element for element in parts.model.native if element.namespace == "mujoco"]
        for element in sorted(own, key=lambda each: each.tag != "mesh"):
            self._apply(element, parts)

    @property
    def declared(self) -> Mapping[tuple[str, str], Sequence[tuple[float, float]]]:
        """Stiffness and damping of the file's own servos, by model and joint; once finished."""
        return self._mechanisms.declared

    @property
    def sensors(self) -> Mapping[tuple[str, str], Any]:
        """The sensors by model and name; once finished."""
        return self._mechanisms.sensors

    def finish(self) -> Mapping[tuple[str, str], Any]:
        """Add the parts that may connect models, after all models; return the actuators, by model and name.

        Raises:
            SceneError: an element is invalid; the message names its file and line.
        """
        self._meshes.finish()
        self._compare_options()
        return self._mechanisms.finish()

    def _apply(self, element: Native, parts: BuiltParts) -> None:
        match element.tag:
            case "option":
                self._set_options(element)
            case "joint":
                joint = _named(element, "name", parts.joints, "moving joint")
                own = _LIMITS if joint.type == mujoco.mjtJoint.mjJNT_BALL else ()
                _copy(_values(element, (*_OF_JOINT, *own), "name"), [joint])
            case "freejoint":
                body, _ = _named(element, "link", parts.links, "link")
                free = [each for each in body.joints if each.type == mujoco.mjtJoint.mjJNT_FREE]
                _copy(_values(element, _OF_FREE_JOINT, "link"), free)
            case "geom":
                self._set_geoms(element, parts)
            case "mesh":
                self._meshes.add(parts.model.name, element)
            case "body":
                body, _ = _named(element, "link", parts.links, "link")
                body.gravcomp = number_of(element, "gravcomp")
            case "compiler" | "size":
                parse_element(element, write_element(element), compiles=True)
                self._warn(element, _ACTING)
            case tag:
                self._apply_section(tag, element, parts.model.name)

    def _apply_section(self, tag: str, element: Native, model: str) -> None:
        if tag == FILE:
            for name, value in element.attributes:
                self._options.setdefault(name, {}).setdefault(value, element)
        elif tag in SECTIONS:
            self._mechanisms.add(model, element)
        else:
            raise element.error(f"not an element that is used here{did_you_mean(tag, _TAGS)}")

    def _set_geoms(self, element: Native, parts: BuiltParts) -> None:
        """Set properties of shapes; an ellipsoid, which is a mesh in a scene, may be exact."""
        geoms, exact = _geoms(element, parts), element.attribute("type") == "ellipsoid"
        valid = (*_OF_GEOM, "type", "size") if exact else _OF_GEOM
        values = _values(element, valid, "link", "name", "mesh", "base", *PLACE)
        for geom in geoms:
            if element.attribute("base"):
                self._spec.hfield(geom.hfieldname).size[3] = number_of(element, "base")
            _copy(_unless_smooth(values, geom), [geom])
            if exact:
                geom.meshname = ""
        if element.attribute("mesh") is not None:
            self._meshes.use(element, geoms, parts)

    def _set_options(self, element: Native) -> None:
        """Set options of the whole scene, on which all models must agree."""
        read = parse_element(element, write_element(element), compiles=True).option
        self._warn(element, _KEPT)
        for name, value in element.attributes:
            if name not in _KEPT:
                self._options.setdefault(name, {}).setdefault(value, element)
                if name not in self._set:
                    setattr(self._spec.option, name, getattr(read, name))
                    self._set.add(name)
        self._spec.option.disableflags |= read.disableflags
        if read.disableflags & _WITHOUT_FRICTION:
            self.without_friction = element
        self._spec.option.enableflags |= read.enableflags

    def _compare_options(self) -> None:
        """Report options in which the files of a scene differ."""
        differing = {name: found for name, found in self._options.items() if len(found) > 1}
        if differing:
            *_, last = next(iter(differing.values())).values()
            files = dict.fromkeys(str(each.path) for found in differing.values() for each in found.values())
            which = "; ".join(f"{name} is {' and '.join(found)}" for name, found in differing.items())
            used = ", ".join(
                f"{name} {text_of(getattr(self._spec.option, name), name)}" for name in differing
            )
            message = f"the files {', '.join(files)} have different options: {which}; used: {used}"
            self.warnings.add(Code.NRP264, message, path=last.path, line=last.line or None)

    def keep(self, settings: Native, integrator: bool) -> None:
        """Set the options of the file of which the whole scene consists.

        Args:
            settings: the settings of the file.
            integrator: whether to use the file's integrator.
        """
        names = ("cone", "integrator") if integrator else ("cone",)
        read = parse_element(settings, write_element(replace(settings, tag="option"))).option
        for name in names:
            setattr(self._spec.option, name, getattr(read, name))
        self._spec.option.disableflags |= read.disableflags

    def _warn(self, element: Native, unused: Collection[str]) -> None:
        for name in unused:
            if element.attribute(name) is not None:
                message = f"{name} of <{element.full_tag}> is not used"
                self.warnings.add(
                    Code.NRP383, message, subject=name, path=element.path, line=element.line or None
                )


def _values(element: Native, valid: Sequence[str], *owner: str) -> dict[str, Any]:
    """Return the values of an element's attributes except ``owner``, by the fields of a specification."""
    given = {name: value for name, value in element.attributes if name not in owner}
    for name in given:
        if name not in valid:
            hint = did_you_mean(name, valid)
            raise element.error(f"'{name}' cannot be set here{hint}")
    world = ET.Element("worldbody")
    body = ET.SubElement(world, "body")
    ET.SubElement(body, "geom", {"size": "1", **(given if element.tag == "geom" else {})})
    if element.tag in ("joint", "freejoint"):
        kind = {"type": "free"} if element.tag == "freejoint" else {}
        ET.SubElement(body, "joint", given | kind)
    spec = parse_element(element, world, compiles=True)
    (part,) = spec.joints or spec.geoms
    fields = [field_of(part, name) for name in given]
    return {field: getattr(part, field) for field in fields}


def _geoms(element: Native, parts: BuiltParts) -> Sequence[Any]:
    """Return the shapes of a link, or only the shape that an element names."""
    geoms = _named(element, "link", parts.geoms, "solid link")
    if element.attribute("name") is None:
        return list(geoms)
    own = {geom.name.rpartition("/")[2]: geom for geom in geoms}
    return [_named(element, "name", own, "collision")]


def _unless_smooth(values: Mapping[str, Any], geom: Any) -> Mapping[str, Any]:
    """Return values without how a file in MJCF lets a shape rub, for a wheel that its drive made smooth."""
    smooth = not geom.friction[0] and all(name in values for name in _RUBS) and values["friction"][0] > 0
    return {name: value for name, value in values.items() if not (smooth and name in _RUBS)}


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
