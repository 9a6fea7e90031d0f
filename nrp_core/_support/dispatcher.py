"""A dispatcher of Numba that does not prepare functions for Python which only compiled code calls.

Numba makes for each function that it compiles another one that Python can call, and a file in the cache.
The code of a function that compiled code calls is in that of its caller, so it needs neither of them.
Without them a first use takes a third less CPU time. If Python calls such a function, it is compiled once
more.

Code from the cache is loaded without the definitions that only compiling needs. They take 0.3 s of CPU time.
It contains Numba's own functions that count references, so these are not compiled either (0.02 s).
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import cache
from typing import Any

from llvmlite import binding  # type: ignore[import-untyped]
from numba.core import sigutils
from numba.core.caching import FunctionCache, NullCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher
from numba.core.runtime import _nrt_python

_WITHOUT = "no_cpython_wrapper"


class KernelCache(FunctionCache):  # type: ignore[misc]
    """The compiled code of a function on the disk."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for types of arguments, or None."""
        _name_memory_functions()
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Cache the code for types of arguments; code that Numba cannot write to disk is used uncached."""
        with suppress(RuntimeError):
            super().save_overload(sig, data)


@cache
def _name_memory_functions() -> None:
    """Let compiled code find the functions that allocate arrays, by the names that Numba gives them."""
    for name, address in _nrt_python.c_helpers.items():
        binding.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


class CachedKernel(CPUDispatcher):  # type: ignore[misc]
    """A compiled function.

    Attributes:
        cached: a context in which the cache of the function is opened, when Python calls it first.
    """

    cached: Callable[[], AbstractContextManager[None]] = nullcontext

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._cache: Any
        self._is_called_by_python = False
        self._internal: set[tuple[Any, ...]] = set()
        """Types of arguments for which the function is compiled for compiled code only."""

    def compile(self, sig: Any) -> Any:
        """Compile the function for types of arguments if necessary; return the Python callable."""
        with global_compiler_lock:
            by_python, self._is_called_by_python = self._is_called_by_python, False
            arguments = tuple(sigutils.normalize_signature(sig)[0])
            if by_python:
                if isinstance(self._cache, NullCache):
                    self.enable_caching()
                if arguments in self._internal:
                    self._internal.remove(arguments)
                    del self.overloads[arguments]
                return super().compile(sig)
            if arguments in self.overloads:
                return self.overloads[arguments].entry_point
            self._internal.add(arguments)
            cache: Any = self._cache
            self._cache = NullCache()
            self.targetoptions[_WITHOUT] = True
            try:
                return super().compile(sig)
            finally:
                self._cache = cache
                del self.targetoptions[_WITHOUT]

    def enable_caching(self) -> None:
        """Keep compiled code on the disk."""
        with self.cached():
            self._cache = KernelCache(self.py_func)

    def add_overload(self, cres: Any) -> None:
        """Add compiled code; Python finds it only if it can call it."""
        arguments = tuple(cres.signature.args)
        if arguments in self._internal:
            self.overloads[arguments] = cres
        else:
            super().add_overload(cres)

    def _compilation_chain_init_hook(self) -> None:
        """Do not search all installed packages for Numba's extensions: numbers and arrays need none."""

    def _compile_for_args(self, *args: Any, **named: Any) -> Any:
        with global_compiler_lock:
            self._is_called_by_python = True
            return super()._compile_for_args(*args, **named)
