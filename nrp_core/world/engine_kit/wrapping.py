"""Muscles that wrap around shapes: MuJoCo computes their lengths and moments on a copy of their file.

Only the routines for positions are used (``mj_kinematics``, ``mj_comPos``, ``mj_tendon`` and
``mj_transmission``); another engine moves the bodies. The engine passes on the module ``mujoco``, so that
the core does not need it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.errors import CapabilityError
from nrp_core.scene.model import Model


class WrappingMuscles:
    """The lengths, velocities and moments of the muscles of a model that wrap.

    Args:
        mujoco: the module.
        engine: the name of the engine that moves the bodies, for messages.
        model: the model, of an MJCF file.
        muscles: the names of the muscles.
        joints: the names of the coordinates that they can move.
        floats: whether the base of the model floats freely.

    Raises:
        CapabilityError: a muscle connects a free base to the world, or its file has other parts.
    """

    def __init__(
        self,
        mujoco: Any,
        engine: str,
        model: Model,
        muscles: Sequence[str],
        joints: Sequence[str],
        floats: bool,
    ) -> None:
        self._mujoco = mujoco
        file = model.source.file if model.source is not None else Path()
        try:
            m = self._m = _compile(mujoco, file, model.native)
        except ValueError as error:
            why = f"MuJoCo cannot read its file: {' '.join(str(error).split())}"
            raise CapabilityError(_refusal(engine, model, muscles[0], why)) from None
        self._data = mujoco.MjData(m)
        known = {m.actuator(n).name or f"actuator_{n}": n for n in range(m.nu)}
        singles = dict(_singles(mujoco, m))
        for name in muscles:
            for why in _obstacles(mujoco, m, known.get(name), floats):
                raise CapabilityError(_refusal(engine, model, name, why))
        if missing := [name for name in joints if name not in singles]:
            raise CapabilityError(
                _refusal(engine, model, muscles[0], f"its file has no hinge or slide '{missing[0]}'")
            )
        numbers = [singles[name] for name in joints]
        self._coordinates, self._rates = m.jnt_qposadr[numbers], m.jnt_dofadr[numbers]
        self._zeros = m.qpos0[self._coordinates].copy()
        self._outputs = m.actuator_outadr[[known[name] for name in muscles]]
        self._gears = m.actuator_gear[self._outputs, 0].copy()
        self._dense = np.zeros((m.nu, m.nv))

    def find(
        self, positions: FloatArray, velocities: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return lengths and velocities, shape ``(n,)``, and moments by the coordinates, shape ``(n, c)``.

        Args:
            positions: of the joints, shape ``(c,)``.
            velocities: of the joints, shape ``(c,)``.
        """
        engine, m, data = self._mujoco, self._m, self._data
        data.qpos[self._coordinates] = self._zeros + positions
        for routine in (engine.mj_kinematics, engine.mj_comPos, engine.mj_tendon, engine.mj_transmission):
            routine(m, data)
        engine.mju_sparse2dense(
            self._dense, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
        )
        moments = self._dense[np.ix_(self._outputs, self._rates)] / self._gears[:, None]
        return data.actuator_length[self._outputs] / self._gears, product(moments, velocities), moments


_compiled: dict[int, tuple[object, Any]] = {}
_MOST = 8


def _compile(mujoco: Any, file: Path, reading: object) -> Any:
    """Return the compiled model of a file, once per reading of its scene: MuJoCo does not list includes."""
    if id(reading) not in _compiled:
        compiled = mujoco.MjModel.from_xml_path(str(file))
        for oldest in list(_compiled)[: 1 - _MOST]:
            del _compiled[oldest]
        _compiled[id(reading)] = reading, compiled  # keeps the reading alive, so that its id is not reused
    return _compiled[id(reading)][1]


def _singles(mujoco: Any, m: Any) -> Iterator[tuple[str, int]]:
    """Yield the joints of one degree of freedom by their names in the scene."""
    bodies = {"ground", *(m.body(n).name or f"body_{n}" for n in range(1, m.nbody))}
    for n in range(m.njnt):
        if m.jnt_type[n] in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)):
            name = m.joint(n).name or f"joint_{n}"
            yield f"{name}_joint" if name in bodies else name, n


def _obstacles(mujoco: Any, m: Any, number: int | None, floats: bool) -> Iterator[str]:
    """Yield why a muscle cannot be simulated here."""
    if number is None:
        yield "its file has no such actuator"
        return
    if m.actuator_trntype[number] == mujoco.mjtTrn.mjTRN_TENDON:
        tendon = int(m.actuator_trnid[number][0])
        start = int(m.tendon_adr[tendon])
        path = range(start, start + int(m.tendon_num[tendon]))
        sites = [int(m.wrap_objid[k]) for k in path if m.wrap_type[k] == mujoco.mjtWrap.mjWRAP_SITE]
        if floats and any(m.body_weldid[m.site_bodyid[site]] == 0 for site in sites):
            yield "it connects a free base to the world"


def _refusal(engine: str, model: Model, muscle: str, why: str) -> str:
    return f"{engine} cannot simulate the muscle '{muscle}' of '{model.name}': {why}"
