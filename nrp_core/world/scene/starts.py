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
    starts: dict[str, float] = {}
    followers: list[Joint] = []
    for joint in model.joints:
        if not joint.takes_commands:
            continue
        if joint.mimic is not None and joint.name not in given:
            followers.append(joint)
        starts[joint.name] = given.get(joint.name, _within(joint, 0.0))
    for joint in followers:
        assert joint.mimic is not None
        leader = starts.get(joint.mimic.leader, 0.0)
        starts[joint.name] = _within(joint, joint.mimic.multiplier * leader + joint.mimic.offset)
    starts = {name: start for name, start in starts.items() if start}
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
