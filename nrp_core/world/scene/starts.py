"""Where joints start: at 0, or at the limit nearest to it where their limits exclude 0.

If a joint of a loop starts elsewhere, the others of the loop start where they close it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import Joint, Model
from nrp_core.world.scene.posture import Posture, closing


def start_positions(model: Model) -> Mapping[str, float]:
    """Return the start positions (rad, m) of the joints of a model that do not start at 0.

    A joint that follows another one starts where it follows it.
    """
    given = dict(model.starts)
    movable = {joint.name: joint for joint in model.joints if joint.takes_commands}

    def start(name: str, followers: frozenset[str] = frozenset()) -> float:
        joint = movable.get(name)
        if joint is None or name in given:
            return given.get(name, 0.0)
        if joint.mimic is None or name in followers:  # joints that follow each other in a circle are at 0
            return _within(joint, 0.0)
        leader = start(joint.mimic.leader, followers | {name})
        return _within(joint, joint.mimic.multiplier * leader + joint.mimic.offset)

    starts = {name: position for name in movable if (position := start(name))}
    return closing(model, starts, list(given)) if starts and model.loops else starts


def body_poses(model: Model, bodies: Sequence[Body]) -> list[Pose]:
    """Return the poses of a model's bodies in the world, with its joints where they start."""
    posture = Posture(model, start_positions(model))
    moved = [posture.of(body.links[0].name if body.links else WORLD) for body in bodies]
    return [model.pose @ motion @ body.in_model for motion, body in zip(moved, bodies, strict=True)]


def outside(model: Model) -> list[Joint]:
    """Return the joints whose limits exclude 0 and that are not told where to start."""
    told = dict(model.starts)
    free = [joint for joint in model.joints if joint.takes_commands and joint.mimic is None]
    return [joint for joint in free if joint.name not in told and _within(joint, 0.0)]


def _within(joint: Joint, position: float) -> float:
    return min(max(position, joint.lower), joint.upper)
