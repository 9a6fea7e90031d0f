"""Models of SDF, with nested models."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.scene.bodies import free_name
from nrp_core.scene.consistency import MODEL, WORLD
from nrp_core.scene.devices import MountedDrive, MountedSensor
from nrp_core.scene.model import Joint, Keyframe, Link, Model
from nrp_core.scene.origin import Native, Source
from nrp_core.scene.reading.context import Element, Notes, Reading
from nrp_core.scene.reading.geometry import with_contact_collisions
from nrp_core.scene.reading.plugins import (
    LABEL,
    Actuators,
    ModelParts,
    check_parameters,
    label_in,
    plugin_name,
    read_actuators,
    warn_of_plugin,
    with_label,
)
from nrp_core.scene.reading.repairs import report_without_inertial, with_default_masses
from nrp_core.scene.reading.sensors import (
    Misplaced,
    Mount,
    joint_sensors,
    with_frames,
    with_plugin_sensor,
    with_sensors,
)
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf.compound import Row, in_a_row
from nrp_core.scene.sdf.frames import Frames, Placed, model_scope, read_placed, read_pose, with_unique_links
from nrp_core.scene.sdf.joints import (
    WITHOUT_ONE_WAY,
    couples,
    read_joints,
    starts_in,
    tree_and_loops,
    with_coupled,
    with_gears,
    with_leaders,
)
from nrp_core.scene.sdf.links import read_link
from nrp_core.scene.stand_in import with_sizes

KEYFRAME = "nrp:keyframe"
"""The element of a start that a file names."""
_OF_SDF = ("gz", "ignition", "experimental", "nrp", "xacro")
"""Namespaces that do not belong to an engine."""


def native_of(element: Element) -> tuple[Native, ...]:
    """Return the children of an element with the namespace of an engine."""
    spaced = [child for child in element.children if ":" in child.tag]
    return tuple(_native(child) for child in spaced if child.tag.partition(":")[0] not in _OF_SDF)


def _native(element: Element) -> Native:
    namespace, _, tag = element.tag.rpartition(":")
    children = tuple(map(_native, element.children))
    attributes = tuple(element.attributes.items())
    return Native(namespace, tag, attributes, element.text, children, element.path, element.line)


def with_own_topics(links: Iterable[Link], model: Element, notes: Notes) -> tuple[Link, ...]:
    """Return links of a model in which no two sensors have a topic in common; each new name is a warning.

    Two topics of one sensor may be the same: a sonar has its ranges instead of its scans.
    """
    owners: dict[str, str] = {}
    taken = {topic for link in links for sensor in link.sensors for topic in sensor.topics}

    def own(sensor: MountedSensor, link: str) -> MountedSensor:
        topics = sensor.topics_by_field
        others: dict[str, str] = {}
        for topic in dict.fromkeys(topics.values()):
            if topic in owners:
                others[topic] = free_name(topic, taken)
                taken.add(others[topic])
                message = (
                    f"the sensors {owners[topic]} and '{sensor.name}' of '{link}' have the topic '{topic}': "
                    f"that of the second is '{others[topic]}'"
                )
                notes.warn(model, Code.NRP266, message, subject=sensor.name)
            else:
                owners[topic] = f"'{sensor.name}' of '{link}'"
        renamed: dict[str, Any] = {name: others[topic] for name, topic in topics.items() if topic in others}
        return replace(sensor, **renamed) if renamed else sensor

    return tuple(
        replace(link, sensors=tuple(own(each, link.name) for each in link.sensors)) for link in links
    )


_NAMES_SHARED = (1, 6)
"""The last version in which a link and a joint of a model may have one name."""
_JOINT_STATE_PLUGINS = ("gazebo_ros_joint_state_publisher", "JointStatePublisher")


@dataclass(frozen=True, slots=True)
class SdfParts:
    """The parts of a model, including those of nested models; poses are in the frame of the model.

    ``static`` is true if none of them ever moves.
    """

    frames: Frames
    links: tuple[Link, ...]
    rows: tuple[Row, ...]
    actuators: Actuators
    static: bool = False

    def moved(self, prefix: str, pose: Pose) -> SdfParts:
        """Return the parts in the frame of another model, in which this one has the pose ``pose``."""

        def named(link: str) -> str:
            return link if link == WORLD else prefix + link

        links = [
            replace(
                link,
                name=named(link.name),
                pose=pose @ link.pose,
                sensors=tuple(sensor.renamed(named) for sensor in link.sensors),
            )
            for link in self.links
        ]
        rows = [
            tuple(
                replace(
                    j,
                    name=named(j.name),
                    parent=named(j.parent),
                    child=named(j.child),
                    pose=pose @ j.pose,
                    mimic=j.mimic and replace(j.mimic, leader=named(j.mimic.leader)),
                )
                for j in row
            )
            for row in self.rows
        ]
        return SdfParts(self.frames, tuple(links), tuple(rows), self.actuators.renamed(named), self.static)


def read_parts(placed: Placed, reading: Reading, *, static: bool) -> SdfParts:
    """Read the parts of a model.

    Args:
        placed: the model.
        reading: the context of the reading.
        static: whether it, or an enclosing model, never moves.
    """
    model = with_unique_links(placed.element, reading) if static else placed.element
    source = placed.source
    inner_models = read_placed(model, source, reading, "model")
    only_inner = bool(inner_models) and not model.all("link")
    still = [inner.static for inner in inner_models]
    static = static or (only_inner and all(still))
    nested = [
        (inner, read_parts(inner, reading.within(model_scope(inner.name, inner.merged)[0]), static=static))
        for inner in inner_models
    ]
    static = static or (only_inner and all(parts.static for _, parts in nested))
    for inner in inner_models if not static else ():
        if inner.static:
            message = (
                f"the <static> of the nested model '{inner.name}' is not simulated: it moves as what holds it"
            )
            reading.notes.warn(inner.user, Code.NRP383, message, subject=inner.name)
    frames = _frames(model, nested, source.version)
    own = model.all("link")
    alone = len(own) == 1 and not nested
    links = [read_link(link, frames, reading, static=static, alone=alone) for link in own]
    report_without_inertial(own, links, reading.notes)
    rows = list(read_joints(model, frames, source.version, reading))
    for joint in model.all("joint"):
        name = joint.attribute("name")
        mount = Mount(name, partial(_place_on_child, frames, joint))
        sensors = joint_sensors(joint.all("sensor"), mount, reading)
        links = with_sensors(links, joint.require("child").text, *sensors)
    acting = Actuators()
    for inner, parts in nested:
        prefix, frame = model_scope(inner.name, inner.merged)
        moved = parts.moved(prefix, frames.pose(frame, inner.user))
        links += moved.links
        rows += moved.rows
        acting = acting.with_others(moved.actuators)
    rows = with_gears(rows, model, frames, source.version, reading)
    rows = with_coupled(rows, placed.plugins, reading)
    joints = list(chain.from_iterable(rows))
    for plugin in placed.plugins:
        added, links = _plugin_or_warning(plugin, links, joints, reading)
        acting = acting.with_others(added)
    links, misplaced = with_frames(links, joints)
    for each in misplaced:
        _warn_of_frame(each, model, reading)
    return SdfParts(frames, tuple(_odometry_once(links, acting.drives)), tuple(rows), acting, static)


def _place_on_child(frames: Frames, joint: Element, sensor: Element) -> Pose:
    """Return the pose of a sensor of a joint in the frame of the joint's child."""
    frame = frames.name_of(joint)
    child = frames.pose(frames.body(frame, joint), joint)
    return child.inverse() @ frames.pose(frame, joint) @ frames.place_in(sensor, frame)


def _warn_of_frame(misplaced: Misplaced, model: Element, reading: Reading) -> None:
    holders = (link for link in model.all("link") if link.attribute("name") == misplaced.link)
    sensors = (sensor for link in holders for sensor in link.all("sensor"))
    where = next((each for each in sensors if each.attribute("name") == misplaced.sensor), model)
    reading.notes.warn(where, Code.NRP266, misplaced.message, subject=misplaced.sensor)


def _frames(model: Element, nested: Iterable[tuple[Placed, SdfParts]], version: tuple[int, int]) -> Frames:
    shared = version <= _NAMES_SHARED
    own_name = model.attributes.get("name", "") if shared else ""
    frames = Frames(model, MODEL, _canonical_link(model, nested), own_name)
    for link in model.all("link"):
        frames.add(link, MODEL)
    for joint in model.all("joint"):
        child = joint.require("child").text
        frames.add(joint, child, attached_to=child, shared=shared)
    for frame in model.all("frame"):
        attached_to = frame.attributes.get("attached_to") or MODEL
        frames.add(frame, attached_to, attached_to=attached_to, shared=shared)
    for inner, parts in nested:
        placed = inner.pose(MODEL, parts.frames)
        frames.add_model(inner.name, placed, parts.frames, inner.user, merged=inner.merged)
    for frame in model.all("frame"):
        frames.require(frame)
    return frames


def _canonical_link(model: Element, nested: Iterable[tuple[Placed, SdfParts]]) -> str:
    links = [link.attribute("name") for link in model.all("link")]
    links += [model_scope(inner.name, inner.merged)[0] + parts.frames.base for inner, parts in nested]
    if not links:
        raise model.error(f"the model '{model.attribute('name')}' has no <link>")
    return model.attributes.get("canonical_link") or links[0]


def _odometry_once(links: Iterable[Link], drives: Iterable[MountedDrive]) -> Iterator[Link]:
    """Yield links without odometry sensors on the topics of drives, as files of gz-sim have them."""
    topics = {drive.odometry_topic for drive in drives}
    for link in links:
        kept = (each for each in link.sensors if not (each.is_odometry and each.topic in topics))
        yield replace(link, sensors=tuple(kept))


def _plugin_or_warning(
    plugin: Element, links: list[Link], joints: list[Joint], reading: Reading
) -> tuple[Actuators, list[Link]]:
    """Return the same as :func:`_read_plugin`; omit a faulty plugin of an expanded file.

    Its line is unknown, so a lenient reading cannot leave it out alone.
    """
    try:
        return _read_plugin(plugin, links, joints, reading)
    except SceneError as error:
        if plugin.end_line:
            raise
        name = plugin_name(plugin)
        message = f"the plugin '{name}' is left out: {error.message}"
        reading.notes.warn(plugin, Code.NRP260, message, subject=name)
        return Actuators(), links


def _read_plugin(
    plugin: Element, links: list[Link], joints: list[Joint], reading: Reading
) -> tuple[Actuators, list[Link]]:
    """Return the actuators of a plugin, and the links with its sensor; unknown plugins cause a warning."""
    if plugin_name(plugin) in _JOINT_STATE_PLUGINS or couples(plugin):
        plugin.find("topic")  # of joint states, read with the whole model
        check_parameters(plugin, reading.notes)
        return Actuators(), links
    if plugin_name(plugin) == LABEL:
        labels = with_label(links, label_in(plugin))
        check_parameters(plugin, reading.notes)
        return Actuators(), labels
    model = ModelParts(links, joints)
    actuators = read_actuators(plugin, model, reading)
    if actuators is None:
        sensing = with_plugin_sensor(plugin, model, reading)
        if sensing is None:
            warn_of_plugin(plugin, reading)
            return Actuators(), links
        check_parameters(plugin, reading.notes)
        return Actuators(), sensing
    check_parameters(plugin, reading.notes)
    deaf = {j.name: WITHOUT_ONE_WAY[j.kind] for j in joints if not j.takes_commands}
    for name in sorted({each.joint for each in actuators.controllers} & set(deaf)):
        message = f"the joint '{name}' is {deaf[name]}: it cannot be commanded"
        reading.notes.warn(plugin, Code.NRP265, message, subject=name, alike=f"{deaf[name]}, commanded")
    commanded = tuple(each for each in actuators.controllers if each.joint not in deaf)
    return actuators._replace(controllers=commanded), links


def build_model(placed: Placed, parts: SdfParts, name: str, pose: Pose, reading: Reading) -> Model:
    """Return a model at a pose in the world; its canonical link comes first.

    Raises:
        SceneError: its joints form a loop, or its canonical link does not exist.
    """
    element, base = placed.element, parts.frames.base
    names = [link.name for link in parts.links]
    if base not in names:
        raise element.error(f"the model '{name}' has no canonical link '{base}'{did_you_mean(base, names)}")
    links = tuple(sorted(parts.links, key=lambda link: link.name != base))
    links = with_own_topics(links, element, reading.notes)
    without = sorted(line for path, line in reading.without if path == element.path)
    source = Source(element.path, element.attributes.get("name", ""), element.line, tuple(without))
    native = native_of(element)
    if parts.static:
        element.pass_over("joint", "enable_wind", "self_collide")
        links = tuple(_without_joint_sensors(links, element, reading))
        return Model(name, links, pose=pose, static=True, native=native, source=source)
    tree, loops = tree_and_loops(parts.rows, element, reading)
    rows = [in_a_row(row) for row in tree]
    links = (*links, *chain.from_iterable(carriers for _, carriers in rows))
    joints = tuple(with_leaders(chain.from_iterable(row for row, _ in rows), element, reading))
    links = with_contact_collisions(links, joints)
    topic = _joint_states_topic(placed, joints, name)
    model = Model(
        name,
        links,
        joints,
        pose=pose,
        joint_states_topic=topic,
        **parts.actuators._asdict(),
        native=native,
        loops=loops,
        starts=tuple(starts_in(element, joints, reading)),
        keyframes=tuple(map(_keyframe, element.all(KEYFRAME))),
        source=source,
    )
    try:
        model.check()
    except SceneError as error:
        raise element.error(error.message) from None
    massive = with_default_masses(links, joints, element, reading.notes)
    return replace(model, links=with_sizes(massive, joints))


def _keyframe(element: Element) -> Keyframe:
    """Read ``<nrp:keyframe name="home"><pose/><start joint="" target="">0.1</start></nrp:keyframe>``."""
    elements = element.all("start")
    starts = [(each.attribute("joint"), each.numbers(1)[0]) for each in elements]
    aimed = [each for each in elements if "target" in each.attributes]
    targets = [(each.attribute("joint"), float(each.attribute("target"))) for each in aimed]
    pose, _ = read_pose(element, "") if element.find("pose") else (None, "")
    return Keyframe(element.attribute("name"), pose, tuple(starts), tuple(targets))


def _without_joint_sensors(links: Iterable[Link], model: Element, reading: Reading) -> Iterator[Link]:
    """Yield the links of a static model, which has no joints, without the sensors that measure in joints."""
    for link in links:
        for sensor in link.sensors:
            if sensor.measured_joints:
                message = f"the sensor '{sensor.name}' measures in a joint, and the model is static: left out"
                reading.notes.warn(model, Code.NRP262, message, subject=sensor.name)
        yield replace(link, sensors=tuple(each for each in link.sensors if not each.measured_joints))


def _joint_states_topic(placed: Placed, joints: Iterable[Joint], name: str) -> str | None:
    if all(joint.kind == "fixed" for joint in joints):
        return None
    publishers = [plugin for plugin in placed.plugins if plugin_name(plugin) in _JOINT_STATE_PLUGINS]
    topics = [plugin.word("topic") for plugin in publishers]
    return resolve_name(next(filter(None, topics), "joint_states"), name)
