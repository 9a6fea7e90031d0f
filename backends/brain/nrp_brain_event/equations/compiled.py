"""Compiles the kernels of equations, each once on a machine.

So a new equation costs the compilation of one small function, which the engine calls by its address.
"""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import NamedTemporaryFile, mkdtemp
from typing import Final

from nrp_brain_event.addresses import address_of
from nrp_core._support.jit import COMPILED, cache_folder

Arguments = tuple[tuple[str, str], ...]
"""Names of arguments, and their types for :func:`nrp_core._support.jit.c_function`."""
_UNBOUNDED: Final = 1 << 59
"""The length of an array behind a pointer, whose length is not known; bytes of it fit into 64 bits."""


@cache
def compiled(source: str, name: str, arguments: Arguments) -> int:
    """Return what :func:`~nrp_brain_event.addresses.call` needs to call a function.

    Args:
        source: the module of the function.
        name: the name of the function, which returns an integer.
        arguments: its arguments.
    """
    kernel = _imported(source + _entry(name, arguments), name)
    return address_of(kernel, tuple(kind for _, kind in arguments))


def _imported(source: str, function: str) -> Callable[..., int]:
    """Return the function of a module, which is kept as a file because Numba keeps code by files."""
    name = f"nrp_brain_event_equations_{hashlib.blake2b(source.encode(), digest_size=12).hexdigest()}"
    specification = importlib.util.spec_from_file_location(name, _written(source, name))
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # Numba restores compiled code by the name of its module
    specification.loader.exec_module(module)
    entry: Callable[..., int] = getattr(module, "entry" if COMPILED else function)
    return entry


def _written(source: str, name: str) -> Path:
    folder = cache_folder() / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:  # a cache that cannot be written
        folder = Path(mkdtemp(prefix="nrp-"))
    path = folder / f"{name}.py"
    if not path.exists():
        with NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as file:
            file.write(source)
        Path(file.name).replace(path)
    return path


def _entry(function: str, arguments: Arguments) -> str:
    """Return the source of the function that is called from outside, with pointers instead of arrays."""
    if not COMPILED:
        return ""
    names = [name for name, _ in arguments]
    passed = [f"carray({name}, {_UNBOUNDED})" if kind.startswith("*") else name for name, kind in arguments]
    return (
        f"\n\nfrom numba import carray\n\n\ndef entry({', '.join(names)}):\n"
        f"    return {function}({', '.join(passed)})\n"
    )
