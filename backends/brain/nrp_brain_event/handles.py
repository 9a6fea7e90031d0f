"""Tuples of arrays that are passed to compiled code as one argument.

Numba inspects the type of every argument, and of every array in a tuple: for the arrays of an engine this
takes longer than a short run. A handle is created once and used while the arrays stay the same.

Calls kernels by their address from compiled code.

The code that all networks run is compiled once. What only some of them need is compiled when it is first
needed, and called through a pointer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, Final, Generic, NamedTuple, TypeVar, get_type_hints

import numpy as np

from nrp_brain_event.records import Array, Record
from nrp_core._support.jit import COMPILED, Argument

_kept: Final[list[Any]] = []
"""The kernels in this process, which must stay in memory."""


def address_of(kernel: Callable[..., int], arguments: tuple[Argument, ...]) -> int:
    """Return the argument with which :func:`call` calls a kernel: its address, if code is compiled.

    Args:
        kernel: the function, which is not compiled yet, and returns an integer.
        arguments: types of its arguments, see :func:`nrp_core._support.jit.c_function`.
    """
    if not COMPILED:
        _kept.append(kernel)
        return len(_kept) - 1
    from nrp_core._support.jit import c_function

    compiled = c_function(kernel, "int64", arguments)
    _kept.append(compiled)
    return int(compiled.address)


if COMPILED:
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic  # type: ignore[untyped-decorator]
    def call(_typing: Any, code: Any, arguments: Any) -> Any:
        """Call a kernel with the elements of a tuple; arrays and records become pointers."""

        def generate(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            values = []
            for k, kind in enumerate(arguments):
                value = builder.extract_value(given[1], k)
                if isinstance(kind, types.Array):
                    value = context.make_array(kind)(context, builder, value).data
                values.append(value)
            function = ir.FunctionType(ir.IntType(64), [value.type for value in values])
            return builder.call(builder.inttoptr(given[0], function.as_pointer()), values)

        return types.int64(code, arguments), generate

else:

    def call(code: int, arguments: tuple[Any, ...]) -> int:
        """Call a kernel with arrays as they lie in memory, and return its result."""
        flat = (x.reshape(-1) if getattr(x, "ndim", 0) > 1 else x for x in arguments)
        result: int = _kept[code](*flat)
        return result


T = TypeVar("T", bound=tuple[Array, ...])

_MOST_DIMENSIONS: Final = 2


class Handle(NamedTuple, Generic[T]):
    """Arrays in memory.

    Args:
        arrays: a named tuple; its fields are annotated with the type of the elements, a :class:`Record` or
            one of NumPy's, and the number of dimensions if it is not 1.
        places: the argument for compiled code, see :func:`opened`: address and shape of each array.
    """

    arrays: T
    places: Any


def handle(arrays: T) -> Handle[T]:
    """Return a handle of arrays; it keeps them alive.

    Raises:
        TypeError: an array is not of the declared type, or not contiguous.
    """
    places = np.zeros((len(arrays), 1 + _MOST_DIMENSIONS), np.int64)
    _fill(places, arrays, range(len(arrays)))
    return Handle(arrays, places if COMPILED else arrays)


def with_arrays(held: Handle[T], **changed: Array) -> Handle[T]:
    """Return a handle with some arrays replaced, and the addresses of the others; errors as above."""
    arrays: Any = held.arrays
    arrays = arrays._replace(**changed)
    if not COMPILED:
        return Handle(arrays, arrays)
    places = held.places.copy()
    _fill(places, arrays, [arrays._fields.index(name) for name in changed])
    return Handle(arrays, places)


def _fill(places: Array, arrays: tuple[Array, ...], numbers: Iterable[int]) -> None:
    """Write the addresses of some arrays."""
    declared = list(_declared(type(arrays)).items())
    for number in numbers:
        place, array, (name, (dtype, ndim)) = places[number], arrays[number], declared[number]
        if (array.dtype, array.ndim) != (dtype, ndim) or not array.flags.c_contiguous:
            raise TypeError(
                f"{type(arrays).__name__}.{name} is an array of {array.dtype} with {array.ndim} dimensions "
                f"and strides {array.strides}; it must be one of {dtype} with {ndim}, without gaps"
            )
        place[0], place[1 : 1 + ndim] = array.ctypes.data, array.shape


class Shelf(Generic[T]):
    """Arrays that may be replaced by larger ones, while kernels find them by the same number.

    Attributes:
        arrays: a named tuple, as of a :class:`Handle`.
        places: the argument for compiled code, see :func:`opened`.
        number: the same as an integer in a record.
    """

    def __init__(self, arrays: T) -> None:
        self.arrays, self.places = handle(arrays)
        self.number = self.places.ctypes.data if COMPILED else len(_kept)
        if not COMPILED:
            _kept.append(arrays)
            self.places = self.number

    def put(self, arrays: T) -> None:
        """Replace the arrays."""
        self.arrays, places = handle(arrays)
        if COMPILED:
            self.places[:] = places
        else:
            _kept[self.number] = arrays


@cache
def _declared(kind: type[tuple[Array, ...]]) -> dict[str, tuple[np.dtype[Any], int]]:
    """Return element type and number of dimensions of each array of a named tuple."""
    found = {}
    for name, hint in get_type_hints(kind, include_extras=True).items():
        element, *ndim = hint.__metadata__
        dtype = element.dtype() if issubclass(element, Record) else np.dtype(element)
        found[name] = dtype, ndim[0] if ndim else 1
    return found


if COMPILED:
    import numba
    from numba.core import types
    from numba.extending import intrinsic

    @intrinsic  # type: ignore[untyped-decorator]
    def opened(_typing: Any, kind: Any, places: Any) -> Any:
        """Return a handle's arrays as a named tuple of this type, from its ``places`` or their address."""
        declared = list(_declared(kind.instance_class).values())
        members = [types.Array(numba.from_dtype(dtype), ndim, "C") for dtype, ndim in declared]
        opened_type = types.NamedTuple(members, kind.instance_class)  # type: ignore[attr-defined]

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            from numba.np.arrayobj import populate_array  # takes time to load, and only compiling needs it

            table = arguments[1]
            if isinstance(places, types.Array):
                table = context.make_array(places)(context, builder, table).data

            def number(row: int, column: int) -> Any:
                place = context.get_constant(types.intp, row * (1 + _MOST_DIMENSIONS) + column)
                return builder.load(builder.gep(table, [place]))

            def array(row: int, member: Any) -> Any:
                view = context.make_array(member)(context, builder)
                shape = [number(row, 1 + k) for k in range(member.ndim)]
                itemsize = context.get_constant(types.intp, declared[row][0].itemsize)
                strides = [itemsize]
                for length in shape[:0:-1]:
                    strides.insert(0, builder.mul(strides[0], length))
                data = builder.inttoptr(number(row, 0), view.data.type)
                populate_array(view, data, shape, strides, itemsize, meminfo=None)
                return view._getvalue()

            values = [array(row, member) for row, member in enumerate(members)]
            return context.make_tuple(builder, opened_type, values)

        return opened_type(kind, places), generate

else:

    def opened(_kind: type[T], places: T | int) -> T:
        """Return the arrays."""
        found: T = places if isinstance(places, tuple) else _kept[places]
        return found
