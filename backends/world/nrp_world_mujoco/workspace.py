"""The state of a scene, and the MuJoCo data in which its steps are computed.

MuJoCo's data take 0.5 MB, a state about 1 kB. So each copy of a scene keeps only its state, and the copies
share data for the computation, one per thread. The results are the same: a step depends only on the state.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from mujoco.batch import Batch, SimulationError

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_world_mujoco.library import mujoco
from nrp_world_mujoco.muscles import COMPLETE, PresentState


class Workspace:
    """MuJoCo's data, in which a step is computed.

    Args:
        model: the compiled model.

    Attributes:
        data: MuJoCo's data.
        warned: how often MuJoCo gave each kind of warning, plus one: it prints and logs only the first one.
        muted: the bytes of these counts as long as it has given none.
        loaded: a token of the state that is in the data; a state has a new token after each change.
        placed, rated: the tokens of the states to which poses and velocities in the data belong.
        present: reads actuators and sensors.
    """

    def __init__(self, model: Any) -> None:
        self.data = mujoco.MjData(model)
        self.warned = self.data.warning.number
        self.mute()
        self.muted = self.warned.tobytes()
        self.present = PresentState(model)
        self.loaded: object = None
        self.placed: object = None
        self.rated: object = None

    def mute(self) -> None:
        """Count every kind of warning as already printed."""
        self.warned[:] = 1


class SharedWorkspace(threading.local, Workspace):
    """One workspace per thread, for states of models of the same sizes."""

    _steps: tuple[tuple[StateRow, ...], StepsOfMany] | None = None

    def steps_of(self, model: Any, rows: Sequence[StateRow]) -> StepsOfMany:
        """Return the object that takes steps from several states at once; it is kept for the same states."""
        chosen = tuple(rows)
        if self._steps is None or self._steps[0] != chosen:
            self._steps = chosen, StepsOfMany(model, chosen)
        return self._steps[1]


class StateRow:
    """The state of a copy, without MuJoCo's data; its arrays have the names of those in the data.

    Their numbers change in place: :class:`StepsOfMany` knows where they are.

    Args:
        model: the compiled model.
        has_gains: whether the gains of its servos can change.

    Attributes:
        numbers: the complete state.
        before: the state before the last steps.
        own_gains: the gains of servos, if they can change; they are in the model and not in a state.
        gains: the gains in the last steps.
        qfrc_actuator: the efforts of actuators in the last step.
    """

    def __init__(self, model: Any, *, has_gains: bool) -> None:
        self.numbers: Final = np.zeros(mujoco.mj_stateSize(model, COMPLETE))
        self.before: Final[FloatArray] = self.numbers.copy()
        self.own_gains: Final[FloatArray] = model.actuator_biasprm if has_gains else np.empty(0)
        self.gains: Final = self.own_gains.copy()
        self.qfrc_actuator: Final = np.zeros(model.nv)
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

    def begin(self, model: Any, data: Any) -> None:
        """Write the state into data for steps, and keep it, with the gains."""
        self.before[:], self.gains[:] = self.numbers, self.own_gains
        mujoco.mj_setState(model, data, self.numbers, COMPLETE)

    def load(self, model: Any, data: Any) -> None:
        """Write the state into data."""
        mujoco.mj_setState(model, data, self.numbers, COMPLETE)

    def store(self, model: Any, data: Any) -> None:
        """Read the state from data."""
        mujoco.mj_getState(model, data, self.numbers, COMPLETE)
        self.qfrc_actuator[:] = data.qfrc_actuator


class StepsOfMany:
    """Takes the steps of several copies in one call; each has the same results as alone.

    Args:
        model: the compiled model of the copies, which differ at most in the gains of servos.
        rows: the states.
    """

    def __init__(self, model: Any, rows: Sequence[StateRow]) -> None:
        from nrp_core._support.rows import Rows  # imported here since it loads a compiler

        self._batch = Batch(model, nsim=len(rows), nthread=1)
        self._states, self._before = Rows([row.numbers for row in rows]), Rows([row.before for row in rows])
        self._efforts = Rows([row.qfrc_actuator for row in rows]), self._batch.bind("qfrc_actuator")
        self._gains: tuple[Rows, Rows, FloatArray] | None = None
        if rows[0].own_gains.size:
            gains = self._batch.expand("actuator_biasprm").reshape(len(rows), -1)
            self._gains = Rows([row.own_gains for row in rows]), Rows([row.gains for row in rows]), gains

    def take(self, steps: int) -> IntArray:
        """Take steps.

        Returns:
            The numbers of the copies for which MuJoCo gave a warning; they keep the states before the steps.
        """
        batch = self._batch
        failed = np.zeros(len(batch.state), bool)
        self._before.write(self._states.read(batch.state), failed)
        batch.warning[:] = 0
        if self._gains is not None:
            own, last, gains = self._gains
            last.write(own.read(gains), failed)
        try:
            batch.step(nstep=steps)
        except SimulationError as error:
            failed[error.ids] = True
        failed |= batch.warning.any(axis=(1, 2))
        self._states.write(batch.state, failed)
        rows, efforts = self._efforts
        rows.write(efforts, failed)
        return np.flatnonzero(failed)
