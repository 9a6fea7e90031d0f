"""Bodies whose velocities decay, in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from nrp_core.world.engine_kit.decay import Decay
from nrp_core.world.rigid.pose import Pose
from nrp_world_mujoco.build import Built
from nrp_world_mujoco.library import mujoco


class Decays:
    """The bodies of a scene whose velocities decay.

    Args:
        built: the scene.
        data: MuJoCo's state.
        step_s: the physics step.
    """

    def __init__(self, built: Built, data: Any, step_s: float) -> None:
        self._model, self._data = built.model, data
        places = [each for bodies in built.bodies.values() for each in bodies]
        found = [(ident, Decay.of(body, step_s)) for body, ident in places]
        self._decays = [(ident, decay) for ident, decay in found if decay is not None]
        self._ids = [ident for ident, _ in self._decays]
        self._velocity = np.empty(6)
        self._last = data.xfrc_applied[self._ids]

    def __bool__(self) -> bool:
        return bool(self._decays)

    def advance(self, steps: int, step: Callable[[int], None]) -> None:
        """Take steps, each with the wrenches of the velocities at its start beside those that are given.

        Args:
            steps: the number of steps.
            step: takes a number of steps.
        """
        wrenches = self._data.xfrc_applied
        given = wrenches[self._ids]
        for _ in range(steps):
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_comPos(self._model, self._data)
            mujoco.mj_comVel(self._model, self._data)
            wrenches[self._ids] = given
            for ident, decay in self._decays:
                self._slow(ident, decay)
            step(1)
        self._last = wrenches[self._ids]
        wrenches[self._ids] = given

    @contextmanager
    def acting(self) -> Iterator[None]:
        """Apply the wrenches of the last step again, for what is measured of it."""
        given = self._data.xfrc_applied[self._ids]
        self._data.xfrc_applied[self._ids] = self._last
        try:
            yield
        finally:
            self._data.xfrc_applied[self._ids] = given

    def _slow(self, ident: int, decay: Decay) -> None:
        kind = mujoco.mjtObj.mjOBJ_BODY  # its centre of mass
        mujoco.mj_objectVelocity(self._model, self._data, kind, ident, self._velocity, 0)
        wx, wy, wz, vx, vy, vz = self._velocity.tolist()
        turn = np.empty(4)
        mujoco.mju_mat2Quat(turn, self._data.ximat[ident])
        w, x, y, z = turn.tolist()
        wrench = decay.wrench(Pose(orientation=(x, y, z, w)), (vx, vy, vz), (wx, wy, wz))
        self._data.xfrc_applied[ident] += (*wrench.force, *wrench.torque)
