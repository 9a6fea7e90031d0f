"""Calls kernels by their address from compiled code.

The code that all networks run is compiled once. What only some of them need is compiled when it is first
needed, and called through a pointer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from nrp_core._support.jit import COMPILED

_kept: Final[list[Any]] = []
"""The kernels in this process, which must stay in memory."""


def address_of(kernel: Callable[..., int], arguments: tuple[str, ...]) -> int:
    """Return what :func:`call` needs to call a kernel; its address, if code is compiled.

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
    from numba.np.arrayobj import make_array

    @intrinsic  # type: ignore[untyped-decorator]
    def call(_typing: Any, code: Any, arguments: Any) -> Any:
        """Call a kernel with the elements of a tuple; arrays and records become pointers."""

        def generate(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            values = []
            for k, kind in enumerate(arguments):
                value = builder.extract_value(given[1], k)
                if isinstance(kind, types.Array):
                    value = make_array(kind)(context, builder, value).data
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
