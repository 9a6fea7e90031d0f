"""Models of SDF, with the models nested in them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.world.scene.acting import Drive, JointController
from nrp_core.world.scene.checks import MODEL, WORLD, check_model
from nrp_core.world.scene.controllers import read_controllers
from nrp_core.world.scene.drives import read_drive
from nrp_core.world.scene.model import Joint, Link, Model
from nrp_core.world.scene.plugins import plugin_name, warn_of_plugin
from nrp_core.world.scene.pose import Pose
from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.repairs import with_default_masses
from nrp_core.world.scene.sdf.casters import with_sliding_balls
from nrp_core.world.scene.sdf.frames import Frames, model_scope
from nrp_core.world.scene.sdf.joints import read_joints, with_leaders, without_loops
from nrp_core.world.scene.sdf.links import read_link
from nrp_core.world.scene.sdf.placed import Placed, read_placed
from nrp_core.world.scene.sensor_kinds import joint_sensors, read_sensor_plugin, renamed
from nrp_core.world.scene.xml_tree import Element
from nrp_core.world.topics import resolve_name

_JOINT_STATE_PLUGINS = ("gazebo_ros_joint_state_publisher", "JointStatePublisher")


@dataclass(frozen=True, slots=True)
class Parts:
    """What a model holds, the parts of nested models among them; poses are in the frame of the model."""

    frames: Frames
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    drives: tuple[Drive, ...]
    controllers: tuple[JointController, ...]

    def moved(self, prefix: str, pose: Pose) -> Parts:
        """Return the parts in the frame of another model, in which this one is at ``pose``."""

        def named(link: str) -> str:
            return link if link == WORLD else prefix + link

        links = [
            replace(
                link,
                name=named(link.name),
                pose=pose @ link.pose,
                sensors=tuple(renamed(link.sensors, named)),
            )
            for link in self.links
        ]
        joints = [
            replace(
                j,
                name=named(j.name),
                parent=named(j.parent),
                child=named(j.child),
                pose=pose @ j.pose,
                mimic=j.mimic and replace(j.mimic, leader=named(j.mimic.leader)),
            )
            for j in self.joints
        ]
        drives = tuple(drive.renamed(named) for drive in self.drives)
        controllers = tuple(controller.renamed(named) for controller in self.controllers)
        return Parts(self.frames, tuple(links), tuple(joints), drives, controllers)


def read_parts(placed: Placed, reading: Reading, *, static: bool) -> Parts:
    """Read what a model holds.

    Args:
        placed: the model.
        reading: what is carried along.
        static: whether it, or a model around it, never moves.
    """
    model, source = placed.element, placed.source
    inner_models = read_placed(model, source, reading, "model")
    nested = [
        (inner, read_parts(inner, reading.within(model_scope(inner.name, inner.merged)[0]), static=static))
        for inner in inner_models
    ]
    frames = _frames(model, nested)
    own_links = (read_link(link, frames, reading, static=static) for link in model.all("link"))
    links = list(with_sliding_balls(own_links, model))
    joints = list(read_joints(model, frames, source.version, reading))
    for joint in model.all("joint"):
        joint_sensors(joint, links, reading)
    drives: list[Drive] = []
    controllers: list[JointController] = []
    for inner, parts in nested:
        prefix, frame = model_scope(inner.name, inner.merged)
        moved = parts.moved(prefix, frames.pose(frame, inner.user))
        links += moved.links
        joints += moved.joints
        drives += moved.drives
        controllers += moved.controllers
    own = _Acting(links, joints)
    for plugin in placed.plugins:
        own.read(plugin, reading)
    drives += own.drives
    controllers += own.controllers
    return Parts(frames, tuple(links), tuple(joints), tuple(drives), tuple(controllers))


def _frames(model: Element, nested: Iterable[tuple[Placed, Parts]]) -> Frames:
    frames = Frames(model, MODEL, _canonical_link(model, nested))
    for link in model.all("link"):
        frames.add(link, MODEL)
    for joint in model.all("joint"):
        child = joint.require("child").text
        frames.add(joint, child, attached_to=child)
    for frame in model.all("frame"):
        attached_to = frame.attributes.get("attached_to") or MODEL
        frames.add(frame, attached_to, attached_to=attached_to)
    for inner, parts in nested:
        placed = inner.pose(MODEL, parts.frames)
        frames.add_model(inner.name, placed, parts.frames, inner.user, merged=inner.merged)
    return frames


def _canonical_link(model: Element, nested: Iterable[tuple[Placed, Parts]]) -> str:
    links = [link.attribute("name") for link in model.all("link")]
    links += [model_scope(inner.name, inner.merged)[0] + parts.frames.base for inner, parts in nested]
    if not links:
        raise model.error(f"the model '{model.attribute('name')}' has no <link>")
    return model.attributes.get("canonical_link") or links[0]


class _Acting:
    """What the plugins of a model make of its links and joints."""

    def __init__(self, links: list[Link], joints: list[Joint]) -> None:
        self._links, self._joints = links, joints
        self._names = [joint.name for joint in joints]
        self._fixed = {joint.name for joint in joints if joint.kind == "fixed"}
        self.drives: list[Drive] = []
        self.controllers: list[JointController] = []

    def read(self, plugin: Element, reading: Reading) -> None:
        """Read one plugin; what is not known is warned of."""
        if plugin_name(plugin) in _JOINT_STATE_PLUGINS:
            return
        drive = read_drive(plugin, self._links, self._joints, reading)
        controllers = read_controllers(plugin, self._names, reading)
        if drive is not None:
            self.drives.append(drive)
        elif controllers is not None:
            self.controllers += [each for each in controllers if each.joint not in self._fixed]
            for name in {each.joint for each in controllers} & self._fixed:
                reading.notes.warn(plugin, f"the joint '{name}' is fixed: it takes no commands")
        elif not read_sensor_plugin(plugin, self._links, self._joints, reading):
            warn_of_plugin(plugin, reading)


def build_model(placed: Placed, parts: Parts, name: str, pose: Pose, reading: Reading) -> Model:
    """Return a model at a pose in the world; its canonical link comes first.

    Raises:
        SceneError: its joints form a loop, or its canonical link is not there.
    """
    element, base = placed.element, parts.frames.base
    names = [link.name for link in parts.links]
    if base not in names:
        raise element.error(f"the model '{name}' has no canonical link '{base}'{did_you_mean(base, names)}")
    links = tuple(sorted(parts.links, key=lambda link: link.name != base))
    if placed.static:
        return Model(name, links, pose=pose, static=True)
    topic = _joint_states_topic(placed, parts.joints, name)
    joints = tuple(with_leaders(without_loops(parts.joints, element, reading), element, reading))
    model = Model(
        name, links, joints, parts.drives, pose, joint_states_topic=topic, controllers=parts.controllers
    )
    try:
        check_model(model)
    except SceneError as error:
        raise element.error(error.message) from None
    return replace(model, links=with_default_masses(links, joints, element, reading.notes))


def _joint_states_topic(placed: Placed, joints: Iterable[Joint], name: str) -> str | None:
    if all(joint.kind == "fixed" for joint in joints):
        return None
    publishers = [plugin for plugin in placed.plugins if plugin_name(plugin) in _JOINT_STATE_PLUGINS]
    topics = [plugin.word("topic") for plugin in publishers]
    return resolve_name(next(filter(None, topics), "joint_states"), name)
