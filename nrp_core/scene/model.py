"""A scene as data: robots and rooms, the same for every world backend.

SI units, x forward, y left, z up. Names are those of SDF; sensors and drives come from the standard tags of a
file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, pi
from pathlib import Path
from typing import ClassVar, TypeVar

from nrp_core._support.checked_arguments import checks_arguments, require_fields
from nrp_core._support.overview import Overview, Row
from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Finding
from nrp_core.scene.consistency import WORLD, check_pose, check_tree, check_unique, require
from nrp_core.scene.devices import (
    ANY_CAMERA,
    LATER,
    GroupController,
    Imperfection,
    JointController,
    MountedDrive,
    MountedSensor,
    PairController,
    TrajectoryController,
    digest_of,
    set_fields,
)
from nrp_core.scene.loops import Loop as Loop
from nrp_core.scene.loops import Tie as Tie
from nrp_core.scene.origin import Native, Source
from nrp_core.scene.randomization import Randomization
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.surroundings import Surroundings

PLASTIC = (0.04, 0.04, 0.04)
"""Reflectance of glass, plastics and paint at normal incidence."""


@dataclass(frozen=True, slots=True)
class Finish:
    """How a surface shines in realistic images; a surface without a finish is matt.

    Args:
        roughness: 0 (smooth as a mirror) to 1; its square is the width of the distribution of the slopes of
            the facets that the surface consists of.
        metalness: from 0 for a dielectric, whose colour is diffuse, to 1 for a metal, whose colour is that of
            its reflection.
        reflectance: the share of red, green and blue that a dielectric reflects at normal incidence.
    """

    roughness: float = 0.5
    metalness: float = 0.0
    reflectance: tuple[float, float, float] = PLASTIC


Named = TypeVar("Named", "Link", "Joint", "Model")

Rgba = tuple[float, float, float, float]

DEFAULT_RGBA: Rgba = (0.7, 0.7, 0.7, 1.0)
UNIT_INERTIA = (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box:
    """A box about its centre; full edge lengths in m."""

    tag: ClassVar[str] = "box"
    size: Vector


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder about its centre, along z."""

    tag: ClassVar[str] = "cylinder"
    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Capsule:
    """A cylinder along z with half spheres on both ends; ``length`` is the cylinder's."""

    tag: ClassVar[str] = "capsule"
    radius: float
    length: float


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere about its centre."""

    tag: ClassVar[str] = "sphere"
    radius: float


@dataclass(frozen=True, slots=True)
class Plane:
    """An infinite plane through the origin, its normal along z; ``size`` (m) is the part that is drawn."""

    tag: ClassVar[str] = "plane"
    size: tuple[float, float] = (100.0, 100.0)


@dataclass(frozen=True, slots=True)
class Mesh:
    """A triangle mesh, scaled along its axes.

    Args:
        path: a binary STL file; meshes of any kind are converted by :mod:`nrp_core.scene.meshes`,
            which names it after a digest of its contents.
        scale: factors, which may mirror it.
    """

    tag: ClassVar[str] = "mesh"
    path: Path
    scale: Vector = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class ConcaveMesh(Mesh):
    """A part of a surface, which need not be convex; only for static models.

    Args:
        depth: thickness of the solid behind its triangles, m, for engines without such surfaces.
    """

    depth: float = 0.01


@dataclass(frozen=True, slots=True)
class Heightmap(Mesh):
    """Terrain with one height at each place, which need not be convex; only for static models.

    Args:
        rows, columns: size of the grid of corners of the mesh, along y and x.
    """

    tag: ClassVar[str] = "heightmap"
    rows: int = 2
    columns: int = 2


Geometry = Box | Cylinder | Capsule | Sphere | Plane | Mesh


@dataclass(frozen=True, slots=True)
class Texture:
    """An image on a visual.

    Meshes have texture coordinates of their own (:func:`nrp_core.scene.meshes.stl.read_coordinates`);
    those of other shapes are in :mod:`nrp_core.scene.meshes.triangles`.

    Args:
        image: a file, which is read when someone looks.
        tint: the red, green and blue by which the image is multiplied.
        content: a digest of the file, by which scenes are compared wherever it lies.
    """

    image: Path = field(compare=False)
    tint: Vector = (1.0, 1.0, 1.0)
    content: str = ""


@dataclass(frozen=True, slots=True)
class Visual:
    """The visible shape of a link.

    Args:
        rgba: its colour; with a texture the mean of the image.
        glows: whether it has its colour in any light.
        finish: how it shines; None: it is matt.
        texture: the image on it.
        label: its class for segmentation cameras, 1 to 255; 0: none.
        flags: bits; cameras draw it whose mask shares one.
    """

    name: str
    geometry: Geometry
    pose: Pose = Pose()
    rgba: Rgba = DEFAULT_RGBA
    glows: bool = False
    finish: Finish | None = None
    texture: Texture | None = field(default=None, metadata=LATER)
    label: int = field(default=0, metadata=LATER)
    flags: int = field(default=ANY_CAMERA, metadata=LATER)

    __setstate__ = set_fields


ALL_BITS = 0xFFFF
"""The category, and what it touches, of a shape whose file does not limit its collisions."""


TORSION_BY_RADIUS = 3 * pi / 16
"""The torsion of a contact patch with the pressure of Hertz and a coefficient of 1, by its radius."""


@dataclass(frozen=True, slots=True)
class Collision:
    """A collision shape of a link; ``friction`` is Coulomb's coefficient.

    Args:
        estimated: whether it is a box that replaces a missing mesh, so that its size is only an estimate.
        category, touched: bits of its own category, and of the categories that it touches.
        torsion: greatest torque about the normal of a contact by its normal force, m; engines combine
            those of two surfaces in different ways.
        rolling: the same for the torque against rolling; only MJCF has it.
    """

    name: str
    geometry: Geometry
    pose: Pose = Pose()
    friction: float = 1.0
    estimated: bool = field(default=False, compare=False, repr=False)
    category: int = field(default=ALL_BITS, metadata=LATER)
    touched: int = field(default=ALL_BITS, metadata=LATER)
    torsion: float = field(default=0.0, metadata=LATER)
    rolling: float = field(default=0.0, metadata=LATER)

    __setstate__ = set_fields

    @property
    def patch_radius(self) -> float:
        """The radius (m) of the contact patch that has this torsion with a coefficient of 1."""
        return self.torsion / TORSION_BY_RADIUS

    @property
    def is_selective(self) -> bool:
        """Whether its file limits the shapes that it touches."""
        return (self.category, self.touched) != (ALL_BITS, ALL_BITS)

    def touches(self, other: Collision) -> bool:
        """Return whether their bits let them collide, as in SDF, ODE and MuJoCo."""
        return bool(self.category & other.touched or other.category & self.touched)


@dataclass(frozen=True, slots=True)
class Inertial:
    """Mass (kg), centre of mass and inertia about it (ixx, iyy, izz, ixy, ixz, iyz in kg m^2).

    ``pose`` is in the frame of the link; the inertia is along the axes of ``pose``.
    """

    mass: float
    pose: Pose = Pose()
    inertia: tuple[float, float, float, float, float, float] = UNIT_INERTIA


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body; its pose is given in the model's frame.

    Args:
        inertial: its mass; None: without mass.
        gravity: whether gravity pulls it.
        decay: the rates at which its linear and its angular velocity decay exponentially, 1/s.
    """

    name: str
    pose: Pose = Pose()
    inertial: Inertial | None = None
    visuals: tuple[Visual, ...] = ()
    collisions: tuple[Collision, ...] = ()
    sensors: tuple[MountedSensor, ...] = ()
    gravity: bool = field(default=True, metadata=LATER)
    decay: tuple[float, float] = field(default=(0.0, 0.0), metadata=LATER)


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint that follows another one: its position is ``multiplier * leader + offset``."""

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint between two links.

    Args:
        name: unique in the model.
        kind: ``fixed``, ``revolute``, ``continuous``, ``prismatic`` or ``ball``. A joint with several axes is
            several joints in series.
        parent, child: links; ``world`` as parent fixes the child to the world.
        pose: pose of the joint in the model's frame.
        axis: unit vector in the joint's frame; unused for a ball joint.
        lower, upper: limits of the position, rad or m.
        effort: limit of force or torque, N or N m.
        velocity: limit of the velocity, rad/s or m/s.
        damping: damping, N m s/rad or N s/m.
        friction: static friction of the joint, N or N m.
        stiffness: stiffness of the spring, N m/rad or N/m.
        rest: rest position of the spring, rad or m.
        mimic: the joint that it follows, if any.
        preserved: whether the links of a fixed joint are two bodies in an engine.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose: Pose = Pose()
    axis: Vector = (0.0, 0.0, 1.0)
    lower: float = -inf
    upper: float = inf
    effort: float = inf
    velocity: float = inf
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: Mimic | None = None
    preserved: bool = field(default=False, metadata=LATER)

    __setstate__ = set_fields

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of its coordinates: three of the rotation vector (rad) for a ball joint, else one.

        A rotation vector points along the axis of the child's rotation against the parent and is as long as
        its angle; it is given along the axes of the joint's frame.
        """
        if self.kind == "fixed":
            return ()
        return tuple(f"{self.name}_{axis}" for axis in "xyz") if self.kind == "ball" else (self.name,)

    @property
    def takes_commands(self) -> bool:
        """Whether it has one degree of freedom, so that it can be controlled or be followed."""
        return len(self.coordinates) == 1


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A start of a robot that its file names.

    Args:
        name: its name.
        pose: the pose of the model in the world; None: any.
        starts: positions of joints, rad or m.
        targets: targets of position controllers before the first command, by joint; others hold the start.
    """

    name: str
    pose: Pose | None
    starts: tuple[tuple[str, float], ...]
    targets: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Model:
    """A robot or an object in the room; its pose is that of the model's frame in the world.

    Args:
        name: unique in the scene; a robot's is its id.
        links: the first one is the base (SDF's canonical link).
        joint_states_topic: the topic of its joint states, None for none.
        controllers: controllers of single joints.
        trajectory_controllers: controllers that make joints follow trajectories.
        pair_controllers: controllers of the mean or difference of two joints.
        native: elements of its file for a specific engine, which a scene cannot express.
        starts: positions of joints at the start; others start at 0, or at the limit nearest to it.
        loops: joints that close loops.
        warnings: warnings about repairs and unsupported elements of its file.
        source: the file that it was read from; None: it was created in Python.
        keyframes: starts that its file names, one of which an experiment may choose.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...] = ()
    drives: tuple[MountedDrive, ...] = ()
    pose: Pose = Pose()
    static: bool = False
    joint_states_topic: str | None = None
    controllers: tuple[JointController, ...] = ()
    trajectory_controllers: tuple[TrajectoryController, ...] = ()
    pair_controllers: tuple[PairController, ...] = ()
    native: tuple[Native, ...] = ()
    group_controllers: tuple[GroupController, ...] = field(default=(), metadata=LATER)
    starts: tuple[tuple[str, float], ...] = field(default=(), metadata=LATER)
    loops: tuple[Loop, ...] = field(default=(), metadata=LATER)
    warnings: tuple[Finding, ...] = field(default=(), compare=False, repr=False)
    source: Source | None = field(default=None, compare=False, repr=False)
    keyframes: tuple[Keyframe, ...] = field(default=(), metadata=LATER)  # last: recordings pickle models

    __setstate__ = set_fields

    @property
    def leaders(self) -> tuple[TrajectoryController | PairController | GroupController, ...]:
        """The controllers that lead several joints each."""
        return (*self.trajectory_controllers, *self.pair_controllers, *self.group_controllers)

    def link(self, name: str) -> Link:
        """Return a link by name."""
        return _find_named(self.links, name, f"model '{self.name}' has no link")

    def joint(self, name: str) -> Joint:
        """Return a joint by name."""
        return _find_named(self.joints, name, f"model '{self.name}' has no joint")

    def check(self) -> None:
        """Refuse an inconsistent model.

        Raises:
            SceneError: it has no link, two parts have the same name, a joint or drive names a part that does
                not exist, a pose is none, a link is held by two joints, or joints form a loop.
        """
        owner = f"the model '{self.name}'"
        check_pose(self.pose, owner)
        require_fields(self, owner)
        links = [link.name for link in self.links]
        if not links:
            raise SceneError(f"{owner} has no link")
        for link in self.links:
            check_pose(link.pose, f"the link '{link.name}' of {owner}")
        check_unique(links, "links", owner)
        check_unique((joint.name for joint in self.joints), "joints", owner)
        check_unique((name for joint in self.joints for name in joint.coordinates), "coordinates", owner)
        for link in self.links:
            for kind in ("visuals", "collisions", "sensors"):
                names = [part.name for part in getattr(link, kind)]
                check_unique(names, kind, f"the link '{link.name}' of {owner}")
        for joint in self.joints:
            for end, valid in ((joint.parent, [*links, WORLD]), (joint.child, links)):
                require(end, valid, f"the joint '{joint.name}' of {owner} names the link")
            if joint.mimic is not None:
                self._require_led(joint.mimic.leader, f"the joint '{joint.name}' of {owner} names the joint")
        self._check_acting(owner)
        check_tree(((joint.name, joint.parent, joint.child) for joint in self.joints), owner)

    def _check_acting(self, owner: str) -> None:
        for drive in self.drives:
            for joint_name in drive.joints:
                self._require_led(joint_name, f"the drive '{drive.name}' of {owner} names the joint")
            drive.check(self)
        balls = {joint.name for joint in self.joints if joint.kind == "ball"}
        for controller in self.controllers:
            if not (controller.joint in balls and controller.is_firm and controller.kind == "position"):
                self._require_led(controller.joint, f"a controller of {owner} names the joint")
        for leader in self.leaders:
            for joint_name in leader.joints:
                self._require_led(joint_name, f"the controller '{leader.name}' of {owner} names the joint")

    def _require_led(self, name: str, owner: str) -> None:
        """Refuse a joint that does not exist or that has more than one degree of freedom."""
        kinds = {joint.name: joint.kind for joint in self.joints}
        require(name, kinds, owner)
        if kinds[name] == "ball":
            raise SceneError(f"{owner} '{name}', a ball joint, which has no single axis")


@dataclass(frozen=True, slots=True)
class Light:
    """A light.

    Args:
        name: its name.
        kind: ``directional`` (from far away), ``point`` (to all sides) or ``spot``.
        pose: its pose; unused for a directional light.
        direction: its direction in the world; unused for a point light.
        diffuse: its colour; black is off.
        casts_shadows: whether objects in its light cast shadows.
        attenuation: range (m), constant, linear (1/m) and quadratic (1/m^2) factor: at a distance ``d``
            within its range the light is multiplied by ``1 / (constant + linear * d + quadratic * d^2)``.
        cone: for a spot, the full angles (rad) of full light and of any light.
    """

    name: str
    kind: str = "directional"
    pose: Pose = Pose()
    direction: Vector = (0.0, 0.0, -1.0)
    diffuse: Rgba = (1.0, 1.0, 1.0, 1.0)
    casts_shadows: bool = True
    attenuation: tuple[float, float, float, float] = (inf, 1.0, 0.0, 0.0)
    cone: tuple[float, float] = (pi / 4, pi / 2)


@dataclass(frozen=True, repr=False)
class Scene(Overview):
    """Everything that a world backend loads.

    Args:
        models: robots and everything around them.
        lights: the lights.
        gravity: m/s^2.
        warnings: features of its files that a world does not support.
        step_s: the time step that its file asks for, s. No engine uses it: steps belong to the experiment.
        surroundings: the Earth around it, for sensors.
        ties: joints between two models.
        command_delays: topics whose commands act late, with the delay, s.
        imperfections: topics without a sensor that are noisy, late or get lost.
        randomize: the ranges from which each seed draws; a world opens the scene with the values drawn for
            its own.
        drives: drives that act on every model, such as the water around them.

    Raises:
        SceneError: two models have the same name, or one of them or a tie is inconsistent.
    """

    models: tuple[Model, ...]
    lights: tuple[Light, ...] = ()
    gravity: Vector = (0.0, 0.0, -9.8)
    warnings: tuple[Finding, ...] = field(default=(), compare=False)
    step_s: float | None = field(default=None, compare=False)
    surroundings: Surroundings = field(default=Surroundings(), metadata=LATER)
    ties: tuple[Tie, ...] = field(default=(), metadata=LATER)
    command_delays: tuple[tuple[str, float], ...] = field(default=(), metadata=LATER)
    imperfections: tuple[tuple[str, Imperfection], ...] = field(default=(), metadata=LATER)
    randomize: tuple[Randomization, ...] = field(default=(), metadata=LATER)
    drives: tuple[MountedDrive, ...] = field(default=(), metadata=LATER)

    def __post_init__(self) -> None:
        require_fields(self, "the scene")
        check_unique((model.name for model in self.models), "models", "the scene")
        for model in self.models:
            model.check()
        for tie in self.ties:
            for name, link in (tie.parent, tie.child):
                self.model(name).link(link)

    def _overview(self) -> tuple[str, Iterable[Row]]:
        names = ", ".join(model.name for model in self.models)
        return f"with {names or 'no models'}", [
            ("model", "links", "joints", "sensors", "mass (kg)"),
            *(
                (
                    model.name,
                    len(model.links),
                    len(model.joints),
                    sum(len(link.sensors) for link in model.links),
                    "static"
                    if model.static
                    else f"{sum(link.inertial.mass for link in model.links if link.inertial):g}",
                )
                for model in self.models
            ),
        ]

    @checks_arguments()
    def with_model(self, model: Model) -> Scene:
        """Return this scene with one more model and its warnings."""
        return replace(self, models=(*self.models, model), warnings=(*self.warnings, *model.warnings))

    @checks_arguments()
    def without(self, name: str) -> Scene:
        """Return this scene without a model and its ties to others."""
        self.model(name)
        models = tuple(model for model in self.models if model.name != name)
        ties = tuple(tie for tie in self.ties if name not in (tie.parent[0], tie.child[0]))
        return replace(self, models=models, ties=ties)

    @checks_arguments()
    def with_pose(self, name: str, pose: Pose) -> Scene:
        """Return this scene with a model at another pose."""
        self.model(name)
        models = (replace(model, pose=pose) if model.name == name else model for model in self.models)
        return replace(self, models=tuple(models))

    def model(self, name: str) -> Model:
        """Return a model by name."""
        return _find_named(self.models, name, "the scene has no model")

    def visual(self, path: str) -> Visual:
        """Return a visual by its path ``model/link/visual``."""
        if path not in self.visuals:
            raise SceneError(f"the scene has no visual '{path}'{did_you_mean(path, self.visuals)}")
        return self.visuals[path]

    @cached_property
    def visuals(self) -> Mapping[str, Visual]:
        """Every visual by its path ``model/link/visual``."""
        return {
            f"{model.name}/{link.name}/{visual.name}": visual
            for model, link in self.links()
            for visual in link.visuals
        }

    def links(self) -> Iterator[tuple[Model, Link]]:
        """Return every link with its model."""
        return ((model, link) for model in self.models for link in model.links)

    @cached_property
    def digest(self) -> str:
        """Hash of everything in the scene except its sources; scenes with equal digests are equal."""
        return digest_of(self)


def _find_named(parts: Iterable[Named], name: str, lacking: str) -> Named:
    """Return a part by name.

    Raises:
        SceneError: the scene has none; the message begins with ``lacking``.
    """
    for part in parts:
        if part.name == name:
            return part
    raise SceneError(f"{lacking} '{name}'{did_you_mean(name, [part.name for part in parts])}")


def files_behind(whole: Scene | Model) -> Iterator[Path]:
    """Yield the files of meshes and images, which a process need not read again for a second run."""
    for link in whole.links if isinstance(whole, Model) else (link for _, link in whole.links()):
        shapes = [one.geometry for one in link.visuals] + [one.geometry for one in link.collisions]
        yield from (shape.path for shape in shapes if isinstance(shape, Mesh))
        yield from (visual.texture.image for visual in link.visuals if visual.texture is not None)
