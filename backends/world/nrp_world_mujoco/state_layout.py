"""Where MuJoCo's state keeps the constraints of a step, for compiled code.

They are allocated anew in each step. Python's access to them takes a microsecond each. The layout of the
state differs by version, so it is found in the state of a small model.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_world_mujoco.library import mujoco

_PROBE = """
<mujoco>
  <worldbody>
    <body name="held">
      <joint name="one" frictionloss="1"/><joint name="other" axis="1 0 0" frictionloss="1"/><geom size="1"/>
    </body>
  </worldbody>
  <equality><joint joint1="one" joint2="other"/></equality>
</mujoco>
"""
_COUNTS = ("ncon", "ne", "nf", "nl", "nefc", "nJ")
"""Neighbours in the structure; nothing else in the probe's state has these values in a row."""


class StateLayout(NamedTuple):
    """Offsets in MuJoCo's state, bytes.

    Args:
        equalities: the number of equality constraints, which come first; those of dry friction are next.
        frictions: the number of these.
        rates: the address of their stiffness, damping and impedance, 4 numbers each.
        references: the address of their reference accelerations.
        forces: the address of their forces.
    """

    equalities: int
    frictions: int
    rates: int
    references: int
    forces: int


@cache
def state_layout() -> StateLayout:
    """Return the layout of the state in the version of MuJoCo that is installed."""
    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    counts = _found(data, [getattr(data, name) for name in _COUNTS])
    arrays = [_pointer_to(data, each) for each in (data.efc_KBIP, data.efc_aref, data.efc_force)]
    return StateLayout(counts + 4 * _COUNTS.index("ne"), counts + 4 * _COUNTS.index("nf"), *arrays)


def _found(data: Any, counts: list[int]) -> int:
    """Return where integers stand in a row, between two arrays that are part of the structure."""
    start, end = data.solver_niter.ctypes.data, data.energy.ctypes.data
    numbers = np.ctypeslib.as_array((ctypes.c_int32 * ((end - start) // 4)).from_address(start))
    (place,) = np.flatnonzero(
        (np.lib.stride_tricks.sliding_window_view(numbers, len(counts)) == counts).all(1)
    )
    return int(start + 4 * place - data._address)


def _pointer_to(data: Any, array: Any) -> int:
    """Return where the address of an array stands; all addresses come after the energies."""
    here = data.energy.ctypes.data
    while ctypes.c_uint64.from_address(here).value != array.ctypes.data:
        here += 8
    return int(here - data._address)


def addresses(data: Any) -> IntArray:
    """Return the addresses of the fields of :class:`StateLayout` in a state."""
    return np.array([data._address + offset for offset in state_layout()])
