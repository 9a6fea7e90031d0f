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
from nrp_core.world.drives.muscles import muscles_of


def wrapping_refusals(mujoco: Any, engine: str, model: Model) -> Iterator[str]:
    """Yield why an engine cannot simulate the muscles of a model that wrap.

    Its file has other parts than the model, or a muscle connects a free base to the world.

    Args:
        mujoco: the module.
        engine: the name of the engine that moves the bodies, for messages.
        model: the model, of an MJCF file.
    """
    muscles = [muscle.name for muscle in muscles_of(model) if muscle.wraps]
    if not muscles:
        return
    about = f"{engine} cannot simulate the muscle '{{}}' of '{model.name}': "
    try:
        m = _compile(mujoco, model)
    except ValueError as error:
        yield f"{about.format(muscles[0])}MuJoCo cannot read its file: {' '.join(str(error).split())}"
        return
    known, singles = _actuators(m), dict(_singles(mujoco, m))
    held = {joint.child for joint in model.joints}
    floats = not model.static and any(link.name not in held for link in model.links)
    for name in muscles:
        for why in _obstacles(mujoco, m, known.get(name), floats):
            yield about.format(name) + why
    joints = [name for joint in model.joints for name in joint.coordinates]
    if missing := [name for name in joints if name not in singles]:
        yield f"{about.format(muscles[0])}its file has no hinge or slide '{missing[0]}'"


class WrappingMuscles:
    """The lengths, velocities and moments of the muscles of a model that wrap.

    Attributes:
        names: their names.

    Args:
        mujoco: the module.
        engine: the name of the engine that moves the bodies, for messages.
        model: the model, of an MJCF file.
        joints: the names of its coordinates, in the order in which they are given.

    Raises:
        CapabilityError: one of :func:`wrapping_refusals`.
    """

    def __init__(self, mujoco: Any, engine: str, model: Model, joints: Sequence[str]) -> None:
        for why in wrapping_refusals(mujoco, engine, model):
            raise CapabilityError(why)
        self._mujoco = mujoco
        m = self._m = _compile(mujoco, model)
        self._data = mujoco.MjData(m)
        known, singles = _actuators(m), dict(_singles(mujoco, m))
        self.names = [muscle.name for muscle in muscles_of(model) if muscle.wraps]
        numbers = [singles[name] for name in joints]
        self._coordinates, self._rates = m.jnt_qposadr[numbers], m.jnt_dofadr[numbers]
        self._zeros = m.qpos0[self._coordinates].copy()
        self._outputs = m.actuator_outadr[[known[name] for name in self.names]]
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


def _compile(mujoco: Any, model: Model) -> Any:
    """Return the compiled model of a file, once per reading of its scene: MuJoCo does not list includes."""
    reading: object = model.native
    if id(reading) not in _compiled:
        file = model.source.file if model.source is not None else Path()
        compiled = mujoco.MjModel.from_xml_path(str(file))
        for oldest in list(_compiled)[: 1 - _MOST]:
            del _compiled[oldest]
        _compiled[id(reading)] = reading, compiled  # keeps the reading alive, so that its id is not reused
    return _compiled[id(reading)][1]


def _actuators(m: Any) -> dict[str, int]:
    return {m.actuator(n).name or f"actuator_{n}": n for n in range(m.nu)}


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
