"""A digest of the files of a package, because two states of the code can have the same version."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES, ModuleSpec
from importlib.util import find_spec
from pathlib import Path

_SUFFIXES = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)


@cache
def fingerprint(package: str) -> str:
    """Return a digest of the code of a top-level package or module, the same wherever it is installed.

    It is computed once for each process. A module without files has an empty digest.
    """
    digest = hashlib.blake2b(digest_size=8)
    files = dict(_files(_spec(package)))
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name].read_bytes())
    return digest.hexdigest() if files else ""


def _spec(package: str) -> ModuleSpec | None:
    try:
        return find_spec(package)
    except ValueError:  # a module created in memory
        return None


def _files(spec: ModuleSpec | None) -> Iterator[tuple[str, Path]]:
    """Return the files of a package or module, by their relative names."""
    if spec is None:
        return
    for folder in map(Path, spec.submodule_search_locations or ()):
        for path in folder.rglob("*"):
            if path.name.endswith(_SUFFIXES) and path.is_file():
                yield path.relative_to(folder).as_posix(), path
    if spec.submodule_search_locations is None and spec.origin and Path(spec.origin).is_file():
        yield Path(spec.origin).name, Path(spec.origin)
