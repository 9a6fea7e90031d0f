"""The state of a scene, and the MuJoCo data in which its steps are computed.

MuJoCo's data take 0.5 MB, a state about 1 kB. So each copy of a scene keeps only its state, and the copies
share data for the computation, one per thread. The results are the same: a step depends only on the state.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.muscles import COMPLETE, PresentState


class Workspace:
    """MuJoCo's data, in which a step is computed.

    Args:
        model: the compiled model.

    Attributes:
        data: MuJoCo's data.
        warned: how often MuJoCo gave each kind of warning, plus one: it prints and logs only the first one.
        loaded: a token of the state that is in the data; a state has a new token after each change.
        placed, rated: the tokens of the states to which poses and velocities in the data belong.
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
        """Count every kind of warning as already printed."""
        self.warned[:] = 1


class SharedWorkspace(threading.local, Workspace):
    """One workspace per thread, for states of models of the same sizes."""


class StateRow:
    """The state of a copy, without MuJoCo's data; its arrays have the names of those in the data.

    Args:
        model: the compiled model.

    Attributes:
        numbers: the complete state.
        before: the state before the last steps.
        gains: those of servos in the last steps; they are in the model and not in a state.
        qfrc_actuator: the efforts of actuators in the last step.
    """

    def __init__(self, model: Any) -> None:
        self.numbers = np.zeros(mujoco.mj_stateSize(model, COMPLETE))
        self.before: FloatArray = self.numbers.copy()
        self.gains: FloatArray = model.actuator_biasprm.copy()
        self.qfrc_actuator = np.zeros(model.nv)
        kinds = mujoco.mjtState
        self.qpos = self._part(model, kinds.mjSTATE_QPOS)
        self.qvel = self._part(model, kinds.mjSTATE_QVEL)
        self.ctrl = self._part(model, kinds.mjSTATE_CTRL)
        self.qfrc_applied = self._part(model, kinds.mjSTATE_QFRC_APPLIED)
        self.xfrc_applied = self._part(model, kinds.mjSTATE_XFRC_APPLIED).reshape(-1, 6)

    def _part(self, model: Any, kind: int) -> FloatArray:
        """Return a component of the state, in which the components are in the order of their bits."""
        start = mujoco.mj_stateSize(model, COMPLETE & (int(kind) - 1))
        return self.numbers[start : start + mujoco.mj_stateSize(model, kind)]

    def begin(self, model: Any, data: Any, *, has_gains: bool) -> None:
        """Write the state into data for steps, and keep it, with the gains if they can change."""
        self.before[:] = self.numbers
        if has_gains:
            self.gains[:] = model.actuator_biasprm
        self.load(model, data)

    def load(self, model: Any, data: Any) -> None:
        """Write the state into data."""
        mujoco.mj_setState(model, data, self.numbers, COMPLETE)

    def store(self, model: Any, data: Any) -> None:
        """Read the state from data."""
        mujoco.mj_getState(model, data, self.numbers, COMPLETE)
        self.qfrc_actuator[:] = data.qfrc_actuator
