"""Compile numeric kernels with Numba; with ``NUMBA_DISABLE_JIT=1`` they run, slower, as Python.

Compiled code is kept in the user's cache directory, in a folder for each state of the sources. Numba itself
checks only the file of a function, so it would reuse code after a change in another file. The sources of a
function are its package, the modules of the compiled functions that its module imports, and so on
recursively. Their path does not matter, so a new environment with the same sources compiles nothing.
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

from nrp_core._support import numba_settings as _  # noqa: F401  before Numba

# isort: split
import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core import caching, event, types
from numba.core.types.containers import BaseTuple
from numba.extending import intrinsic

from nrp_core._support.cache import cache_root, mark_used, prune_at_exit, writable_folder
from nrp_core._support.dispatcher import CachedKernel
from nrp_core._support.stopwatch import work

F = TypeVar("F", bound=Callable[..., Any])
Argument = str | np.dtype[Any]

COMPILED = not numba.config.DISABLE_JIT

_logger = logging.getLogger(__name__)


def jit(function: F) -> F:
    """Compile a function of scalars and arrays; it releases the GIL while it runs."""
    return _compile(function, inline=False)


def inlined(function: F) -> F:
    """Compile a function inline into its callers, for the most frequent calls.

    A call of a function that is not inline copies all arrays of a tuple: 2 kB for those of a large engine,
    which takes longer than what is done for a single event.
    """
    return _compile(function, inline=True)


def _compile(function: F, *, inline: bool) -> F:
    if not COMPILED:
        return function
    options = {
        "nopython": True,
        "nogil": True,
        "error_model": "numpy",
        "forceinline": inline,
        "no_cfunc_wrapper": True,  # C code calls none of them, and it is a tenth of the time of compiling
    }
    compiled = CachedKernel(py_func=function, locals={}, targetoptions=options)
    compiled.cached = lambda: _cached(function)
    return cast("F", compiled)


def c_function(function: Callable[..., Any], result: str, arguments: tuple[Argument, ...]) -> Any:
    """Compile a function for calls by its ``address``, and keep it as :func:`jit` does.

    Args:
        function: the function; arguments of a pointer type become arrays by ``numba.carray``.
        result: Numba's name of the type of its result.
        arguments: the same of its arguments; ``*`` before a name stands for a pointer, and the type of a
            structured array for a pointer to a record.
    """
    kinds = [_kind_of(argument) for argument in arguments]
    with _cached(function):
        return numba.cfunc(getattr(types, result)(*kinds), cache=True, error_model="numpy")(function)


def _kind_of(argument: Argument) -> Any:
    if not isinstance(argument, str):
        return types.CPointer(numba.from_dtype(argument))  # type: ignore[attr-defined]
    if argument.startswith("*"):
        return types.CPointer(getattr(types, argument[1:]))  # type: ignore[attr-defined]
    return getattr(types, argument)


def cache_folder() -> Path:
    """Return the folder in which compiled code is kept; a temporary one if it cannot be written."""
    chosen = numba.config.CACHE_DIR
    return writable_folder(Path(chosen)) if chosen else writable_folder(cache_root()) / "kernels"


@contextmanager
def _cached(function: Callable[..., Any]) -> Iterator[None]:
    """Let Numba open a cache in the folder for a function and its sources."""
    folder = _cache_directory(_source(function).parent, _called_modules(function), numba.config.CACHE_DIR)
    settings = {"CACHE_DIR": str(folder)}
    if getattr(numba.config, "CACHE_LOCATOR_CLASSES", None) == "":  # since Numba 0.62; not chosen by the user
        settings["CACHE_LOCATOR_CLASSES"] = f"{__name__}.AnyPlace"
    chosen = {name: getattr(numba.config, name) for name in settings}
    vars(numba.config).update(settings)
    try:
        yield
    finally:
        vars(numba.config).update(chosen)


def _source(function: Callable[..., Any]) -> Path:
    return Path(function.__code__.co_filename)


_known: dict[Callable[..., Any], frozenset[Path]] = {}
"""The result for each function compiled so far; another module reaches the same functions again."""


def _called_modules(function: Callable[..., Any]) -> frozenset[Path]:
    """Return the modules whose compiled functions a function may call, directly or indirectly."""
    found: set[Callable[..., Any]] = set()
    sources: set[Path] = set()
    scanned: set[int] = set()
    waiting: list[Callable[..., Any]] = [function]
    while waiting:
        for value in _reachable(waiting.pop(), scanned):
            called = getattr(value, "py_func", None)
            if not isinstance(called, FunctionType) or called in found:
                continue
            found.add(called)
            sources |= {_source(called), *_known.get(called, ())}
            if called not in _known:
                waiting.append(called)
    return _known.setdefault(function, frozenset(sources))


def _reachable(function: Callable[..., Any], scanned: set[int]) -> Iterator[Any]:
    """Yield the values that a function may use; those of a module only once, as its functions share them."""
    if id(function.__globals__) not in scanned:
        scanned.add(id(function.__globals__))
        yield from function.__globals__.values()
    yield from (cell.cell_contents for cell in function.__closure__ or ())


@cache
def _cache_directory(package: Path, imported: frozenset[Path], chosen: str) -> Path:
    """Return the cache folder of a package's code, named by the contents of all its source files.

    The kernels of a subpackage also depend on the packages around it.
    """
    around = [package, *(folder for folder in package.parents if (folder / "__init__.py").exists())]
    inside = (source for folder in around for source in folder.glob("*.py"))
    digest = hashlib.blake2b(digest_size=8)
    for source in sorted({*inside, *imported, Path(__file__)}):
        digest.update(source.read_bytes())
    base = writable_folder(Path(chosen)) if chosen else cache_folder()
    folder = base / f"{package.name}-{digest.hexdigest()}"
    if folder.is_dir():
        mark_used(folder)
    else:
        prune_at_exit()
    return folder


if COMPILED:

    class AnyPlace(getattr(caching, "UserProvidedCacheLocator", object)):  # type: ignore[misc]
        """Keeps code by the name of its module; by default Numba keeps it by the path of its source."""

        def __init__(self, function: Callable[..., Any], file: str) -> None:
            super().__init__(function, file)
            self._folder = Path(numba.config.CACHE_DIR, f"{function.__module__}-{numba.__version__}")

        def get_cache_path(self) -> str:
            """Return the folder of the code."""
            return str(self._folder)

    @intrinsic  # type: ignore[untyped-decorator]
    def borrowed(_typing: Any, arrays: Any) -> Any:
        """Return an array, or the arrays in nested tuples, as views without a reference to their memory.

        The caller keeps the memory alive.

        Compiled code updates the reference count atomically in each call that passes an array, which
        dominates the time of a kernel with many short calls.
        """

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return lent(context, builder, arrays, arguments[0])

        def lent(context: Any, builder: Any, kind: Any, value: Any) -> Any:
            if isinstance(kind, types.Array):
                return view(context, builder, kind, value)
            for i, part in enumerate(kind if isinstance(kind, BaseTuple) else ()):
                own = lent(context, builder, part, builder.extract_value(value, i))
                value = builder.insert_value(value, own, i)
            return value

        def view(context: Any, builder: Any, kind: Any, value: Any) -> Any:
            seen = context.make_array(kind)(context, builder, value)
            seen.meminfo = seen.meminfo.type(None)
            return seen._getvalue()

        return arrays(arrays), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def array_at(_typing: Any, place: Any, n: Any, like: Any) -> Any:
        """Return the array of ``n`` elements at a place in memory, of the type of another array."""
        kind = types.Array(like.dtype, 1, "C")  # a global array is constant, and the other may be global

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            from numba.np.arrayobj import populate_array  # takes time to load, and only compiling needs it

            view = context.make_array(kind)(context, builder)
            itemsize = context.get_constant(
                types.intp, context.get_abi_sizeof(context.get_data_type(like.dtype))
            )
            data = builder.inttoptr(arguments[0], view.data.type)
            shape = [context.cast(builder, arguments[1], signature.args[1], types.intp)]
            populate_array(view, data, shape, [itemsize], itemsize, meminfo=None)
            return view._getvalue()

        return kind(place, n, like), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def prefetch(_typing: Any, array: Any, index: Any, offset: Any) -> Any:
        """Prefetch the element of an array that will be needed soon, starting at a byte of it."""

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
            builder.call(fetch, [address, number(0), number(3), number(1)])  # read, keep in cache, data
            return context.get_dummy_value()

        return types.none(array, index, offset), generate

    @intrinsic  # type: ignore[untyped-decorator]
    def fma(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
        """Return ``a * b + c``, rounded once: the same result in vectors and in single instructions."""

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            return builder.fma(*arguments)

        number = types.float64
        return number(number, number, number), generate

    class _Compiling(event.Listener):  # type: ignore[misc]
        """Reports once that compiling delays the first start, and pauses the work clock meanwhile."""

        is_told = False

        def on_start(self, event_: Any) -> None:
            work.stop()
            if not self.is_told:
                self.is_told = True
                _logger.warning("compiling the numeric kernels that are new here (some seconds, each once)")

        def on_end(self, event_: Any) -> None:
            work.go_on()

    event.register("numba:compile", _Compiling())

else:
    from nrp_core._support.plain import array_at as array_at
    from nrp_core._support.plain import borrowed as borrowed
    from nrp_core._support.plain import fma as fma
    from nrp_core._support.plain import prefetch as prefetch
