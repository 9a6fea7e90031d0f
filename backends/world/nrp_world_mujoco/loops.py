"""Loops of joints, and ties of models: points that two links have in common.

A tie that slides, or has several axes, needs joints: light bodies on the parent move by them, and the last
one has the points in common with the child.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.loops import Tie
from nrp_core.world.scene.model import Model, Scene
from nrp_world_mujoco.joints import FIRMEST, HARD, add_joint, shortest
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.shapes import placed

LIGHT: Final = 1e-3
"""Mass and inertia of a body between two models, as a share of the lighter one's."""
Links = Mapping[str, tuple[Any, Pose]]
"""The links of a model: the body of each, and its pose in the frame of that."""


def close_loops(model: Model, links: Links, spec: Any) -> None:
    """Keep the links of loops together at their points, as they are where all joints are at 0."""
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
        carrier = carrier.add_body(name=path, **placed(Pose() if number else frame))
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
    """Keep a point of a body at another one, where it is with all joints at 0."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=element.name,
        name2=holder,
        data=[*point, *[0.0] * (mujoco.mjNEQDATA - 3)],
        solref=shortest(spec),
        solimp=impedance,
    )
