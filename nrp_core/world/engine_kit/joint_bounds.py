"""The possible positions of a scene's joints: an engine that exceeds them has diverged.

Limits are springs in most engines, and a strong muscle stretches them. So a joint may lie outside its limits
by their whole range and 1 rad (or m) more, which no spring of a body that works allows.
"""

from __future__ import annotations

from math import inf

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import DivergedError
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import JointStates
from nrp_core.world.engine import MOST_RATE

_BEYOND = 1.0


class JointBounds:
    """The positions that the joints of a model can have.

    Args:
        model: the model.
        names: the coordinates of its joints, in the order of their states.

    Attributes:
        spans: the same as ``low`` and ``high``, as pairs.
        low, high: the smallest and the largest position of each coordinate, rad or m, shape ``(n,)``;
            infinite for one that turns without end, has no two limits, or follows another joint.
    """

    def __init__(self, model: Model, names: tuple[str, ...]) -> None:
        self._model, self._names = model.name, names
        limits = {
            joint.name: (joint.lower - beyond, joint.upper + beyond)
            for joint in model.joints
            if joint.mimic is None and joint.kind != "continuous" and joint.upper > joint.lower
            for beyond in [joint.upper - joint.lower + _BEYOND]
            if beyond < inf
        }
        self.spans = [limits.get(name, (-inf, inf)) for name in names]
        self.low, self.high = np.array(self.spans).reshape(-1, 2).T

    def contain(self, positions: FloatArray, velocities: FloatArray) -> bool:
        """Return whether a state is possible."""
        inside = (positions >= self.low) & (positions <= self.high)
        return velocities.dot(velocities) < MOST_RATE**2 and bool(inside.all())

    def require(self, states: JointStates, t_ns: int) -> None:
        """Refuse a state that is not possible.

        Raises:
            DivergedError: it is not; the message names the first joint.
        """
        right = (states.positions >= self.low) & (states.positions <= self.high)
        right &= np.isfinite(states.positions) & (np.abs(states.velocities) < MOST_RATE)
        if right.all():
            return
        k = int(np.flatnonzero(~right)[0])
        raise DivergedError(
            f"the world has diverged: joint '{self._names[k]}' of '{self._model}' is at "
            f"{states.positions[k]:.4g} rad (or m), at {states.velocities[k]:.4g} rad/s (or m/s): "
            "that is not possible; a shorter timestep or smaller commands may help",
            t_ns=t_ns,
        )
