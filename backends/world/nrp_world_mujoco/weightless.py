"""The links between several joints of one body, which weigh nothing in MuJoCo."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.reading.repairs import LEAST_MASS
from nrp_world_mujoco.library import mujoco


def is_between(body: Body) -> bool:
    """Return whether a body may be a link between two joints of one body."""
    return body.inertial is not None and body.inertial.mass <= LEAST_MASS


def holders(bodies: Sequence[Body]) -> Iterator[tuple[int, int]]:
    """Yield the bodies of one model that hang on links between joints, with the body that holds them.

    MuJoCo lets a body not touch its parent, but does not see through these links.
    """
    for index, body in enumerate(bodies):
        holder = body.parent
        while holder is not None and is_between(bodies[holder]):
            holder = bodies[holder].parent
        if holder is not None and holder != body.parent:
            yield index, holder


def let_weigh_nothing(model: Any, bodies: Iterable[tuple[Body, int]]) -> None:
    """Take their mass from the bodies of the least mass that carry another one.

    A scene has no body without mass, and MuJoCo compiles none; but with several joints a body of MJCF is here
    a chain of bodies, whose mass, however small, is much of an insect's and is dragged through a medium.

    Args:
        model: the compiled model, which is changed.
        bodies: the bodies of the scene with their ids.
    """
    carrying = set(model.body_parentid.tolist())
    light = [place for body, place in bodies if is_between(body) and place in carrying]
    if light:
        model.body_mass[light], model.body_inertia[light] = 0.0, 0.0
        mujoco.mj_setConst(model, mujoco.MjData(model))
        assert np.isfinite(model.dof_invweight0).all()
