"""MJCF, MuJoCo's format, read by MuJoCo and converted to SDF for every engine.

Bodies, joints, geoms with their meshes, masses, cameras, gravity and actuators of joints are converted.
What else a scene cannot express is kept for MuJoCo (:mod:`.mjcf_native`); sensors without a message, flexible
bodies and height fields that move are left out and named in a warning.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from math import atan, pi, tan
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from nrp_core._support.cache import cached_folder
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Findings
from nrp_core.scene.bodies import PRESERVED, ROLLING, TINTS
from nrp_core.scene.inertia import LEAST_MOMENT
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.model import TORSION_BY_RADIUS, Inertial
from nrp_core.scene.reading.context import Element, read_xml
from nrp_core.scene.reading.repairs import LEAST_MASS, NO_INERTIA
from nrp_core.scene.rigid import Pose, Quaternion, Vector
from nrp_core.scene.sdf.model import KEYFRAME
from nrp_core.world.drives.muscles import ALL
from nrp_core.world.render.cameras import looking
from nrp_world_mujoco.actuators import actuators_of, warn_of_one_sided_limits
from nrp_world_mujoco.announced_sizes import check_sizes
from nrp_world_mujoco.library import compile_spec, mujoco
from nrp_world_mujoco.mjcf_images import Images, replace_missing
from nrp_world_mujoco.mjcf_native import Names, NativeElements, is_ground, not_passed
from nrp_world_mujoco.muscles import moved_joints
from nrp_world_mujoco.native import files_of
from nrp_world_mujoco.schema import without_field

_WORLD = 0
_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)
_HFIELD = mujoco.mjtGeom.mjGEOM_HFIELD
_HIDDEN_GROUP = 3
"""From this group on, MuJoCo's viewer hides geoms."""
_DEFAULT_RESOLUTION = (320, 240)
_NOTHING = Inertial(LEAST_MASS, inertia=(LEAST_MOMENT, LEAST_MOMENT, LEAST_MOMENT, 0.0, 0.0, 0.0))
"""Of a body without mass, and of a link between two joints of a body: the least that is not repaired."""

_LEFT_OUT = {"nflex": "flexible bodies"}


def read_mjcf(path: Path) -> tuple[str, Findings]:
    """Return the SDF equivalent to an MJCF file, and the warnings.

    Raises:
        SceneError: MuJoCo cannot read the file.
    """
    warnings = Findings()
    check_sizes(path)
    try:
        spec, model = _read(path, warnings)
    except (ValueError, OSError) as error:
        raise SceneError(f"MuJoCo cannot read this: {' '.join(str(error).split())}", path=path) from None
    root = read_xml(path)
    acting = (model.actuator_plugin, model.geom_plugin, model.body_plugin)
    if plugins := {int(number) for each in acting for number in each if number >= 0}:
        names = ", ".join(f"'{each.plugin_name}'" for each in spec.plugins if each.id in plugins)
        message = f"plugins of MuJoCo that move bodies are not supported: {names or len(plugins)}"
        raise (root.find("extension") or root).error(message)
    warn_of_one_sided_limits(root, spec, model, warnings)
    files = (root, *(included for _, included in _included(root, path.parent)))
    options = (option for file in files for option in file.all("option"))
    cones = [option.attributes["cone"] for option in options if "cone" in option.attributes]
    writer = _Writer(spec, model, path.stem, "".join(cones[-1:]), files_of(spec, model, path))
    text = "\n".join(writer.lines())
    left_out = _left_out(spec, model, writer.touching)
    if sensors := writer.sensors_left_out:
        left_out.insert(0, f"{sensors.total()} sensors ({', '.join(sorted(sensors))})")
    if writer.flat:
        left_out.append(
            f"the images on height fields, capsules and meshes without texture coordinates: {writer.flat}"
        )
    for part in left_out:
        warnings.add(Code.NRP260, f"left out of this MJCF file: {part}", path=path)
    return text, warnings


def _left_out(spec: Any, model: Any, touching: set[int]) -> list[str]:
    """Return the parts of a file that act in MuJoCo alone and not in a scene."""
    left_out = [
        f"{getattr(model, field)} {what}" for field, what in _LEFT_OUT.items() if getattr(model, field)
    ]
    if model.opt.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP:
        asleep = sum(body.sleep == mujoco.mjtSleepPolicy.mjSLEEP_INIT for body in spec.bodies)
        left_out += [f"the sleep of {asleep} bodies at the start"] if asleep else []
    balls = model.jnt_type == mujoco.mjtJoint.mjJNT_BALL
    left_out.extend(not_passed(model))
    left_out.extend(without_field(spec))
    if rushing := np.count_nonzero(model.key_qvel.any(axis=1)):
        left_out.append(f"the velocities of {rushing} keyframes")
    if model.nkey and balls.any():
        left_out.append(f"the orientations of ball joints in {model.nkey} keyframes")
    drag = set(np.flatnonzero(model.geom_fluid.any(axis=1)).tolist()) - touching
    if drag:
        left_out.append(f"the fluidshape of {len(drag)} shapes that nothing touches")
    grounds = [is_ground(model, geom) for geom in np.flatnonzero(model.geom_type == _HFIELD).tolist()]
    if moving := grounds.count(False):
        left_out.append(f"{moving} height fields on bodies that move")
    return left_out


def _included(element: Element, folder: Path) -> Iterator[tuple[str, Element]]:
    """Yield the name and the root of each file that an element includes, and of those that they include."""
    for child in element.children:
        name = child.attributes.get("file", "") if child.tag == "include" else ""
        if name and (folder / name).is_file():
            root = read_xml(folder / name)
            yield name, root
            yield from _included(root, folder)
        yield from _included(child, folder)


def _read(path: Path, warnings: Findings) -> tuple[Any, Any]:
    """Return the specification in a file and its model; files that MuJoCo misses are replaced."""
    spec = _parse(path)
    try:
        return spec, compile_spec(spec)
    except ValueError:  # files of attached models are in folders that the specification does not say
        spec = _parse(path)
        replace_missing(spec, path, warnings)
        return spec, compile_spec(spec)


def _parse(path: Path) -> Any:
    """Return the specification in a file; MuJoCo's own reader accepts only the suffix .xml."""
    if path.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(path))
    files = {name: (path.parent / name).read_bytes() for name, _ in _included(read_xml(path), path.parent)}
    spec = mujoco.MjSpec.from_string(path.read_text(), include=files)
    spec.modelfiledir = str(path.parent)
    return spec


class _Writer:
    def __init__(
        self, spec: Any, model: Any, name: str, cone: str, meshes: Mapping[str, dict[str, str]]
    ) -> None:
        self._m, self._name = model, name
        self._actuators = actuators_of(spec, model)
        alone = {each.number for each in self._actuators}
        others = (number for number in range(len(model.actuator_trntype)) if number not in alone)
        self._shared = {joint for number in others for joint in moved_joints(model, number)}
        names = Names(self._body, self._joint_name, self._geom_name, self._owner)
        self._native = NativeElements(spec, model, names, cone, meshes)
        self.touching = self._native.touching
        among = sorted(self.touching)
        self._rubs = bool((model.geom_condim[among] > 1).any() or model.geom_bodyid[among].all())
        """Whether contacts of the file can have friction; a file without a ground may meet another."""
        self.sensors_left_out = self._native.sensors.left_out
        self._images = Images(model)
        self.flat = 0
        """The number of shapes that have the mean colour of an image."""
        bits = zip(model.geom_contype.tolist(), model.geom_conaffinity.tolist(), strict=True)
        self._has_bits = not {(0, 0), (1, 1)}.issuperset(bits)
        self._children: dict[int, list[int]] = {}
        for body in range(1, model.nbody):
            self._children.setdefault(int(model.body_parentid[body]), []).append(body)

    def lines(self) -> Iterator[str]:
        root = 'sdf version="1.11" xmlns:mujoco="urn:mujoco" xmlns:nrp="urn:nrp"'
        yield f"<{root}><world name={quoteattr(self._name)}>"
        yield f"<gravity>{_text(self._m.opt.gravity)}</gravity>"
        ground = self._owner(_WORLD)
        native = list(self._native.of(ground))
        if self._m.body_geomnum[_WORLD] or _WORLD in self._m.cam_bodyid or native:
            yield f"<model name={quoteattr(ground)}><static>true</static>"
            yield from native
            yield from self._link(_WORLD, Pose(), "")
            yield from self._commands(ground)
            yield "</model>"
        for top in self._children.get(_WORLD, ()):
            yield from self._model(top)
        yield "</world></sdf>"

    # -- bodies

    def _model(self, top: int) -> Iterator[str]:
        tree = list(self._tree(top))
        yield f"<model name={quoteattr(self._body(top))}>{_pose(self._pose('body', top))}"
        if not any(self._m.body_jntnum[body] for body in tree):
            yield "<static>true</static>"
        yield from self._native.of(self._body(top))
        for body in tree:
            yield from self._held(body, "world" if body == top else self._body(self._m.body_parentid[body]))
        for actuator in self._actuators:
            if self._m.jnt_bodyid[actuator.joint] in tree:
                zero = -float(self._m.qpos0[self._m.jnt_qposadr[actuator.joint]])
                yield actuator.plugin(escape(self._joint_name(actuator.joint)), zero)
        yield from self._commands(self._body(top))
        yield from self._keyframes(tree)
        yield "</model>"

    def _commands(self, model: str) -> Iterator[str]:
        others = self._native.actuators.get(model, ())
        for name, low, high in others:
            yield _command(name, low, high)
        muscles = self._native.muscles.get(model, {})
        for name, elements in muscles.items():
            yield _plugin("nrp_muscle", name, elements + _topic(name))
        if muscles and ALL not in {*muscles, *(name for name, *_ in others)}:
            members = "".join(f"<muscle>{escape(name)}</muscle>" for name in muscles)
            yield _plugin("nrp_muscle_group", ALL, members)
        for name, elements in self._native.sensors.plugins(model):
            yield _plugin("nrp_engine_sensor", name, elements)

    def _keyframes(self, tree: Collection[int]) -> Iterator[str]:
        """Yield the starts that the file names, of the joints of a model with one degree of freedom."""
        m = self._m
        controls = {each.joint: each for each in self._actuators if each.kind == "position"}
        for key in range(m.nkey):
            yield f"<{KEYFRAME} name={quoteattr(m.key(key).name or f'key_{key}')}>"
            commanded = m.key_ctrl[key].any()
            for joint in range(m.njnt):
                at, kind = int(m.jnt_qposadr[joint]), mujoco.mjtJoint(m.jnt_type[joint])
                if int(m.jnt_bodyid[joint]) not in tree or kind == mujoco.mjtJoint.mjJNT_BALL:
                    continue
                if kind == mujoco.mjtJoint.mjJNT_FREE:
                    place = m.key_qpos[key][at : at + 7]
                    yield _pose(Pose(_vector(place[:3]), _quaternion(place[3:])))
                    continue
                target = ""
                if commanded and joint in controls:
                    actuator = controls[joint]
                    control = float(m.key_ctrl[key][m.actuator_ctrladr[actuator.number]])
                    command = control / float(m.actuator_gear[actuator.number][0]) - float(m.qpos0[at])
                    target = f' target="{command}"'
                start = float(m.key_qpos[key][at] - m.qpos0[at])
                yield f"<start joint={quoteattr(self._joint_name(joint))}{target}>{start}</start>"
            yield f"</{KEYFRAME}>"

    def _tree(self, body: int) -> Iterator[int]:
        yield body
        for child in self._children.get(body, ()):
            yield from self._tree(child)

    def _held(self, body: int, parent: str) -> Iterator[str]:
        """Yield a body and its joints; between two of them is a link with almost no mass."""
        first, count = int(self._m.body_jntadr[body]), int(self._m.body_jntnum[body])
        joints = range(first, first + count)
        place, base = (Pose(), "__model__") if parent == "world" else (self._pose("body", body), parent)
        kinds = [mujoco.mjtJoint(self._m.jnt_type[joint]) for joint in joints]
        if mujoco.mjtJoint.mjJNT_FREE in kinds:
            yield from self._link(body, place, base)
            return
        if not kinds:
            yield from self._link(body, place, base)
            # on another body, contacts would be softer or harder
            apart = self._m.body_weldid[body] and (self._m.body_mass[body] or self._touches(body))
            yield _fixed(f"{self._body(body)}_held", parent, self._body(body), preserved=bool(apart))
            return
        for joint in joints[:-1]:
            between = f"{self._body(body)}_{self._joint_name(joint)}_link"
            yield f"<link name={quoteattr(between)}>{_pose(place, base)}{_inertial(_NOTHING)}</link>"
            yield from self._joint(joint, parent, between)
            parent, place, base = between, Pose(), between
        yield from self._link(body, place, base)
        yield from self._joint(joints[-1], parent, self._body(body))

    def _touches(self, body: int) -> bool:
        first = int(self._m.body_geomadr[body])
        return not self.touching.isdisjoint(range(first, first + int(self._m.body_geomnum[body])))

    def _link(self, body: int, place: Pose, base: str) -> Iterator[str]:
        yield f"<link name={quoteattr(self._body(body))}>{_pose(place, base)}"
        if self._m.body_gravcomp[body] == 1:
            yield "<gravity>false</gravity>"
        mass = float(self._m.body_mass[body])
        if body != _WORLD:  # without one, its shapes would weigh something
            centre = Pose(_vector(self._m.body_ipos[body]), _quaternion(self._m.body_iquat[body]))
            moments = self._m.body_inertia[body].tolist()
            if mass and not any(moments):  # as ``boundmass`` leaves it
                moments = [max(LEAST_MOMENT, 2 * NO_INERTIA * mass)] * 3
            given = Inertial(mass or LEAST_MASS, centre, (*moments, 0.0, 0.0, 0.0))
            yield _inertial(given if any(moments) else _NOTHING)
        first = int(self._m.body_geomadr[body])
        for geom in range(first, first + int(self._m.body_geomnum[body])):
            yield from self._geom(geom)
        for camera in np.flatnonzero(self._m.cam_bodyid == body).tolist():
            yield from self._camera(camera)
        yield "</link>"

    def _joint(self, joint: int, parent: str, child: str) -> Iterator[str]:
        m = self._m
        kinds = {mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic"}
        kind = kinds.get(mujoco.mjtJoint(m.jnt_type[joint]), "ball")
        yield f"<joint name={quoteattr(self._joint_name(joint))} type={quoteattr(kind)}>"
        yield f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>"
        yield _pose(Pose(_vector(m.jnt_pos[joint])))
        yield f"<axis><xyz>{_text(m.jnt_axis[joint])}</xyz>"
        if kind != "ball":
            zero = float(m.qpos0[m.jnt_qposadr[joint]])
            lower, upper = (m.jnt_range[joint] - zero).tolist() if m.jnt_limited[joint] else (-np.inf, np.inf)
            # the limit of all actuators of a joint together is not that of its servo
            limited = m.jnt_actfrclimited[joint] and joint not in self._shared
            effort = float(abs(m.jnt_actfrcrange[joint]).max()) if limited else np.inf
            effort = min([effort, *(each.force for each in self._actuators if each.joint == joint)])
            yield f"<limit><lower>{lower}</lower><upper>{upper}</upper><effort>{effort}</effort></limit>"
        dof = m.jnt_dofadr[joint]
        dynamics = f"<damping>{m.dof_damping[dof]}</damping>"
        dynamics += f"<friction>{m.dof_frictionloss[dof]}</friction>"
        spring = float(np.ravel(m.jnt_stiffness[joint])[0])
        if spring and kind != "ball":
            rest = float((m.qpos_spring - m.qpos0)[m.jnt_qposadr[joint]])
            dynamics += (
                f"<spring_stiffness>{spring}</spring_stiffness><spring_reference>{rest}</spring_reference>"
            )
        yield f"<dynamics>{dynamics}</dynamics></axis></joint>"

    # -- visuals, collisions and cameras

    def _geom(self, geom: int) -> Iterator[str]:
        m = self._m
        shape = self._shape(geom)
        if shape is None:
            return
        name = quoteattr(self._geom_name(geom))
        place = _pose(self._pose("geom", geom))
        if m.geom_group[geom] < _HIDDEN_GROUP:
            rgba = m.geom_rgba[geom]
            if m.geom_matid[geom] >= 0 and np.allclose(rgba, _DEFAULT_RGBA):
                rgba = m.mat_rgba[m.geom_matid[geom]]
            image, mean = self._images.on(geom), self._images.mean(geom)
            if image is None and (mean != 1).any():
                self.flat += 1
                rgba = rgba * (*mean, 1.0)
            tints = f' {TINTS}="true"' if image else ""
            color = f"<material{tints}><diffuse>{_text(rgba[:3])} 1</diffuse></material>"
            drawn = f"<mesh><uri>{escape(str(image))}</uri></mesh>" if image else shape
            seen = f"<transparency>{1 - float(rgba[3])}</transparency>{color}<geometry>{drawn}</geometry>"
            yield f"<visual name={name}>{place}{seen}</visual>"
        if geom in self.touching:
            surface = f"<surface>{self._friction(geom)}{self._bits(geom)}</surface>"
            touched = shape.replace("<mesh>", '<mesh optimization="convex_hull">')  # as MuJoCo does
            yield f"<collision name={name}>{place}<geometry>{touched}</geometry>{surface}</collision>"

    def _friction(self, geom: int) -> str:
        """Return the element of the friction, which is 0 if all shapes of the file have a ``condim`` of 1."""
        m = self._m
        mu, torsion, rolling = m.geom_friction[geom]
        dimensions = m.geom_condim[geom]
        patch = torsion / TORSION_BY_RADIUS if dimensions > 3 else 0.0
        twisted = f"<torsional><patch_radius>{patch}</patch_radius></torsional>" if patch else ""
        rolled = f' {ROLLING}="{rolling}"' if dimensions > 4 and rolling else ""
        return f"<friction{rolled}><ode><mu>{mu if self._rubs else 0.0}</mu></ode>{twisted}</friction>"

    def _bits(self, geom: int) -> str:
        """Return the element that states what a shape touches; empty if all shapes touch all or none."""
        m = self._m
        category, touched = int(m.geom_contype[geom]), int(m.geom_conaffinity[geom])
        if not self._has_bits or not (category or touched):  # a pair lets the latter touch something
            return ""
        bits = f"<collide_bitmask>{touched}</collide_bitmask><category_bitmask>{category}</category_bitmask>"
        return f"<contact>{bits}</contact>"

    def _shape(self, geom: int) -> str | None:
        kinds = mujoco.mjtGeom
        a, b, c = self._m.geom_size[geom].tolist()
        match mujoco.mjtGeom(self._m.geom_type[geom]):
            case kinds.mjGEOM_PLANE:
                size = [2 * side if side > 0 else 100.0 for side in (a, b)]
                return f"<plane><size>{_text(size)}</size></plane>"
            case kinds.mjGEOM_SPHERE:
                return f"<sphere><radius>{a}</radius></sphere>"
            case kinds.mjGEOM_CAPSULE:
                return f"<capsule><radius>{a}</radius><length>{2 * b}</length></capsule>"
            case kinds.mjGEOM_CYLINDER:
                return f"<cylinder><radius>{a}</radius><length>{2 * b}</length></cylinder>"
            case kinds.mjGEOM_BOX:
                return f"<box><size>{_text((2 * a, 2 * b, 2 * c))}</size></box>"
            case kinds.mjGEOM_ELLIPSOID:
                return f"<ellipsoid><radii>{_text((a, b, c))}</radii></ellipsoid>"
            case kinds.mjGEOM_MESH:
                return self._mesh(_triangles(self._m, int(self._m.geom_dataid[geom])))
            case kinds.mjGEOM_HFIELD if is_ground(self._m, geom):
                return self._terrain(int(self._m.geom_dataid[geom]))
            case _:
                return None

    def _mesh(self, triangles: Any) -> str:
        """Return a mesh, the file of which is created once."""
        path = _cached("mesh.stl", triangles, lambda path: write_stl(path, triangles))
        return f"<mesh><uri>{escape(str(path))}</uri></mesh>"

    def _terrain(self, field: int) -> str:
        """Return a height map whose heights are in a file."""
        m, first = self._m, self._m.hfield_adr[field]
        rows, columns = int(m.hfield_nrow[field]), int(m.hfield_ncol[field])
        heights = m.hfield_data[first : first + rows * columns].reshape(rows, columns)
        x, y, z = m.hfield_size[field][:3].tolist()
        path = _cached(f"{rows}x{columns}.npy", heights, lambda path: np.save(path, heights))
        return f"<heightmap><uri>{escape(str(path))}</uri><size>{_text((2 * x, 2 * y, z))}</size></heightmap>"

    def _camera(self, camera: int) -> Iterator[str]:
        width, height = self._m.cam_resolution[camera].tolist()
        if width * height <= 1:
            width, height = _DEFAULT_RESOLUTION
        high = tan(float(self._m.cam_fovy[camera]) * pi / 360)
        ahead = self._pose("cam", camera) @ looking(Pose()).inverse()
        name = quoteattr(self._m.camera(camera).name or f"camera_{camera}")
        yield f'<sensor name={name} type="camera">{_pose(ahead)}<update_rate>30</update_rate>'
        yield f"<camera><horizontal_fov>{2 * atan(high * width / height)}</horizontal_fov>"
        yield f"<image><width>{width}</width><height>{height}</height></image></camera></sensor>"

    # -- names and places

    def _body(self, body: int) -> str:
        return "ground" if body == _WORLD else self._m.body(body).name or f"body_{body}"

    def _owner(self, body: int) -> str:
        """Return the model that a body is in."""
        return f"{self._name}_ground" if body == _WORLD else self._body(int(self._m.body_rootid[body]))

    def _geom_name(self, geom: int) -> str:
        return (self._m.geom(geom).name or f"geom_{geom}").replace("/", "_")

    def _joint_name(self, joint: int) -> str:
        name = self._m.joint(joint).name or f"joint_{joint}"
        bodies = {self._body(body) for body in range(self._m.nbody)}
        return f"{name}_joint" if name in bodies else name  # in SDF a joint cannot have the name of a link

    def _pose(self, kind: str, number: int) -> Pose:
        position, turn = getattr(self._m, f"{kind}_pos")[number], getattr(self._m, f"{kind}_quat")[number]
        return Pose(_vector(position), _quaternion(turn))


def _cached(name: str, content: Any, write: Callable[[Path], None]) -> Path:
    """Return a file with an array, which is written once."""
    digest = hashlib.blake2b(content.tobytes(), digest_size=16).hexdigest()
    folder = cached_folder("mjcf", digest, lambda new: write(new / name), lambda old: (old / name).is_file())
    return folder / name


def _triangles(m: Any, mesh: int) -> Any:
    """Return the triangles of a mesh after MuJoCo's scaling and centring, shape ``(n, 3, 3)``."""
    vertices = m.mesh_vert[m.mesh_vertadr[mesh] :][: m.mesh_vertnum[mesh]]
    faces = m.mesh_face[m.mesh_faceadr[mesh] :][: m.mesh_facenum[mesh]]
    return vertices[faces].astype(np.float64)


def _fixed(name: str, parent: str, child: str, *, preserved: bool) -> str:
    ends = f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>"
    kept = f' {PRESERVED}="true"' if preserved else ""
    return f'<joint name={quoteattr(name)} type="fixed"{kept}>{ends}</joint>'


def _command(actuator: str, low: float, high: float) -> str:
    """Return the plugin that commands an actuator for MuJoCo."""
    limits = f"<lowest>{low}</lowest><highest>{high}</highest>" if np.isfinite([low, high]).all() else ""
    name = f"<actuator>{escape(actuator)}</actuator>{_topic(actuator, '/cmd')}"
    return _plugin("nrp_actuator", actuator, f"{name}{limits}")


def _topic(actuator: str, command: str = "") -> str:
    topic = re.sub(r"\W+", "_", actuator)
    return f"<topic>{topic}{command}</topic>"


def _plugin(file: str, name: str, elements: str) -> str:
    return f"<plugin name={quoteattr(name)} filename={quoteattr(file)}>{elements}</plugin>"


def _inertial(inertial: Inertial) -> str:
    xx, yy, zz = inertial.inertia[:3]
    inertia = f"<inertia><ixx>{xx}</ixx><iyy>{yy}</iyy><izz>{zz}</izz></inertia>"
    return f"<inertial><mass>{inertial.mass}</mass>{_pose(inertial.pose)}{inertia}</inertial>"


def _pose(pose: Pose, relative_to: str = "") -> str:
    frame = f" relative_to={quoteattr(relative_to)}" if relative_to else ""
    numbers = _text((*pose.position, *pose.orientation))
    return f'<pose rotation_format="quat_xyzw"{frame}>{numbers}</pose>'


def _text(numbers: Iterable[float]) -> str:
    return " ".join(str(float(number)) for number in numbers)


def _vector(numbers: Any) -> Vector:
    x, y, z = numbers.tolist()
    return x, y, z


def _quaternion(scalar_first: Any) -> Quaternion:
    w, x, y, z = scalar_first.tolist()
    return x, y, z, w
