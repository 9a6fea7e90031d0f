"""Loops of joints, and ties of models: points that two links have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Model, Scene
from nrp_world_mujoco.library import mujoco

HARD = [0.999, 0.999, 0.001, 0.5, 2.0]  # impedance of stiff constraints: couplings, joints that rub or stop

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
        ends = [
            (tie.parent, [point for point, _ in tie.points]),
            (tie.child, [point for _, point in tie.points]),
        ]
        bodies = [
            (links[name][link][0], [_in_body(scene.model(name), links[name], link, each) for each in points])
            for (name, link), points in ends
        ]
        (held, places), (holder, _) = sorted(bodies, key=lambda body: body[0] is spec.worldbody)
        if held is spec.worldbody:
            continue
        for place in places:
            _connect(held, holder.name, place, spec)
        if holder is not spec.worldbody:
            spec.add_exclude(bodyname1=held.name, bodyname2=holder.name)


def _in_body(model: Model, links: Links, link: str, point: Vector) -> Vector:
    """Return a point of a model in the frame of the body with a link."""
    _, place = links[link]
    return (place @ model.link(link).pose.inverse() @ Pose(point)).position


def _connect(element: Any, holder: str, point: Vector, spec: Any) -> None:
    """Keep a point of a body at another one, where it is with all joints at 0."""
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=element.name,
        name2=holder,
        data=[*point, *[0.0] * (mujoco.mjNEQDATA - 3)],
        solref=[2 * spec.option.timestep, 1.0],  # the shortest time constant, s, and damping ratio
        solimp=HARD,
    )
