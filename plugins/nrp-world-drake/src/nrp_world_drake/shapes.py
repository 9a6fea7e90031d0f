"""Collision shapes in Drake: stiffness, friction of pairs, and which shapes touch.

Drake has two models of contact. Pressure fields (hydroelastic contact) press whole faces on each other, so
that boxes stand; one of the two bodies needs a volume mesh. Points need no mesh: balls and wheels roll as the
exact shapes that they are. Every shape has the model that suits it. A shape that touches by points touches
surfaces that are not convex by a pressure field.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, Final

import numpy as np

from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import Body
from nrp_core.world import (
    BodyPath,
    Box,
    Capsule,
    Collision,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Mesh,
    Plane,
    Pose,
    Sphere,
    triangles_of,
)
from nrp_world_drake.library import MemoryFile, drake_geometry, multibody, transform

FIRMNESS: Final = 2.0
"""The frequency of a body on its own contact, times the step: as stiff as the step resolves.

A body at rest sinks in by ``g (step / FIRMNESS)^2``, 10 um at 2 ms.
"""
DISSIPATION: Final = 200.0
"""Of Hunt and Crossley, s/m: what hits faster than 5 mm/s does not bounce. With less, wheels chatter."""
RIGID: Final = 1e12
"""Stiffness (N/m) at a point of what does not move."""
SHARE: Final = 0.1
"""The least share of the mass of its model that a body counts with, for it may carry the others."""
FINENESS: Final = 4.0
"""The radius of a round shape, over the length of the edges of its mesh."""
UPRIGHT: Final = 0.999
THINNEST: Final = 1e-4
"""The thickness (m) of a mesh up to which Drake may find no pressure field, so that it touches by points."""


@dataclass(frozen=True)
class Part:
    """A shape of a link, as often as pairs need it: one geometry for each coefficient of friction.

    Args:
        owner: its model, and the index of its body there.
        body: Drake's body.
        pose: its pose in the frame of that.
        collision: the shape.
        fixed: whether it does not move.
        stiffness: of its contacts, N/m.
        wheel: whether it is a cylinder that turns about its axis on a joint.
    """

    owner: BodyPath
    body: Any
    pose: Pose
    collision: Collision
    fixed: bool
    stiffness: float
    wheel: bool

    @property
    def is_concave(self) -> bool:
        """Whether it is a surface that need not be convex."""
        return isinstance(self.collision.geometry, ConcaveMesh | Heightmap)

    @property
    def is_exact(self) -> bool:
        """Whether it touches by points, and not by a mesh."""
        return isinstance(self.collision.geometry, Sphere | Capsule) or self.wheel


@dataclass(frozen=True)
class _Kind:
    """Parts that are alike for all rules of what touches what, and by which friction."""

    model: str
    fixed: bool
    friction: float
    category: int
    touched: int
    concave: bool

    @classmethod
    def of(cls, part: Part) -> _Kind:
        shape = part.collision
        return cls(part.owner[0], part.fixed, shape.friction, shape.category, shape.touched, part.is_concave)

    def meets(self, other: _Kind) -> bool:
        """Return whether parts of these kinds can touch."""
        if self.model == other.model or (self.fixed and other.fixed):
            return False
        return bool(self.category & other.touched or other.category & self.touched)


@dataclass(frozen=True)
class _Copy:
    """A geometry of a part.

    Args:
        kind: that of the part.
        friction: its coefficient, the smaller one of all pairs in which it touches.
        on_surfaces: True if it touches concave surfaces only, False if it does not; None: both.
    """

    kind: _Kind
    friction: float
    on_surfaces: bool | None

    def meets(self, other: _Copy) -> bool:
        """Return whether geometries of these kinds touch; a pair of parts does so by one pair of theirs."""
        if self.friction != other.friction or not self.kind.meets(other.kind):
            return False
        if self.friction != min(self.kind.friction, other.kind.friction):
            return False
        return other.on_surfaces in (None, self.kind.concave) and self.on_surfaces in (
            None,
            other.kind.concave,
        )


class Shapes:
    """Registers the shapes of a scene.

    Args:
        plant: Drake's plant.
        scene_graph: its geometry.

    Attributes:
        owners: model and body of each geometry.
        fields: extent (m) and modulus (Pa) of the pressure field of each geometry.
    """

    def __init__(self, plant: Any, scene_graph: Any) -> None:
        self._plant, self._scene_graph = plant, scene_graph
        self.owners: dict[Any, BodyPath] = {}
        self.fields: dict[Any, tuple[float, float]] = {}
        self._meshes: dict[Mesh, Any] = {}

    def register(self, parts: Sequence[Part]) -> None:
        """Add all parts of a scene, and exclude the pairs that do not touch."""
        kinds = {part: _Kind.of(part) for part in parts}
        every = dict.fromkeys(kinds.values())
        surfaces = any(kind.concave for kind in every)
        geometries: dict[_Copy, list[Any]] = {}
        for number, (part, kind) in enumerate(kinds.items()):
            for copy in self._copies_of(part, kind, every, surfaces):
                name = f"{number}/{part.owner[0]}/{part.collision.name}/{copy.friction:g}/{copy.on_surfaces}"
                geometries.setdefault(copy, []).append(self._add(part, copy, name))
        self._filter(geometries)

    def _copies_of(self, part: Part, kind: _Kind, every: Iterable[_Kind], surfaces: bool) -> Iterator[_Copy]:
        """Yield the geometries that a part needs."""
        partners = [other for other in every if kind.meets(other)]
        for friction in sorted({min(kind.friction, other.friction) for other in partners}):
            if surfaces and part.is_exact and not part.fixed:
                yield from (_Copy(kind, friction, on_surfaces) for on_surfaces in (False, True))
            else:
                yield _Copy(kind, friction, None)

    def _filter(self, geometries: Mapping[_Copy, Sequence[Any]]) -> None:
        """Exclude pairs of geometries."""
        declaration = drake_geometry.CollisionFilterDeclaration()
        sets = {copy: drake_geometry.GeometrySet(list(each)) for copy, each in geometries.items()}
        for one, other in combinations(sets, 2):
            if not one.meets(other) and not (one.kind.fixed and other.kind.fixed):
                declaration.ExcludeBetween(sets[one], sets[other])
        for copy, each in sets.items():
            if not copy.meets(copy):
                declaration.ExcludeWithin(each)
        self._scene_graph.collision_filter_manager().Apply(declaration)

    def _add(self, part: Part, copy: _Copy, name: str) -> Any:
        shape = self._shape(part.collision.geometry, name)
        extent, area, edge = _extents(part.collision.geometry)
        thin = isinstance(part.collision.geometry, Mesh) and extent <= THINNEST / 2 and not part.fixed
        pointlike = thin or (part.is_exact and copy.on_surfaces is not True)
        properties = drake_geometry.ProximityProperties()
        drake_geometry.AddContactMaterial(
            dissipation=0.0 if part.fixed else DISSIPATION,
            point_stiffness=part.stiffness,
            friction=multibody.CoulombFriction(copy.friction, copy.friction),
            properties=properties,
        )
        modulus = part.stiffness * extent / area
        if not pointlike and part.fixed:
            drake_geometry.AddRigidHydroelasticProperties(edge, properties)
        elif not pointlike:
            drake_geometry.AddCompliantHydroelasticProperties(edge, modulus, properties)
        try:
            ident = self._plant.RegisterCollisionGeometry(
                part.body, transform(part.pose), shape, name, properties
            )
        except RuntimeError as error:
            where = f"the collision '{part.collision.name}' of '{part.owner[0]}'"
            raise SceneError(f"Drake cannot use {where}: {error}") from error
        self.owners[ident] = part.owner
        self.fields[ident] = (0.0, 1.0) if part.fixed else (extent, modulus)
        return ident

    def _shape(self, geometry: Geometry, name: str) -> Any:
        match geometry:
            case Box(size):
                return drake_geometry.Box(*size)
            case Sphere(radius):
                return drake_geometry.Sphere(radius)
            case Cylinder(radius, length):
                return drake_geometry.Cylinder(radius, length)
            case Capsule(radius, length):
                return drake_geometry.Capsule(radius, length)
            case Plane():
                return drake_geometry.HalfSpace()
            case Mesh():
                return self._mesh(geometry, name)

    def _mesh(self, mesh: Mesh, name: str) -> Any:
        if mesh not in self._meshes:
            vertices, faces = triangles_of(mesh)
            if isinstance(mesh, ConcaveMesh | Heightmap):
                corners = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
                triangles = [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
                file = MemoryFile("\n".join([*corners, *triangles, ""]), ".obj", name)
                self._meshes[mesh] = drake_geometry.Mesh(drake_geometry.InMemoryMesh(mesh_file=file))
            else:
                self._meshes[mesh] = drake_geometry.Convex(vertices.T, name)
        return self._meshes[mesh]


def _extents(geometry: Geometry) -> tuple[float, float, float]:
    """Return the depth of a solid (m), the area of a face (m^2), and the edges of a mesh (m)."""
    match geometry:
        case Box(size):
            low, middle, high = sorted(size)
            return low / 2, middle * high, high
        case Sphere(radius) | Capsule(radius, _):
            return radius, radius**2, radius / FINENESS
        case Cylinder(radius, length):
            return min(radius, length / 2), radius * max(radius, length), radius / FINENESS
        case Plane():
            return 1.0, 1.0, 1.0
        case Mesh():
            low, middle, high = sorted(np.ptp(triangles_of(geometry)[0], axis=0).tolist())
            return max(low, THINNEST) / 2, max(middle * high, 1e-8), high


def parts_of(model: str, bodies: Sequence[tuple[Body, Any]], world: Any, step_s: float) -> Iterator[Part]:
    """Yield the shapes of a model.

    Args:
        model: its name.
        bodies: its bodies, with Drake's.
        world: Drake's body for what is fixed.
        step_s: the physics step.
    """
    whole = sum(body.inertial.mass for body, _ in bodies if body.inertial)
    for index, (body, place) in enumerate(bodies):
        fixed = body.fixed
        frame = body.pose if fixed else Pose()
        mass = max(body.inertial.mass, SHARE * whole) if body.inertial else 0.0
        stiffness = RIGID if fixed else mass * (FIRMNESS / step_s) ** 2
        for link in body.links:
            for collision in link.collisions:
                pose = frame @ link.pose @ collision.pose
                wheel = _is_wheel(body, link.pose @ collision.pose, collision.geometry)
                for number, (geometry, at) in enumerate(_pieces(collision.geometry)):
                    piece = replace(
                        collision, geometry=geometry, name=f"{link.name}/{collision.name}/{number}"
                    )
                    yield Part(
                        (model, index), world if fixed else place, pose @ at, piece, fixed, stiffness, wheel
                    )


def _is_wheel(body: Body, pose: Pose, geometry: Geometry) -> bool:
    """Return whether a shape is a cylinder that turns about its own axis on a joint."""
    if not isinstance(geometry, Cylinder) or body.joint is None:
        return False
    along = sum(a * b for a, b in zip(pose.rotate((0.0, 0.0, 1.0)), body.joint.axis, strict=True))
    return body.joint.kind in ("revolute", "continuous") and abs(along) > UPRIGHT


def _pieces(geometry: Geometry) -> Iterable[tuple[Geometry, Pose]]:
    """Return a shape; a capsule also with the balls at its ends, on which it lies."""
    if not isinstance(geometry, Capsule):
        return [(geometry, Pose())]
    ends = [
        (Sphere(geometry.radius), Pose((0.0, 0.0, z))) for z in (-geometry.length / 2, geometry.length / 2)
    ]
    return [(geometry, Pose()), *ends]
