"""Joints of SDF, and the gearboxes and plugins that make one joint follow another."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from math import inf, isfinite, pi
from typing import Final

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.bodies import PRESERVED
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.loops import LOOP_KINDS, Freedom, Loop, Tie
from nrp_core.scene.model import Joint, Mimic
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import name_of_file
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.sdf.compound import COMPOUND, Row, direction, second, with_axis
from nrp_core.scene.sdf.frames import Frames

_SIMPLE = ("revolute", "continuous", "prismatic")
_TURN_RAD = 2 * pi - 0.01
"""A turn as files round it."""
_LARGE = 1e6
"""Limits of this size mean that there is none."""
_LEAST_SHARE = 0.5
"""The share of its leader's positions that limits of a joint allow that are not those of another sign."""
_KINDS = (*_SIMPLE, *COMPOUND, "fixed", "gearbox")


def read_joints(model: Element, frames: Frames, version: tuple[int, int], reading: Reading) -> Iterator[Row]:
    """Read the joints of a model that hold links; gearboxes do not, they couple other joints."""
    for joint in model.all("joint"):
        if joint.attribute("type") != "gearbox":
            yield read_joint(joint, frames, version, reading)


def tree_and_loops(
    rows: Iterable[Row], model: Element, reading: Reading
) -> tuple[tuple[Row, ...], tuple[Loop, ...]]:
    """Return joints without those whose links are already connected by others, and these as loops.

    Joints are taken in the order of the file, except that those that move and whose child is held already
    come last: others may connect their links, too. If a sliding joint would close a loop, the joint
    that holds its child does, if that one turns.

    Raises:
        SceneError: two joints hold one link.
    """
    connected: dict[str, set[str]] = {}
    holders: dict[str, str] = {}
    kept: list[Row] = []
    loops: list[Loop] = []
    left, late = list(rows), list[Row]()
    for row in chain(left, late):  # the second list grows while the first one is read
        joint = row[0]
        one, other = (connected.setdefault(end, {end}) for end in (joint.parent, joint.child))
        if one is other:
            freed = _freed_by(row, kept)
            if freed is not None:
                kept.remove(freed)
                kept.append(row)
                holders[joint.child] = joint.name
            closing = freed or row
            loops += _closing(closing, _element(model, closing[0]), reading)
        elif joint.child not in holders:
            one |= other
            connected.update(dict.fromkeys(other, one))
            holders[joint.child] = joint.name
            kept.append(row)
        elif joint.kind != "fixed" and row not in late:  # a fixed one would lock the joints before it
            late.append(row)
        else:  # refused here, so that a lenient reading leaves out this joint alone
            both = f"'{holders[joint.child]}' and '{joint.name}'"
            message = f"two joints, {both}, hold the link '{joint.child}'; joints form a tree"
            raise _element(model, joint).error(message)
    return tuple(kept), tuple(loops)


def _freed_by(row: Row, kept: Sequence[Row]) -> Row | None:
    """Return a joint that can close a loop instead of one that cannot, or None."""
    holding = {other[0].child: other for other in kept}
    above = row[0].parent
    while above in holding and above != row[0].child:
        above = holding[above][0].parent
    holder = holding.get(row[0].child)
    if row[0].kind in LOOP_KINDS or len(row) > 1 or above == row[0].child or holder is None:
        return None
    turns = len(holder) == 1 and holder[0].kind in LOOP_KINDS and holder[0].kind != "fixed"
    return holder if turns else None


def _closing(row: Row, element: Element, reading: Reading) -> Iterator[Loop]:
    """Yield the loop that a joint closes, with a warning of lost features."""
    joint = row[0]
    closes = f"the joint '{joint.name}' closes a loop of joints"
    if len(row) > 1 or joint.kind not in LOOP_KINDS:
        message = f"{closes}, which is not simulated for a '{element.attribute('type')}': left out"
        reading.notes.warn(element, Code.NRP260, message, subject=joint.name)
        return
    if joint.kind != "fixed":
        message = f"{closes}: it is a constraint without a position, limits, friction or commands"
        reading.notes.warn(element, Code.NRP383, message, subject=joint.name)
    yield Loop(joint.name, joint.kind, joint.parent, joint.child, joint.pose, joint.axis)


def read_joint(joint: Element, frames: Frames, version: tuple[int, int], reading: Reading) -> Row:
    """Read a ``<joint>``, which may be several simple ones.

    Args:
        joint: the element.
        frames: the frames of its model.
        version: the version of the file.
        reading: the context of the reading.

    Raises:
        SceneError: its type is unknown, or its links or frames do not exist.
    """
    name, kind = joint.attribute("name"), joint.attribute("type")
    if kind not in _KINDS:
        raise joint.error(f"unknown joint type '{kind}'{did_you_mean(kind, _KINDS)}")
    for tag in ("axis", "axis2"):
        _warn_of_push(joint.section(tag).section("dynamics"), name, reading)
        _warn_of_signs(joint.section(tag).section("limit"), name, reading)
    held = Joint(name, kind, *_ends(joint, frames), frames.pose(frames.name_of(joint), joint),
                 preserved=PRESERVED in joint.attributes)  # fmt: skip
    if kind in COMPOUND:
        return COMPOUND[kind](held, joint, frames, version, reading)
    if kind == "fixed":
        joint.pass_over("axis")
    if kind == "continuous":
        _warn_of_limits(joint, reading)
    return (with_axis(held, joint, "axis", frames, version) if kind in _SIMPLE else held,)


def _warn_of_limits(joint: Element, reading: Reading) -> None:
    """Warn of limits of less than a turn on a joint without limits; many files have 0 to 0 or a full turn."""
    limit = joint.section("axis").section("limit")
    lower, upper = (limit.number(tag, inf, finite=False) for tag in ("lower", "upper"))
    if 0 < upper - lower < _TURN_RAD:
        message = (
            f"the joint '{joint.attribute('name')}' is continuous: it turns past its <limit> of {lower:g} to "
            f"{upper:g} rad; one with limits is revolute"
        )
        reading.notes.warn(limit, Code.NRP383, message, subject=joint.attribute("name"))


def with_leaders(joints: Iterable[Joint], model: Element, reading: Reading) -> Iterator[Joint]:
    """Yield joints; those that mimic a joint without exactly one degree of freedom become free.

    One whose limits exclude most positions in which it would follow has none: it would hold its leader.

    Raises:
        SceneError: one mimics a joint that does not exist.
    """
    joints = tuple(joints)
    named = {joint.name: joint for joint in joints}
    for joint in joints:
        if (follows := joint.mimic) is not None:
            leader, element = follows.leader, _element(model, joint)
            if leader not in named:
                hint = did_you_mean(leader, named)
                raise element.error(f"the joint '{joint.name}' mimics '{leader}', which does not exist{hint}")
            if (what := WITHOUT_ONE_WAY.get(named[leader].kind)) is not None:
                message = f"the joint '{joint.name}' mimics '{leader}', which is {what}: it moves freely"
                reading.notes.warn(element, Code.NRP383, message, subject=joint.name)
                joint = replace(joint, mimic=None)
            elif (left := _share_left(joint, follows, named[leader])) < _LEAST_SHARE:
                mostly = " for the most part" if left > 0 else ""
                message = (
                    f"the joint '{joint.name}' mimics {follows.multiplier:g} x '{leader}', which its "
                    f"limits of {joint.lower:g} to {joint.upper:g} exclude{mostly}: they are not used"
                )
                reading.notes.warn(
                    element, Code.NRP383, message, subject=joint.name, alike="mimic beyond limits"
                )
                joint = replace(joint, lower=-inf, upper=inf)
        yield joint


def _share_left(joint: Joint, follows: Mimic, leader: Joint) -> float:
    """Return the share of the positions of its leader that the limits of a joint allow."""
    if not follows.multiplier:
        return 1.0
    low, high = sorted(follows.multiplier * limit + follows.offset for limit in (leader.lower, leader.upper))
    left = min(high, joint.upper) - max(low, joint.lower)
    if low == high:  # the leader cannot move
        return float(joint.lower <= low <= joint.upper)
    if left <= 0:
        return 0.0
    return left / (high - low) if isfinite(high - low) else 1.0


def starts_in(model: Element, joints: Sequence[Joint], reading: Reading) -> Iterator[tuple[str, float]]:
    """Yield the joints of a model that its file starts elsewhere than at 0, and where."""
    led = {joint.name: joint for joint in joints if joint.takes_commands and joint.mimic is None}
    for element in model.all("joint"):
        joint = led.get(element.attribute("name"))
        start = element.section("axis").number("initial_position", 0.0)
        if joint is None or not start:
            continue
        nearest = min(max(start, joint.lower), joint.upper)
        if nearest != start:
            message = (
                f"the joint '{joint.name}' cannot start at {start:g}, beyond its limits: it starts at "
                f"{nearest:g}"
            )
            reading.notes.warn(element, Code.NRP264, message, subject=joint.name)
        yield joint.name, nearest


WITHOUT_ONE_WAY = {"fixed": "fixed", "ball": "a ball joint"}
"""Names of the kinds of joints that cannot follow or lead."""


def _element(model: Element, joint: Joint) -> Element:
    """Return the element of a joint in a model, or the model if it is in a nested one."""
    owners = {
        name: each
        for each in model.all("joint")
        for name in (each.attribute("name"), second(each.attribute("name")))
    }
    return owners.get(joint.name, model)


def _ends(joint: Element, frames: Frames) -> tuple[str, str]:
    """Return parent and child."""
    name = joint.attribute("name")
    parent, child = (_link(joint.require(tag), frames) for tag in ("parent", "child"))
    if child == WORLD != frames.base:
        raise joint.error(f"the world cannot be the child of the joint '{name}'; it can be the parent")
    if parent == child:
        raise joint.error(f"the joint '{name}' connects the link '{child}' with itself")
    return parent, child


def _link(element: Element, frames: Frames) -> str:
    if not element.text:
        raise element.error(f"<{element.tag}> must name a link")
    return WORLD if element.text == WORLD else frames.body(element.text, element)


def _warn_of_signs(limit: Element, joint: str, reading: Reading) -> None:
    """Warn of negative limits, which are none, unless they are written like the default."""
    for tag in ("effort", "velocity"):
        value = limit.number(tag, inf, finite=False)
        if -_LARGE < value < 0 and value != -1:
            message = f"the <{tag}> of the joint '{joint}' is {value:g}: a negative one is no limit, as -1 is"
            reading.notes.warn(limit, Code.NRP384, message, subject=joint)


def _warn_of_push(dynamics: Element, joint: str, reading: Reading) -> None:
    """Warn of values that would push a joint instead of slowing or holding it."""
    for tag in ("friction", "spring_stiffness"):
        value = dynamics.number(tag, 0.0)
        if value < 0:
            message = (
                f"the <{tag}> of the joint '{joint}' is {value:g}, which would push it: the value used is 0"
            )
            reading.notes.warn(dynamics, Code.NRP264, message, subject=joint)


def add_joint_frames(world: Element, frames: Frames) -> None:
    """Add the frames of the joints of a world, which are attached to the child."""
    for joint in world.all("joint"):
        child = joint.require("child").text
        frames.add(joint, child, attached_to=child)


def read_world_joints(
    world: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> Iterator[tuple[str, Row]]:
    """Yield each joint of a world in the frame of the world, with the name of the model of its child.

    Raises:
        SceneError: a joint is wrong, or one of its ends does not exist.
    """
    for joint in world.all("joint"):
        if joint.attribute("type") == "gearbox":
            _warn_of_gearbox(joint, "it is outside of the models whose joints it couples", reading)
            continue
        row = read_joint(joint, frames, version, reading)
        if row[-1].child == WORLD:  # from SDF 1.10
            row = _reversed(row)
        owner, other = (end.partition("::")[0] for end in (row[-1].child, row[0].parent))
        if other not in (owner, WORLD) and any(each.mimic for each in row):
            name, kind = joint.attribute("name"), joint.attribute("type")
            message = f"the joint '{name}' between two models is {kind}, which is not simulated: left out"
            reading.notes.warn(joint, Code.NRP260, message, subject=name)
            joint.passed_over = True
        else:
            yield owner, row


def _reversed(row: Row) -> Row:
    """Return a joint whose child holds the parent, with the same positions of its axes."""
    return tuple(
        replace(joint, parent=joint.child, child=joint.parent, axis=_negative(joint.axis))
        for joint in reversed(row)
    )


def _negative(vector: Vector) -> Vector:
    x, y, z = vector
    return -x, -y, -z


def tie_of(row: Row, poses: Mapping[str, Pose], kinds: Mapping[str, str]) -> Tie | None:
    """Return a joint of the world as one between two models; None if it is in one.

    Args:
        row: the joint, in the frame of the world.
        poses: the poses of all models in the world.
        kinds: the types of the joints in the file.
    """
    (parent, _, holder), (child, _, held) = (end.partition("::") for end in (row[0].parent, row[-1].child))
    if parent in (child, WORLD):
        return None
    joint = row[0]
    freedoms: tuple[Freedom, ...] = ()
    if len(row) > 1 or joint.kind not in LOOP_KINDS:
        freedoms = tuple(_freedom(each, joint.pose) for each in row)
    name = next(each.name for each in row if each.name in kinds)
    kind = joint.kind if len(row) == 1 else kinds[name]
    in_parent, in_child = (poses[name].inverse() @ joint.pose for name in (parent, child))
    ends = (parent, holder), (child, held)
    return Tie(name, kind, *ends, in_parent, in_child, joint.axis, freedoms)


def _freedom(joint: Joint, tie: Pose) -> Freedom:
    axis = tie.rotate_back(joint.pose.rotate(joint.axis))
    limits = joint.lower, joint.upper
    return Freedom(joint.kind, axis, *limits, joint.damping, joint.friction, joint.stiffness, joint.rest)


def in_model(row: Row, model: str, pose: Pose) -> Row:
    """Return a joint of the world as one of a model.

    Args:
        row: the joint, in the frame of the world.
        model: the name of the model.
        pose: the pose of the model in the world.
    """
    prefix = f"{model}::"
    return tuple(
        replace(
            joint,
            parent=joint.parent.removeprefix(prefix),
            child=joint.child.removeprefix(prefix),
            pose=pose.inverse() @ joint.pose,
        )
        for joint in row
    )


_NAME: Final = re.compile(r"(?:roboticsgroup_(?:upatras_)?)?gazebo_mimic_joint_plugin")


def couples(plugin: Element) -> bool:
    """Return whether a plugin couples two joints."""
    return _NAME.fullmatch(name_of_file(plugin)) is not None


def with_coupled(rows: Iterable[Row], plugins: Iterable[Element], reading: Reading) -> list[Row]:
    """Return the joints of a model; those that plugins couple follow others, unless they do so already.

    Args:
        rows: the joints, including those of nested models.
        plugins: the plugins of the model.
        reading: the context of the reading.

    Raises:
        SceneError: a plugin couples a joint with itself.
    """
    rows = list(rows)
    for plugin in filter(couples, plugins):
        ends = [plugin.require(tag) for tag in ("joint", "mimicJoint")]
        names = [joint.name for row in rows for joint in row]
        if ends[0].text == ends[1].text:
            raise plugin.error(f"the joint '{ends[0].text}' mimics itself")
        absent = [end for end in ends if end.text not in names]
        for end in absent[:1]:
            hint = did_you_mean(end.text, names)
            message = f"the model has no joint '{end.text}'{hint}: the plugin couples nothing"
            reading.notes.warn(end, Code.NRP265, message, subject=end.text)
        if not absent:
            leader, follower = (end.text for end in ends)
            follows = Mimic(leader, plugin.number("multiplier", 1.0), plugin.number("offset", 0.0))
            rows = [_following(row, follower, follows) for row in rows]
    return rows


def _following(row: Row, follower: str, follows: Mimic) -> Row:
    return tuple(
        replace(joint, mimic=follows) if joint.name == follower and joint.mimic is None else joint
        for joint in row
    )


_ROUNDING = 1e-6


def with_gears(
    rows: Iterable[Row], model: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> list[Row]:
    """Return the joints of a model, with those coupled by gearboxes following others.

    Args:
        rows: the joints, including those of nested models.
        model: the element that holds the gearboxes.
        frames: the frames of the model.
        version: the version of the file.
        reading: the context of the reading.

    Raises:
        SceneError: a gearbox names a part that does not exist.
    """
    rows = list(rows)
    for gearbox in model.all("joint"):
        if gearbox.attribute("type") != "gearbox":
            continue
        for axis in gearbox.all("axis", "axis2"):
            axis.pass_over("limit", "dynamics")  # the joints that it couples have their own
        body = gearbox.find("gearbox_reference_body")
        if body is None:
            _warn_of_gearbox(gearbox, "it has no <gearbox_reference_body>", reading)
            continue
        reference, held = _link(body, frames), {row[0].child: row for row in rows}
        (driving, one), (driven, other) = (
            _turning(
                held,
                reference,
                _link(gearbox.require(end), frames),
                direction(gearbox, axis, frames, version),
            )
            for end, axis in (("parent", "axis"), ("child", "axis2"))
        )
        if driving is None or driven is None or driving == driven or driven.mimic is not None:
            each = "its parent and child do not each turn by one joint of their own"
            _warn_of_gearbox(gearbox, f"{each} against the reference body", reading)
            continue
        follows = Mimic(driving.name, -gearbox.number("gearbox_ratio", 1.0) * one * other)
        rows = [tuple(replace(j, mimic=follows) if j == driven else j for j in row) for row in rows]
    return rows


def _warn_of_gearbox(gearbox: Element, why: str, reading: Reading) -> None:
    name, gearbox.passed_over = gearbox.attribute("name"), True
    reading.notes.warn(gearbox, Code.NRP260, f"the gearbox '{name}' is left out: {why}", subject=name)


def _turning(
    held: Mapping[str, Row], reference: str, link: str, axis: tuple[float, float, float]
) -> tuple[Joint | None, float]:
    """Return the single joint by which a link turns against a body about an axis, and its sense (1, -1).

    The joint is None if it does not exist.
    """
    above, below = list(_holding(held, reference)), list(_holding(held, link))
    parting = [(1.0, row) for row in below if row not in above]
    parting += [(-1.0, row) for row in above if row not in below]
    moving = [(sense, joint) for sense, row in parting for joint in row if joint.kind != "fixed"]
    if len(moving) != 1:
        return None, 0.0
    sense, joint = moving[0]
    turned = Pose(orientation=joint.pose.orientation).rotate(joint.axis)
    along = sum(one * other for one, other in zip(turned, axis, strict=True))
    turns = joint.kind in ("revolute", "continuous") and abs(along) > 1 - _ROUNDING
    return (joint, sense if along > 0 else -sense) if turns else (None, 0.0)


def _holding(held: Mapping[str, Row], link: str) -> Iterator[Row]:
    """Yield the joints that hold a link, from there upwards; those in a loop once."""
    seen = set()
    while link in held and link not in seen:
        seen.add(link)
        yield held[link]
        link = held[link][0].parent
