"""Finds held objects that slide although friction should hold them."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.library import mujoco

INTERVAL_S = 0.25
"""The time between two samples, s."""
_SAMPLES = 4
"""Samples in a row in which an object slides before it is reported."""
_SLOW = 2e-4
"""Speeds below are not reported, m/s: less than 1 mm in 5 s."""
_RESERVE = 0.9
"""Contacts that use a larger share of their friction may slide in reality."""


class Creep:
    """Watches the contacts of loose objects with bodies that move.

    MuJoCo's friction is a soft constraint: a contact whose force is well within the friction cone yields at a
    constant speed, and an object that is held for long slides out of the grasp.

    Args:
        built: the compiled scene.

    Attributes:
        watches: whether there can be such objects.
    """

    def __init__(self, built: Built) -> None:
        model = built.model
        self._owners = built.owners
        loose = {name for name, bodies in built.bodies.items() if len(bodies) == 1 and bodies[0][0].floats}
        moves = model.body_weldid[model.geom_bodyid] > 0
        names = [name for name, _ in built.owners]
        self._loose = np.array([name in loose for name in names], bool) & moves
        self._moves = np.array([bool(name) for name in names], bool) & moves
        elliptic = model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
        self.watches = bool(elliptic and self._loose.any())
        self._every = max(round(INTERVAL_S / model.opt.timestep), 1)
        self.forget()

    def forget(self) -> None:
        """Begin anew, because bodies were moved."""
        self._steps = 0
        self._seen: dict[tuple[str, str], list[float]] = {}

    def after(self, steps: int, data: Any) -> list[tuple[str, str, float]]:
        """Return the objects that slide, what holds them, and their speeds (m/s).

        Args:
            steps: the physics steps since the last call.
            data: MuJoCo's data after them.
        """
        self._steps += steps
        if not self.watches or self._steps < self._every:
            return []
        self._steps = 0
        now = self._sliding(data) if data.ncon else {}
        self._seen = {pair: [*self._seen.get(pair, ()), speed] for pair, speed in now.items()}
        return [
            (*pair, sum(speeds) / len(speeds))
            for pair, speeds in self._seen.items()
            if len(speeds) == _SAMPLES
        ]

    def _sliding(self, data: Any) -> dict[tuple[str, str], float]:
        """Return the speeds of contacts that friction should hold, by object and holder, m/s."""
        contacts, found = data.contact, dict[tuple[str, str], float]()
        pairs, rows = contacts.geom, contacts.efc_address
        one, other = pairs.T
        between = (self._loose[one] & self._moves[other]) | (self._moves[one] & self._loose[other])
        for n in np.flatnonzero(between & (rows >= 0) & (contacts.dim >= 3)).tolist():
            row = int(rows[n])
            normal, *across = data.efc_force[row : row + 3].tolist()
            speed = float(np.hypot(*data.efc_vel[row + 1 : row + 3]))
            share = _share(normal, np.array(across), contacts.friction[n])
            a, b = (self._owners[geom][0] for geom in pairs[n].tolist())
            if a != b and speed > _SLOW and share < _RESERVE:
                pair = (a, b) if self._loose[pairs[n, 0]] else (b, a)
                found[pair] = max(found.get(pair, 0.0), speed)
        return found


def _share(normal: float, across: FloatArray, friction: FloatArray) -> float:
    """Return the share of a contact's friction that is in use."""
    available = normal * friction[:2]
    return float(np.hypot(*(across / available))) if (available > 0).all() else 1.0
