"""Shapes as MuJoCo's geoms; joints, loops of joints and ties of models as its constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import drawn, flat
from nrp_core.world.rigid import Pose, Quaternion, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.loops import Freedom, Tie
from nrp_core.world.scene.meshes.shapes import heights_of
from nrp_core.world.scene.model import (
    Box,
    Capsule,
    Collision,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Joint,
    Mesh,
    Model,
    Plane,
    Scene,
    Sphere,
    Visual,
)
from nrp_core.world.scene.tessellation import box_around, triangles_of
from nrp_world_mujoco.library import COLLISIONS, VISUALS, mujoco

FAR_AWAY = 1e9
SMALLEST = 1e-12  # MuJoCo refuses an empty range
HARD = [0.999, 0.999, 0.001, 0.5, 2.0]  # impedance of stiff constraints: couplings, joints that rub or stop
FIRMEST = [0.9999, 0.9999, 0.001, 0.5, 2.0]  # of joints that no load moves off their paths
_TYPES = {"prismatic": mujoco.mjtJoint.mjJNT_SLIDE, "ball": mujoco.mjtJoint.mjJNT_BALL}


def shortest(spec: Any) -> list[float]:
    """Return the shortest time constant (s) of a constraint, with the damping ratio."""
    return [2 * spec.option.timestep, 1.0]


def add_joint(element: Any, name: str, joint: Joint | Freedom, stiff: Sequence[float]) -> Any:
    """Add a joint to a body; it rubs and stops as hard as the step allows."""
    limited = joint.kind != "continuous" and (isfinite(joint.lower) or isfinite(joint.upper))
    return element.add_joint(
        name=name,
        type=_TYPES.get(joint.kind, mujoco.mjtJoint.mjJNT_HINGE),
        axis=joint.axis,
        limited=limited,
        range=_range(joint) if limited else [0, 0],
        damping=[joint.damping, 0, 0],
        frictionloss=joint.friction,
        stiffness=[joint.stiffness, 0, 0],
        springref=joint.rest,
        solref_friction=stiff,
        solimp_friction=HARD,
        solref_limit=stiff,
        solimp_limit=HARD,
    )


def _range(joint: Joint | Freedom) -> list[float]:
    lower = max(joint.lower, -FAR_AWAY)
    return [lower, max(min(joint.upper, FAR_AWAY), lower + SMALLEST)]


THICKNESS = 1.0
"""Thickness of the ground below the lowest point of a height map, m."""
MIN_EXTENT = 1e-6
"""Minimum height of a height map in MuJoCo, m."""


@dataclass(frozen=True)
class _Cell:
    """A convex part of a surface.

    Args:
        pose: its pose in the frame of the surface.
        shape: the arguments of its geoms.
    """

    pose: Pose
    shape: Mapping[str, Any]

    def placed(self, pose: Pose) -> dict[str, Any]:
        """Return the arguments of its geom for a pose of the surface."""
        return {**self.shape, **pos_quat(pose @ self.pose)}


def _boxes_of(cells: Sequence[FloatArray]) -> dict[int, _Cell]:
    """Return as boxes the cells with a rectangle as their front, and the same behind it, by their numbers."""
    numbers = [number for number, corners in enumerate(cells) if len(corners) == 8]
    if not numbers:
        return {}
    corners = np.stack([cells[number] for number in numbers])
    front, back = corners[:, :4], corners[:, 4:]
    edges = np.stack([front[:, 1] - front[:, 0], front[:, 3] - front[:, 0], front[:, 0] - back[:, 0]], axis=1)
    sizes = np.linalg.norm(edges, axis=2)
    axes = edges / sizes[:, :, None]
    closed = np.abs(front[:, 0] - front[:, 1] + front[:, 2] - front[:, 3]).max(axis=1) <= 1e-6
    square = np.abs(axes @ axes.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2)) <= 1e-4
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    orientation, found = np.empty(4), {}
    for each in np.flatnonzero(closed & square).tolist():
        mujoco.mju_mat2Quat(orientation, axes[each].T.ravel())
        w, x, y, z = orientation.tolist()
        pose = Pose(tuple(corners[each].mean(axis=0).tolist()), (x, y, z, w))
        found[numbers[each]] = _Cell(pose, {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": sizes[each] / 2})
    return found


class Shapes:
    """Adds shapes to the bodies of a specification; a mesh is loaded once."""

    def __init__(self, spec: Any, scene: Scene) -> None:
        self._spec, self._scene = spec, scene
        self._meshes: dict[Mesh, str] = {}
        self._cells: dict[Mesh, list[_Cell]] = {}

    def add_visual(self, body: Any, visual: Visual, place: Pose) -> Any:
        """Add a visual of a link at ``place`` in a body, and return its geom."""
        geometry, pose = drawn(visual.geometry, place @ visual.pose)
        looks = {"group": VISUALS, "contype": 0, "conaffinity": 0, "rgba": flat(visual.rgba)}
        return body.add_geom(mass=0, **looks, **self._arguments(geometry, pose))

    def add_collision(self, body: Any, collision: Collision, place: Pose, name: str) -> list[Any]:
        """Add a collision of a link at ``place`` in a body, and return its geoms, the first with its name.

        It has several if it is a concave surface that is not a ground: one for each of its cells.
        """
        touching = {
            "mass": 0,
            "group": COLLISIONS,
            "contype": collision.category,
            "conaffinity": collision.touched,
            "condim": 3 if collision.friction else 1,
            "friction": [collision.friction, 0, 0],
            # in a contact the geom with the higher priority decides: the more slippery one; those of MJCF
            # have their own, usually 0, so that their contacts are MuJoCo's
            "priority": round(1000 * (1 - collision.friction)),
        }
        geometry, pose = collision.geometry, place @ collision.pose
        if not isinstance(geometry, ConcaveMesh):
            return [body.add_geom(name=name, **touching, **self._arguments(geometry, pose))]
        if ground := self._ground_of(geometry, name):
            hfield, place = ground
            field = {"type": mujoco.mjtGeom.mjGEOM_HFIELD, "hfieldname": hfield, **pos_quat(pose @ place)}
            return [body.add_geom(name=name, **touching, **field)]
        return [
            body.add_geom(name=f"{name}/{number}" if number else name, **touching, **cell.placed(pose))
            for number, cell in enumerate(self._cells_of(geometry))
        ]

    def _arguments(self, geometry: Geometry, pose: Pose) -> dict[str, Any]:
        kinds = mujoco.mjtGeom
        match geometry:
            case Box((x, y, z)):
                return {"type": kinds.mjGEOM_BOX, "size": [x / 2, y / 2, z / 2], **pos_quat(pose)}
            case Sphere(radius):
                return {"type": kinds.mjGEOM_SPHERE, "size": [radius, 0, 0], **pos_quat(pose)}
            case Cylinder(radius, length):
                return {
                    "type": kinds.mjGEOM_CYLINDER,
                    "size": [radius, length / 2, 0],
                    **pos_quat(pose),
                }
            case Capsule(radius, length):
                return {
                    "type": kinds.mjGEOM_CAPSULE,
                    "size": [radius, length / 2, 0],
                    **pos_quat(pose),
                }
            case Plane():
                return {"type": kinds.mjGEOM_PLANE, "size": [0, 0, 1], **pos_quat(pose)}
            case Heightmap():
                name, bottom = self._ground(geometry)
                return {"type": kinds.mjGEOM_HFIELD, "hfieldname": name, **pos_quat(pose @ bottom)}
            case Mesh():
                return {"type": kinds.mjGEOM_MESH, "meshname": self._mesh(geometry), **pos_quat(pose)}

    def _ground(self, ground: Heightmap) -> tuple[str, Pose]:
        """Load a height map; return its name, and the height of its lowest point."""
        x, y, z = ground.scale
        return self._field(ground, (x / 2, y / 2), heights_of(ground) * z)

    def _field(self, mesh: Mesh, half: tuple[float, float], heights: FloatArray) -> tuple[str, Pose]:
        """Load heights on a rectangle about the origin; return their name, and the lowest point."""
        lowest, extent = float(heights.min()), max(float(np.ptp(heights)), MIN_EXTENT)
        rows, columns = heights.shape
        if mesh not in self._meshes:
            self._meshes[mesh] = f"ground{len(self._meshes)}"
            self._spec.add_hfield(
                name=self._meshes[mesh], nrow=rows, ncol=columns,
                size=[*half, extent, THICKNESS], userdata=((heights - lowest) / extent).ravel(),
            )  # fmt: skip
        return self._meshes[mesh], Pose((0.0, 0.0, lowest))

    def _ground_of(self, surface: ConcaveMesh, name: str) -> tuple[str, Pose] | None:
        """Load a surface as heights; None if it is not a ground, or if something is beneath it."""
        from nrp_core.world.scene.meshes.ground import ground_of  # compiled code takes time to load

        ground = ground_of(*triangles_of(surface))
        if ground is None or ground.is_above(self._others_from(name)):
            return None
        x, y = ((ground.low + ground.high) / 2).tolist()
        across, along = ((ground.high - ground.low) / 2).tolist()
        field, bottom = self._field(surface, (across, along), ground.heights)
        return field, Pose((x, y, 0.0)) @ bottom

    def _others_from(self, name: str) -> FloatArray:
        """Return the middles of the other collisions in the frame of one, shape ``(n, 3)``."""
        shapes = {
            f"{model.name}/{link.name}/{each.name}": (model.pose @ link.pose @ each.pose, each.geometry)
            for model in self._scene.models
            for link in model.links
            for each in link.collisions
        }
        back = shapes.pop(name)[0].inverse()
        boxes = (box_around([(back @ pose, geometry)]) for pose, geometry in shapes.values())
        return np.array([(low + high) / 2 for low, high in filter(None, boxes)]).reshape(-1, 3)

    def _cells_of(self, surface: ConcaveMesh) -> list[_Cell]:
        """Load the convex cells of a surface, once."""
        if surface not in self._cells:
            from nrp_core.world.scene.meshes.cells import cells  # compiled code takes time to load

            number, (vertices, faces) = len(self._cells), triangles_of(surface)
            found = cells(vertices[faces], surface.depth)
            boxes = _boxes_of(found)
            self._cells[surface] = [
                boxes.get(cell) or self._cell(f"cell{number}/{cell}", corners)
                for cell, corners in enumerate(found)
            ]
        return self._cells[surface]

    def _cell(self, name: str, corners: FloatArray) -> _Cell:
        element = self._spec.add_mesh(name=name, uservert=corners.ravel())
        element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used
        return _Cell(Pose(), {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": name})

    def _mesh(self, mesh: Mesh) -> str:
        if mesh not in self._meshes:
            self._meshes[mesh] = f"mesh{len(self._meshes)}"
            vertices, faces = triangles_of(mesh)
            element = self._spec.add_mesh(
                name=self._meshes[mesh], uservert=vertices.ravel(), userface=faces.ravel()
            )
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used
        return self._meshes[mesh]


def pos_quat(pose: Pose) -> dict[str, Any]:
    """Return a pose as MuJoCo's arguments."""
    return {"pos": pose.position, "quat": scalar_first(pose.orientation)}


def scalar_first(orientation: Quaternion) -> Quaternion:
    """Return a quaternion in MuJoCo's order, w first."""
    x, y, z, w = orientation
    return w, x, y, z


LIGHT: Final = 1e-3
"""Mass and inertia of a body between two models, as a share of the lighter one's."""
Links = Mapping[str, tuple[Any, Pose]]
"""The links of a model: the body of each, and its pose in the frame of that."""


def close_loops(model: Model, links: Links, spec: Any) -> None:
    """Keep the links of loops together at their points, as they are where all joints are at 0."""
    for loop in model.loops:
        element, _ = links[loop.child]
        holder = "world" if loop.parent == WORLD else links[loop.parent][0].name
        for point in loop.points if holder != element.name else ():  # or they are one body already
            _connect(element, holder, _in_body(model, links, loop.child, point), spec)


def tie_models(scene: Scene, links: Mapping[str, Links], spec: Any) -> None:
    """Hold models together at the points of their ties; the bodies that these connect do not collide."""
    for tie in scene.ties:
        ends = (tie.parent, [there for there, _ in tie.points]), (tie.child, [here for _, here in tie.points])
        (holder, at_holder), (held, at_held) = (
            (links[name][link][0], [_in_body(scene.model(name), links[name], link, each) for each in points])
            for (name, link), points in ends
        )
        if holder is held is spec.worldbody:
            continue
        if tie.freedoms:
            _carry(tie, scene.model(tie.parent[0]), links[tie.parent[0]], held, spec)
        elif held is spec.worldbody:
            _connect_all(holder, held, at_holder, spec)
        else:
            _connect_all(held, holder, at_held, spec)
        if spec.worldbody not in (holder, held):
            spec.add_exclude(bodyname1=held.name, bodyname2=holder.name)


def _carry(tie: Tie, model: Model, links: Links, held: Any, spec: Any) -> None:
    """Let a body move on the parent of a tie by its freedoms, and connect it with the child."""
    holder, place = links[tie.parent[1]]
    frame = place @ model.link(tie.parent[1]).pose.inverse() @ tie.in_parent
    heavy = [each for each in (holder, held) if each is not spec.worldbody]
    mass = LIGHT * min(each.mass for each in heavy)
    moment = LIGHT * min(float(min(each.inertia)) for each in heavy)
    carrier = holder
    for number, freedom in enumerate(tie.freedoms):
        path = f"{tie.name}/{number}/tie"
        carrier = carrier.add_body(name=path, **pos_quat(Pose() if number else frame))
        carrier.explicitinertial, carrier.mass, carrier.inertia = True, mass, [moment] * 3
        carrier.gravcomp = 1.0
        add_joint(carrier, path, freedom, shortest(spec))
    points = [(tie.in_parent.inverse() @ Pose(there)).position for there, _ in tie.points]
    _connect_all(carrier, held, points, spec, FIRMEST)  # or the light body gives way


def _in_body(model: Model, links: Links, link: str, point: Vector) -> Vector:
    """Return a point of a model in the frame of the body with a link."""
    _, place = links[link]
    return (place @ model.link(link).pose.inverse() @ Pose(point)).position


def _connect_all(
    element: Any, other: Any, points: Sequence[Vector], spec: Any, impedance: Sequence[float] = HARD
) -> None:
    for point in points:
        _connect(element, other.name, point, spec, impedance)


def _connect(element: Any, holder: str, point: Vector, spec: Any, impedance: Sequence[float] = HARD) -> None:
    """Keep a point of a body at another one, where it is with all joints at 0."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=element.name,
        name2=holder,
        data=[*point, *[0.0] * (mujoco.mjNEQDATA - 3)],
        solref=shortest(spec),
        solimp=impedance,
    )
