"""The brain script of an experiment and the modules beside it, as they are written."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from nrp_core.dsl.loading import PythonSource, python_listing
from nrp_core.errors import TransferFunctionError


def scripts_from(path: Path) -> list[PythonSource]:
    """Return a brain script and the modules beside it that it imports.

    A file that is not Python is left out: whatever executes it reports that, or knows another version of it.
    """
    found: dict[Path, PythonSource | None] = {}
    waiting = [path]
    while waiting:
        file = waiting.pop(0)
        if file not in found and file.suffix == ".py" and file.is_file():
            found[file] = source = _read(file)
            waiting += _beside(source) if source is not None else ()
    return [source for source in found.values() if source is not None]


def _read(file: Path) -> PythonSource | None:
    try:
        return python_listing(file).sources[0]
    except TransferFunctionError:
        return None


def _beside(source: PythonSource) -> Iterator[Path]:
    folder = source.path.parent
    for node in ast.walk(source.tree):
        match node:
            case ast.Import(names):
                yield from (folder / f"{one.name.replace('.', '/')}.py" for one in names)
            case ast.ImportFrom(module=str(module)):
                yield folder / f"{module.replace('.', '/')}.py"
