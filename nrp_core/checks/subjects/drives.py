"""Drives that cannot move their robot: wheels in the air, a tilted start, and joints with two controllers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from math import acos, degrees, inf
from typing import Final, Protocol, runtime_checkable

from nrp_core.checks.examined import ExaminedExperiment, checks_experiment
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Collision, Model
from nrp_core.scene.posture import at_start
from nrp_core.scene.rigid import matrix_of
from nrp_core.scene.tessellation import box_around

UPRIGHT: Final = 0.7
"""Cosine of 45 degrees."""
CASTER_SLACK: Final = 0.25
"""How much lower than its wheels a robot may reach, in radii of a wheel; casters yield a little."""
BOX_SLACK: Final = 0.05
"""The same for a box with friction, which is not a caster."""
OTHER_UNIT: Final = 2.0
"""How far below the wheels, in radii of a wheel, a part reaches that is in another unit."""


@runtime_checkable
class Wheeled(Protocol):
    """A drive with wheels on two sides."""

    name: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    wheel_diameter: float


@checks_experiment
def check_drives(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Check the drives and controllers of robots."""
    for model in examined.robots if examined.bodies_fall else ():
        for code, message in wrong_drives(model):
            yield examined.warning(code, message, "world", "robots", model.name)


def wrong_drives(model: Model) -> Iterator[tuple[Code, str]]:
    """Yield the code and the message of each mistake in the drives and controllers of a robot."""
    model = at_start(model)
    upward = float(matrix_of(model.pose)[2, 2])
    wheeled = [drive for drive in model.drives if isinstance(drive, Wheeled)]
    if wheeled and upward < UPRIGHT:
        tilt_deg = degrees(acos(max(-1.0, upward)))
        yield (
            Code.NRP370,
            f"'{model.name}' starts tilted by {tilt_deg:.0f} degrees: it does not stand on its wheels",
        )
    for drive in wheeled:
        owner = f"the drive '{drive.name}' of '{model.name}'"
        yield from ((Code.NRP375, sentence) for sentence in _bare_wheels(owner, drive, model))
        if upward >= UPRIGHT:
            with suppress(SceneError):  # a mesh cannot be read, which the reader reports
                yield from [(Code.NRP375, sentence) for sentence in _lifted_wheels(owner, drive, model)]
    yield from ((Code.NRP376, sentence) for sentence in _controlled_twice(model))


def _wheels(drive: Wheeled, model: Model) -> set[str]:
    """Return the links that the joints of a drive turn."""
    names = {*drive.left, *drive.right}
    return {joint.child for joint in model.joints if joint.name in names}


def _bare_wheels(owner: str, drive: Wheeled, model: Model) -> Iterator[str]:
    """Yield that wheels have no collision shape although the robot rests on something."""
    solid = {
        link.name
        for body in bodies_of(model)
        if any(link.collisions for link in body.links)
        for link in body.links
    }
    wheels = _wheels(drive, model)
    bare = sorted(wheels - solid)
    frictions = [shape.friction for link in model.links for shape in link.collisions]
    # wheels without shapes are deliberate where a robot slides on a shape without friction
    if bare and (len(bare) < len(wheels) or (frictions and all(frictions))):
        yield f"{owner} has a wheel that touches nothing: '{bare[0]}' has no collision shape"


def _lifted_wheels(owner: str, drive: Wheeled, model: Model) -> Iterator[str]:
    """Yield that a robot rests on another part than its wheels.

    Raises:
        SceneError: a mesh cannot be read.
    """
    wheels, radius_m = _wheels(drive, model), drive.wheel_diameter / 2
    lowest: dict[str, float] = {}
    others: list[tuple[float, float, str]] = []
    for link in model.links:
        for shape in link.collisions:
            box = box_around([(link.pose @ shape.pose, shape.geometry)])
            low = inf if box is None else float(box[0][2])
            if link.name in wheels:
                lowest[link.name] = min(lowest.get(link.name, inf), low)
            else:
                others.append((low + _slack(shape) * radius_m, low, link.name))
    if not others or not wheels <= lowest.keys():
        return
    ground, (limit, low, name) = min(lowest.values()), min(others)
    if limit < ground and ground - low < OTHER_UNIT * radius_m:
        yield f"{owner} has wheels that do not reach the ground: '{name}' reaches {ground - low:.2g} m lower"


def _slack(shape: Collision) -> float:
    """Return how much lower than the wheels a shape may reach, in radii of a wheel."""
    return CASTER_SLACK if shape.friction == 0 or not isinstance(shape.geometry, Box) else BOX_SLACK


def _controlled_twice(model: Model) -> Iterator[str]:
    """Yield the joints that a drive and a controller, or two controllers of one kind, command."""
    topics: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for single in model.controllers:
        topics[single.joint].append((single.kind, single.topic))
    for leader in model.trajectory_controllers:
        for joint in leader.joints:
            topics[joint].append(("trajectory", leader.command_topic))
    for drive in model.drives:
        both = [joint for joint in drive.joints if joint in topics]
        if both:
            kind, topic = topics[both[0]][0]
            more = f" (and {len(both) - 1} more of its joints)" if len(both) > 1 else ""
            yield (
                f"the drive '{drive.name}' of '{model.name}' moves the joint '{both[0]}'{more}, and so does "
                f"a {kind} controller on '{topic}': they work against each other, also without a command"
            )
    for joint, several in topics.items():
        for kind in dict.fromkeys(kind for kind, _ in several):
            distinct = dict.fromkeys(topic for one, topic in several if one == kind)
            if len(distinct) > 1:
                yield (
                    f"the joint '{joint}' of '{model.name}' has {len(distinct)} {kind} controllers, on "
                    f"{' and '.join(distinct)}: is one of them for another joint?"
                )
