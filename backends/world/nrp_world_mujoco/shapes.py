"""Shapes as MuJoCo's geoms; joints, loops of joints and ties of models as its constraints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, Final

from nrp_core.findings import Findings
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.loops import Freedom, Tie
from nrp_core.scene.model import (
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
)
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.tessellation import triangles_of
from nrp_world_mujoco.library import COLLISIONS, mujoco, pos_quat
from nrp_world_mujoco.surfaces import Surfaces

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


def _add_geom(body: Any, name: str, *given: Mapping[str, Any]) -> Any:
    """Add a geom; setting its attributes takes half as long as passing them as arguments."""
    geom = body.add_geom()
    geom.name = name
    for arguments in given:
        for attribute, value in arguments.items():
            setattr(geom, attribute, value)
    return geom


class Shapes:
    """Adds shapes to the bodies of a specification; a mesh is loaded once."""

    def __init__(self, spec: Any, scene: Scene, warnings: Findings) -> None:
        self._spec = spec
        self._meshes: dict[Mesh, str] = {}
        self._surfaces = Surfaces(spec, scene, warnings)

    def add_collision(self, body: Any, collision: Collision, place: Pose, name: str) -> list[Any]:
        """Add a collision of a link at ``place`` in a body, and return its geoms, the first with its name.

        It has several if it is a concave surface that is not a ground: one for each of its cells.
        """
        touching = {
            "mass": 0,
            "group": COLLISIONS,
            "contype": collision.category,
            "conaffinity": collision.touched,
            "condim": 1 if not collision.friction else 4 if collision.torsion else 3,
            "friction": [collision.friction, collision.torsion, 0],  # rolling: those of MJCF are their own
            # in a contact the geom with the higher priority decides: the more slippery one; those of MJCF
            # have their own, usually 0, so that their contacts are MuJoCo's
            "priority": round(1000 * (1 - collision.friction)),
        }
        geometry, pose = collision.geometry, place @ collision.pose
        if not isinstance(geometry, ConcaveMesh):
            return [_add_geom(body, name, touching, self._arguments(geometry, pose))]
        return [
            _add_geom(body, f"{name}/{number}" if number else name, touching, part.placed(pose))
            for number, part in enumerate(self._surfaces.parts(name))
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
                return self._surfaces.height_map(geometry).placed(pose)
            case Mesh():
                return {"type": kinds.mjGEOM_MESH, "meshname": self._mesh(geometry), **pos_quat(pose)}

    def _mesh(self, mesh: Mesh) -> str:
        if mesh not in self._meshes:
            self._meshes[mesh] = f"mesh{len(self._meshes)}"
            vertices, faces = triangles_of(mesh)
            element = self._spec.add_mesh(
                name=self._meshes[mesh], uservert=vertices.ravel(), userface=faces.ravel()
            )
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used
        return self._meshes[mesh]


LIGHT: Final = 1e-3
"""Mass and inertia of a body between two models, as a share of the lighter one's."""
Links = Mapping[str, tuple[Any, Pose]]
"""The links of a model: the body of each, and its pose in the frame of that."""


def close_loops(model: Model, links: Links, spec: Any) -> None:
    """Keep the links of loops together at the points where they meet with all joints at 0."""
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
    """Keep a point of a body on another body, at its place with all joints at 0."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=element.name,
        name2=holder,
        data=[*point, *[0.0] * (mujoco.mjNEQDATA - 3)],
        solref=shortest(spec),
        solimp=impedance,
    )
