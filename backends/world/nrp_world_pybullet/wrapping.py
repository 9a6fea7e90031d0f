"""Muscles that wrap around shapes: MuJoCo computes their lengths and moments on a copy of their file.

Only the routines for positions are used (``mj_kinematics``, ``mj_comPos``, ``mj_tendon`` and
``mj_transmission``); PyBullet moves the bodies.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.errors import CapabilityError
from nrp_core.scene.model import Model
from nrp_world_pybullet.build import BodyHandle
from nrp_world_pybullet.library import bullet


class WrappingMuscles:
    """The lengths, velocities and moments of the muscles of a model that wrap.

    Args:
        model: the model, of an MJCF file.
        muscles: the names of the muscles.
        joints: the coordinates that they can move, by name, with their handles.
        floats: whether the base of the model floats freely.
        client: the physics client.

    Raises:
        CapabilityError: a muscle connects a free base to the world, or its file has other parts.
    """

    def __init__(
        self,
        model: Model,
        muscles: Sequence[str],
        joints: Mapping[str, BodyHandle],
        floats: bool,
        client: int,
    ) -> None:
        import mujoco

        self._engine, self._client = mujoco, client
        file = model.source.file if model.source is not None else Path()
        try:
            m = self._m = _compile(file, model.native)
        except ValueError as error:
            why = f"MuJoCo cannot read its file: {' '.join(str(error).split())}"
            raise CapabilityError(_refusal(model, muscles[0], why)) from None
        self._data = mujoco.MjData(m)
        known = {m.actuator(n).name or f"actuator_{n}": n for n in range(m.nu)}
        singles = dict(_singles(m))
        for name in muscles:
            for why in _obstacles(m, known.get(name), floats):
                raise CapabilityError(_refusal(model, name, why))
        if missing := [name for name in joints if name not in singles]:
            raise CapabilityError(
                _refusal(model, muscles[0], f"its file has no hinge or slide '{missing[0]}'")
            )
        numbers = [singles[name] for name in joints]
        self._coordinates, self._rates = m.jnt_qposadr[numbers], m.jnt_dofadr[numbers]
        self._zeros = m.qpos0[self._coordinates].copy()
        self._outputs = m.actuator_outadr[[known[name] for name in muscles]]
        self._gears = m.actuator_gear[self._outputs, 0].copy()
        self._dense = np.zeros((m.nu, m.nv))
        self._trees: dict[int, list[int]] = {}
        for place in joints.values():
            self._trees.setdefault(place.multibody, []).append(place.link)
        order = [(place.multibody, place.link) for place in joints.values()]
        read = [(body, link) for body, links in self._trees.items() for link in links]
        self._order = np.array([read.index(each) for each in order], int)

    def find(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return lengths and velocities, shape ``(n,)``, and moments by the coordinates, shape ``(n, c)``."""
        engine, m, data = self._engine, self._m, self._data
        rows = [
            state[:2]
            for body, links in self._trees.items()
            for state in bullet.getJointStates(body, links, self._client)
        ]
        positions, velocities = np.array(rows, float).reshape(-1, 2)[self._order].T
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


def _compile(file: Path, reading: object) -> Any:
    """Return the compiled model of a file, once per reading of its scene: MuJoCo does not list includes."""
    import mujoco

    if id(reading) not in _compiled:
        compiled = mujoco.MjModel.from_xml_path(str(file))
        for oldest in list(_compiled)[: 1 - _MOST]:
            del _compiled[oldest]
        _compiled[id(reading)] = reading, compiled  # keeps the reading alive, so that its id is not reused
    return _compiled[id(reading)][1]


def _singles(m: Any) -> Iterator[tuple[str, int]]:
    """Yield the joints of one degree of freedom by their names in the scene."""
    import mujoco

    bodies = {"ground", *(m.body(n).name or f"body_{n}" for n in range(1, m.nbody))}
    for n in range(m.njnt):
        if m.jnt_type[n] in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)):
            name = m.joint(n).name or f"joint_{n}"
            yield f"{name}_joint" if name in bodies else name, n


def _obstacles(m: Any, number: int | None, floats: bool) -> Iterator[str]:
    """Yield why a muscle cannot be simulated here."""
    import mujoco

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


def _refusal(model: Model, muscle: str, why: str) -> str:
    return f"PyBullet cannot simulate the muscle '{muscle}' of '{model.name}': {why}"
