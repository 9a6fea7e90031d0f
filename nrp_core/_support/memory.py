"""Access by address from compiled code: to functions of libraries in C, and to their structures."""

from __future__ import annotations

import ctypes
from typing import Any

from nrp_core._support.jit import COMPILED

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
        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            builder.store(arguments[1], builder.inttoptr(arguments[0], ir.DoubleType().as_pointer()))
            return context.get_dummy_value()

        return types.none(address, number), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def call(_typing: Any, function: Any, first: Any, second: Any) -> Any:
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
