"""Load a scene into a new Gazebo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nrp_core.clock import seconds
from nrp_core.scene.merged_bodies import Body
from nrp_core.world import Code, Findings, Geometry, Joint, Level, Mesh, Model, Pose, Scene
from nrp_core.world.engine_kit.planar_servo import PlanarServo, planar_drives, servo_of
from nrp_core.world.engine_kit.simulated import simulated_bodies
from nrp_core.world.render.cameras import optics_of
from nrp_world_gazebo.elements import Xml, link_name
from nrp_world_gazebo.options import GazeboOptions
from nrp_world_gazebo.own_files import NotOwnError, folders_of, own_sdf
from nrp_world_gazebo.plugin_drives import leave_out, turns_of
from nrp_world_gazebo.process import Gazebo, Run
from nrp_world_gazebo.world_file import write_world

_NAMED = 3
"""Number of models that a note names."""
NOWHERE = -1
"""The number of a link that there is not: a fixed body without shapes."""


@dataclass(frozen=True, slots=True)
class BodyHandle:
    """The handle of a body in Gazebo.

    Args:
        link: the number of its first link; those of fixed bodies do not move.
        held: pose of the body's frame in the frame of that link.
        others: the numbers of more links, which joints fix to the first.
    """

    link: int
    held: Pose
    others: tuple[int, ...] = ()

    @property
    def links(self) -> tuple[int, ...]:
        """All links of the body."""
        return (self.link, *self.others)


@dataclass(frozen=True, slots=True)
class Coordinate:
    """The handle of a joint in Gazebo.

    Args:
        model: its model.
        number: its number.
        joint: the joint.
        body: index of the body that it moves.
    """

    model: str
    number: int
    joint: Joint
    body: int


@dataclass(frozen=True, slots=True)
class Built:
    """A loaded scene and the handles of its parts in Gazebo.

    Args:
        gazebo: the process.
        bodies: bodies of each model with their handles.
        joints: handles of the coordinates of each model's joints, in the order of its file.
        drives: the servo of each drive, by model and drive.
        turns: of each drive that is left to a plugin of Gazebo, the sign of a turn to the left.
        owners: model and body of each link.
        own: the models that Gazebo reads from their own files.
        warnings: models that reach Gazebo in another form than their files have.
    """

    gazebo: Gazebo
    bodies: Mapping[str, list[tuple[Body, BodyHandle]]]
    joints: Mapping[str, dict[str, Coordinate]]
    drives: Mapping[tuple[str, str], PlanarServo]
    turns: Mapping[tuple[str, str], float]
    owners: Mapping[int, tuple[str, int]]
    own: frozenset[str]
    warnings: Findings


def build(scene: Scene, options: GazeboOptions) -> Built:
    """Start Gazebo with a scene.

    Args:
        scene: the scene.
        options: the options of the backend.

    Raises:
        BackendLoadError: Gazebo does not start.
        SceneError: the scene is inconsistent.
    """
    physical, step_s = options.drive != "planar", seconds(options.timestep)
    bodies = {model.name: simulated_bodies(model, step_s, physical) for model in scene.models}
    drives = {
        (model.name, drive.name): servo_of(model, drive, bodies[model.name], scene.gravity, physical)
        for model in scene.models
        for drive in planar_drives(model)
    }
    warnings = Findings()
    own = dict(_own_files(scene, bodies, warnings)) if options.models == "file" else {}
    turns: dict[tuple[str, str], float] = {}
    for model in scene.models:
        given = own.get(model.name)
        if options.drive == "plugin":
            turns.update(turns_of(model, given))
        elif given is not None:
            warnings.extend(leave_out(model, given))
    run = Run()
    if options.renderer == "gazebo" and (size := image_bytes(scene, options.image_scale)):
        with run.images.open("wb") as images:
            images.truncate(size)
    try:
        write_world(run, scene, options.timestep, bodies, own)
        folders = {folder for sdf in own.values() for folder in folders_of(sdf)}
        gazebo = Gazebo(run, options, sorted(folders.union(_mesh_folders(scene))))
    except BaseException:
        run.remove()
        raise
    places = {
        name: [(body, _place(name, body, gazebo, name in own)) for body in parts]
        for name, parts in bodies.items()
    }
    return Built(
        gazebo,
        places,
        {model.name: dict(_coordinates(model, bodies[model.name], gazebo)) for model in scene.models},
        drives,
        turns,
        {
            link: (name, index)
            for name, parts in places.items()
            for index, (_, place) in enumerate(parts)
            for link in place.links
        },
        frozenset(own),
        warnings,
    )


def image_bytes(scene: Scene, scale: float) -> int:
    """Return the size of one image of each camera."""
    return sum(3 * each.width * each.height for each in optics_of(scene, scale).values())


def _own_files(
    scene: Scene, bodies: Mapping[str, Sequence[Body]], warnings: Findings
) -> Iterator[tuple[str, Xml]]:
    """Yield the models that Gazebo reads from their own files; the others with a file are a note."""
    reasons: dict[str, str] = {}
    for model in scene.models:
        try:
            yield model.name, own_sdf(model, bodies[model.name])
        except NotOwnError as reason:
            if model.source is not None:
                reasons.setdefault(str(reason), f"'{model.name}'")
    if reasons:
        named = "; ".join(f"{model}: {reason}" for reason, model in list(reasons.items())[:_NAMED])
        more = f"; and {len(reasons) - _NAMED} more" if len(reasons) > _NAMED else ""
        message = f"models: file has no effect on models whose plugins do not run then: {named}{more}"
        warnings.add(Code.NRP279, message, level=Level.NOTE)


def _place(model: str, body: Body, gazebo: Gazebo, own: bool) -> BodyHandle:
    """Return the handle of a body, of one link that was written, or of the links of its own file."""
    if not own:
        return BodyHandle(gazebo.link(model, link_name(body)), Pose())
    numbers = [gazebo.link(model, link.name) for link in body.links]
    if not numbers:
        return BodyHandle(NOWHERE, Pose())
    return BodyHandle(numbers[0], body.links[0].pose.inverse(), tuple(numbers[1:]))


def _coordinates(model: Model, bodies: Sequence[Body], gazebo: Gazebo) -> Iterator[tuple[str, Coordinate]]:
    """Yield the coordinates of the joints of a model, in the order of its file, with their handles."""
    moved = {body.joint.name: index for index, body in enumerate(bodies) if body.joint is not None}
    for joint in model.joints:
        if joint.name in moved:
            number = gazebo.joint(model.name, joint.name)
            for name in joint.coordinates:
                yield name, Coordinate(model.name, number, joint, moved[joint.name])


def _mesh_folders(scene: Scene) -> Iterator[Path]:
    """Yield the folders of the meshes of a scene."""
    for _, link in scene.links():
        shapes: list[Geometry] = [each.geometry for each in link.visuals]
        shapes += [each.geometry for each in link.collisions]
        yield from (shape.path.absolute().parent for shape in shapes if isinstance(shape, Mesh))
