"""Where the state of a scene is, and MuJoCo's data in which it is computed.

MuJoCo's data take 0.5 MB, and a state about 1 kB. So the copies of a scene keep states, and compute in data
that they share, one on each thread. The results are the same: a step depends on nothing else.
"""

from __future__ import annotations

import threading
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.muscles import PresentState

COMPLETE: Final = mujoco.mjtState.mjSTATE_INTEGRATION
"""All that the next step depends on."""


class Workspace:
    """MuJoCo's data, in which a state is computed.

    Args:
        model: the compiled model.

    Attributes:
        data: MuJoCo's data.
        warned: how often MuJoCo gave each kind of warning, plus one: it prints and logs only the first one.
        loaded: the moment whose state is in the data; a new object at each change of a state.
        placed, rated: the moments to which the poses and the velocities of bodies in the data belong.
        present: reads actuators and sensors.
    """

    def __init__(self, model: Any) -> None:
        self.data = mujoco.MjData(model)
        self.warned = self.data.warning.number
        self.mute()
        self.present = PresentState(model)
        self.loaded: object = None
        self.placed: object = None
        self.rated: object = None

    def mute(self) -> None:
        """Mark every kind of warning as given."""
        self.warned[:] = 1


class SharedWorkspace(threading.local, Workspace):
    """A workspace of its own on each thread, for states of models of the same sizes."""


class StateRow:
    """The state of a copy, without MuJoCo's data; its arrays have the names that they have there.

    Args:
        model: the compiled model.

    Attributes:
        numbers: the complete state.
        before: the state before the last steps.
        qfrc_actuator: the efforts of actuators in the last step.
    """

    def __init__(self, model: Any) -> None:
        self.numbers = np.zeros(mujoco.mj_stateSize(model, COMPLETE))
        self.before: FloatArray = self.numbers.copy()
        self.qfrc_actuator = np.zeros(model.nv)
        kinds = mujoco.mjtState
        self.qpos = self._part(model, kinds.mjSTATE_QPOS)
        self.qvel = self._part(model, kinds.mjSTATE_QVEL)
        self.ctrl = self._part(model, kinds.mjSTATE_CTRL)
        self.qfrc_applied = self._part(model, kinds.mjSTATE_QFRC_APPLIED)
        self.xfrc_applied = self._part(model, kinds.mjSTATE_XFRC_APPLIED).reshape(-1, 6)

    def _part(self, model: Any, kind: int) -> FloatArray:
        """Return a component of the state, which has the components in the order of their bits."""
        start = mujoco.mj_stateSize(model, COMPLETE & (int(kind) - 1))
        return self.numbers[start : start + mujoco.mj_stateSize(model, kind)]

    def load(self, model: Any, data: Any) -> None:
        """Write the state into data."""
        mujoco.mj_setState(model, data, self.numbers, COMPLETE)

    def store(self, model: Any, data: Any) -> None:
        """Read the state from data."""
        mujoco.mj_getState(model, data, self.numbers, COMPLETE)
        self.qfrc_actuator[:] = data.qfrc_actuator
