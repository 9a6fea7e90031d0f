"""Where MuJoCo's state keeps the constraints of a step, for compiled code.

They are allocated anew in each step. Python's access to them takes a microsecond each. The layout of the
state differs by version, and MuJoCo's package describes its own.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_world_mujoco.library import note, structures

ARRAYS: Final = ("efc_id", "efc_KBIP", "efc_aref", "efc_force", "efc_type")
"""Of each constraint what it constrains; its stiffness, damping and impedance, 4 numbers; its reference
acceleration; its force; its kind."""
FIELDS: Final = ("ne", "nf", *ARRAYS, "maxuse_arena", "narena")
"""The numbers of equality constraints, which come first, and of those of dry friction, which are next; the
arrays; the largest part of MuJoCo's memory that was in use, and all of it, bytes."""
_SCALARS: Final[dict[str, Any]] = {
    "int": ctypes.c_int,
    "mjtBool": ctypes.c_bool,
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "uintptr_t": ctypes.c_size_t,
}


@cache
def layout() -> type[ctypes.Structure] | None:
    """Return the layout of the state in the installed version; None if its package does not describe it."""
    try:
        described = _structure("mjData")
    except (ImportError, LookupError, AttributeError):
        return None
    return described if all(hasattr(described, name) for name in FIELDS) else None


def _structure(name: str) -> type[ctypes.Structure]:
    fields = [(field.name, _type(field.type)) for field in structures()[name].fields]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def _type(described: Any) -> Any:
    if hasattr(described, "extents"):
        result = _type(described.inner_type)
        for extent in reversed(described.extents):
            result *= extent
        return result
    if hasattr(described, "inner_type"):
        return ctypes.c_void_p
    return _SCALARS.get(described.name) or _structure(described.name)


class Constraints:
    """Leads compiled code to the constraints of a step, in MuJoCo's state or in a copy of where they are.

    Args:
        data: MuJoCo's state, which must outlive this.

    Attributes:
        addresses: the addresses of :data:`FIELDS`.
        direct: whether they are in MuJoCo's own state, so that they are right in each step.
    """

    def __init__(self, data: Any) -> None:
        self._data, described = data, layout()
        self._copy = np.zeros(len(FIELDS), dtype=np.int64)
        self.addresses: IntArray = self._copy.ctypes.data + self._copy.itemsize * np.arange(len(FIELDS))
        self._view: Any = None
        if described is not None:
            self._view = described.from_address(data._address)
            self.addresses[:] = [data._address + getattr(described, name).offset for name in FIELDS]

    @property
    def direct(self) -> bool:
        return self._view is not None

    def find(self) -> None:
        """Find the constraints after the first half of a step that Python takes.

        If they are not where the layout says, they are copied from now on.
        """
        data = self._data
        arrays = [getattr(data, name).ctypes.data for name in ARRAYS] if data.nefc else [0] * len(ARRAYS)
        self._copy[:] = data.ne, data.nf, *arrays, data.maxuse_arena, data.narena
        if self._view is None:
            return
        seen = [getattr(self._view, name) or 0 for name in FIELDS]
        if not data.nefc:  # then the addresses mean nothing
            seen[2 : 2 + len(ARRAYS)] = arrays
        if seen != self._copy.tolist():
            note("its state is not laid out as its package says, so steps of commanded joints take longer")
            self._view = None
            self.addresses[:] = self._copy.ctypes.data + self._copy.itemsize * np.arange(len(FIELDS))
