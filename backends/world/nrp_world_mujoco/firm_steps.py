"""Physics steps with firm joints, all steps in one compiled call."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import COMPILED, inlined, jit
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.firm_paths import advance, turn_from, velocities_to
from nrp_world_mujoco.library import mujoco, note, structures

if COMPILED:
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import types
    from numba.extending import intrinsic

    def _loading(element: Any, result: Any) -> Any:
        """Return the function that loads a number of a type, in LLVM and in Numba."""

        @intrinsic  # type: ignore[untyped-decorator]
        def load(_typing: Any, address: Any) -> Any:
            def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                value = builder.load(builder.inttoptr(arguments[0], element.as_pointer()))
                return builder.sext(value, ir.IntType(64)) if element == ir.IntType(32) else value

            return result(address), generate

        return load

    integer_at = _loading(ir.IntType(32), types.int64)
    address_at = _loading(ir.IntType(64), types.int64)
    number_at = _loading(ir.DoubleType(), types.float64)

    @intrinsic  # type: ignore[untyped-decorator]
    def put_number(_typing: Any, address: Any, number: Any) -> Any:
        """Store a number at an address."""

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            builder.store(arguments[1], builder.inttoptr(arguments[0], ir.DoubleType().as_pointer()))
            return context.get_dummy_value()

        return types.none(address, number), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def call(_typing: Any, function: Any, first: Any, second: Any) -> Any:
        """Call a function of C with two addresses."""

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            kind = ir.FunctionType(ir.VoidType(), [ir.IntType(64)] * 2)
            builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
            return context.get_dummy_value()

        return types.none(function, first, second), generate

else:

    def integer_at(address: int) -> int:
        """Return the 32-bit integer at an address."""
        return ctypes.c_int32.from_address(int(address)).value

    def address_at(address: int) -> int:
        """Return the address at an address; 0 for none."""
        return ctypes.c_int64.from_address(int(address)).value

    def number_at(address: int) -> float:
        """Return the double at an address."""
        return ctypes.c_double.from_address(int(address)).value

    def put_number(address: int, number: float) -> None:
        """Write a double to an address."""
        ctypes.c_double.from_address(int(address)).value = number

    def call(function: int, first: int, second: int) -> None:
        """Call the function at an address with two pointers; it returns nothing."""
        ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(int(function))(int(first), int(second))


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
    """Gives compiled code the places of a step's constraints, in MuJoCo's state or in a copy.

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

        If the layout does not give their places, they are copied from now on.
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


_FIELDS = [
    ("axis", np.int64),  # of a ball joint, each coordinate of which is led; else -1
    ("position", np.int64),  # the addresses of its position, a quaternion of a ball joint,
    ("velocity", np.int64),  # its velocity
    ("guess", np.int64),  # and the acceleration with which the solver begins
    ("dof", np.int64),  # its degree of freedom
    ("row", np.int64),  # of its constraint in the last step, among those of dry friction
    ("effort", np.float64),  # in the last step, 0 without a target
]
LED: Final = np.dtype((np.record, _FIELDS))
"""A firm joint in MuJoCo's state."""
AMPLE = 0.5
"""The share of MuJoCo's memory that a step may take for the next one to be compiled: there MuJoCo's errors
end the process, and the only one that a step has is a lack of memory."""
_OF_JOINT: Final = int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)
_INTEGER, _NUMBER = 4, 8
"""Sizes of an int and a double, bytes."""


@inlined
def is_of(dof: int, row: int, state: IntArray) -> bool:
    """Return whether a row is the dry friction of a degree of freedom; that of tendons has numbers too."""
    numbers, kinds = address_at(state[2]), address_at(state[6])
    of_joint: bool = integer_at(kinds + _INTEGER * row) == _OF_JOINT
    return of_joint and integer_at(numbers + _INTEGER * row) == dof


@inlined
def row_of(joint: Any, state: IntArray) -> int:
    """Return the row of a joint's constraint in the present step; -1 without one.

    It changes with the other constraints, because sleeping bodies have none.
    """
    first, count = integer_at(state[0]), integer_at(state[1])
    row: int = first + joint.row
    if joint.row < count and is_of(joint.dof, row, state):
        return row
    for row in range(first, first + count):
        if is_of(joint.dof, row, state):
            joint.row = row - first
            return row
    return -1


@jit
def lead(
    moving: bool, times_s: FloatArray, state: IntArray, joints: Any, orientations: FloatArray, paths: Any
) -> bool:
    """Write the target velocities into the constraints between the two halves of a step.

    Args:
        moving: whether any path has not arrived.
        times_s: the physics step, and the time constants of the approach to a target and of the return to a
            path.
        state: the addresses of :data:`FIELDS`.
        joints: the joints, of the type :data:`LED`, shape ``(n,)``.
        orientations: those from which the positions of ball joints are measured, shape ``(n, 4)``.
        paths: their paths, of the type :data:`~nrp_core.world.engine_kit.firm_kinds.PATHS`.

    Returns:
        Whether any path has not arrived after the step.
    """
    positions, velocities = np.empty(len(joints)), np.empty(len(joints))
    for i in range(len(joints)):
        velocities[i] = number_at(joints[i].velocity)
        if joints[i].axis < 0:
            positions[i] = number_at(joints[i].position)
        elif joints[i].axis == 0:
            start = joints[i].position
            w, x = number_at(start), number_at(start + _NUMBER)
            y, z = number_at(start + 2 * _NUMBER), number_at(start + 3 * _NUMBER)
            turn_from(orientations[i], (x, y, z, w), paths[i : i + 3], positions[i : i + 3])
    if moving:
        moving = advance(times_s[0], times_s[1], positions, velocities, paths)
    velocities_to(times_s[0], times_s[2], positions, paths)
    rates, references = address_at(state[3]), address_at(state[4])
    for i in range(len(joints)):
        row = row_of(joints[i], state) if paths[i].kind != FREE else -1
        if row >= 0:
            reference = references + _NUMBER * row
            rate = number_at(rates + _NUMBER * (4 * row + 1))  # at which it takes its velocity to 0
            acceleration = number_at(reference) + rate * paths[i].wanted
            put_number(reference, acceleration)
            put_number(joints[i].guess, acceleration)  # right, unless the force is at its bound
    return moving


@jit
def read_efforts(state: IntArray, joints: Any, paths: Any) -> None:
    """Read the efforts of the last step; the arguments are those of :func:`lead`."""
    forces = address_at(state[5])
    for i in range(len(joints)):
        row = row_of(joints[i], state) if paths[i].kind != FREE else -1
        joints[i].effort = number_at(forces + _NUMBER * row) if row >= 0 else 0.0


@jit
def take_steps(
    steps: int,
    calls: IntArray,
    moving: bool,
    times_s: FloatArray,
    state: IntArray,
    joints: Any,
    orientations: FloatArray,
    paths: Any,
) -> tuple[int, bool]:
    """Take steps while there is memory, and read the efforts of the last one.

    Args:
        steps: the number of steps.
        calls: the addresses of both halves of MuJoCo's step, of the model and of the state.
        moving: as for :func:`lead`.
        times_s: as there.
        state: as there.
        joints: as there.
        orientations: as there.
        paths: as there.

    Returns:
        The number of steps that were not taken, and whether any path has not arrived.
    """
    first_half, second_half, model, data = calls
    while steps and address_at(state[7]) < AMPLE * address_at(state[8]):
        call(first_half, model, data)
        moving = lead(moving, times_s, state, joints, orientations, paths)
        call(second_half, model, data)
        steps -= 1
    read_efforts(state, joints, paths)
    return steps, moving
