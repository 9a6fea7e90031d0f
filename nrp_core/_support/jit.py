"""Compile numeric kernels with Numba where it is installed; without it they run, slower, as Python.

Compiled code is kept in the user's cache directory, apart for each state of the sources: Numba itself
looks only at the file of a function, and would go on using what was compiled from others before they
changed. The sources of a function are its package, and the modules of the compiled functions that its
module imports, and of those that these import.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import platformdirs

from nrp_core._support.stopwatch import work

F = TypeVar("F", bound=Callable[..., Any])
A = TypeVar("A")

try:
    import numba
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import event, types
    from numba.extending import intrinsic

    COMPILED = not numba.config.DISABLE_JIT
except ImportError:
    COMPILED = False

CACHE_LINE = 64
"""Bytes that a processor fetches at once."""
_logger = logging.getLogger(__name__)


def jit(function: F) -> F:
    """Compile a function of scalars and arrays; it releases the GIL while it runs."""
    return _compiled(function, inline=False)


def inlined(function: F) -> F:
    """Compile a function into each that calls it, for those that are called most."""
    return _compiled(function, inline=True)


def _compiled(function: F, *, inline: bool) -> F:
    if not COMPILED:
        return function
    chosen = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(_cache_directory(_source(function).parent, _imported(function), chosen))
    try:
        compiled: F = numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=inline)(function)
    finally:
        numba.config.CACHE_DIR = chosen
    return compiled


def _source(function: Callable[..., Any]) -> Path:
    return Path(function.__code__.co_filename)


def _imported(function: Callable[..., Any]) -> frozenset[Path]:
    """Return the modules whose compiled functions a function may call, directly or by way of others."""
    found: dict[int, Callable[..., Any]] = {}
    waiting: list[Callable[..., Any]] = [function]
    while waiting:
        for value in _reachable(waiting.pop()):
            called = getattr(value, "py_func", None)
            if isinstance(called, FunctionType) and id(called) not in found:
                found[id(called)] = called
                waiting.append(called)
    return frozenset(map(_source, found.values()))


def _reachable(function: Callable[..., Any]) -> Iterator[Any]:
    yield from function.__globals__.values()
    yield from (cell.cell_contents for cell in function.__closure__ or ())


@cache
def _cache_directory(package: Path, imported: frozenset[Path], chosen: str) -> Path:
    """Return where the code of a package goes, by the contents of all files that it is compiled from.

    The kernels of a package within another are compiled from those around it as well.
    """
    around = [package, *(folder for folder in package.parents if (folder / "__init__.py").exists())]
    inside = (source for folder in around for source in folder.glob("*.py"))
    digest = hashlib.blake2b(digest_size=8)
    for source in sorted({*inside, *imported, Path(__file__)}):
        digest.update(source.read_bytes())
    base = Path(chosen) if chosen else platformdirs.user_cache_path("nrp-core") / "kernels"
    return base / f"{package.name}-{digest.hexdigest()}"


if COMPILED:

    @intrinsic  # type: ignore[untyped-decorator]
    def borrowed(_typing: Any, arrays: Any) -> Any:
        """Return an array, or a tuple of arrays, without a share in its memory, which the caller keeps alive.

        Compiled code counts references atomically in each call that passes an array; in a kernel of many
        short calls that takes most of the time.
        """

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            (value,) = arguments
            if isinstance(arrays, types.Array):
                return view(context, builder, arrays, value)
            for i, kind in enumerate(arrays):
                own = view(context, builder, kind, builder.extract_value(value, i))
                value = builder.insert_value(value, own, i)
            return value

        def view(context: Any, builder: Any, kind: Any, value: Any) -> Any:
            seen = context.make_array(kind)(context, builder, value)
            seen.meminfo = seen.meminfo.type(None)
            return seen._getvalue()

        return arrays(arrays), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def prefetch(_typing: Any, array: Any, index: Any, offset: Any) -> Any:
        """Let the processor fetch the element of an array that will be needed soon, from a byte in it on."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            element = builder.gep(data, [context.cast(builder, arguments[1], index, types.intp)])
            byte = builder.bitcast(element, ir.IntType(8).as_pointer())
            address = builder.gep(byte, [context.cast(builder, arguments[2], offset, types.intp)])
            number = ir.IntType(32)
            fetch = builder.module.declare_intrinsic(
                "llvm.prefetch",
                [address.type],
                ir.FunctionType(ir.VoidType(), [address.type, number, number, number]),
            )
            builder.call(fetch, [address, number(0), number(3), number(1)])  # to read, to keep, data
            return context.get_dummy_value()

        return types.none(array, index, offset), generate

    class _Compiling(event.Listener):  # type: ignore[misc]
        """Says once why the first start takes longer; stops the clock of the work meanwhile."""

        is_told = False

        def on_start(self, event_: Any) -> None:
            work.stop()
            if not self.is_told:
                self.is_told = True
                _logger.warning("compiling numeric kernels for this machine (some seconds, only once)")

        def on_end(self, event_: Any) -> None:
            work.go_on()

    event.register("numba:compile", _Compiling())

else:

    def borrowed(arrays: A) -> A:
        """Return the array or arrays."""
        return arrays

    def prefetch(_array: A, _index: int, _offset: int) -> None:
        """Do nothing."""
