"""Copy the files that code of an imported experiment uses: imported modules and data files."""

from __future__ import annotations

import ast
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath

from nrp_core.errors import ExperimentError
from nrp_legacy.code import Source, as_of_old
from nrp_legacy.convert.python import modern

_LONGEST_NAME = 200


def copy_neighbours(texts: Iterable[str], folders: Sequence[Path], target: Path) -> None:
    """Copy the files that code uses, and the files that imported modules use, into a folder.

    Args:
        texts: the code.
        folders: the folders that are searched, in order.
        target: the target folder.
    """
    waiting, known = list(texts), set[str]()
    while waiting:
        for name in _named(waiting.pop()):
            path = next((path for one in folders if (path := one / name).exists()), None)
            if path is None or name in known:
                continue
            known.add(name)
            _copy(path, target / name)
            waiting += [Source.of_file(one).text for one in _modules(target / name)]


def _copy(path: Path, target: Path) -> None:
    """Copy a file or folder, modules as Python 3."""
    if path == target:
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        shutil.copytree(path, target, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        shutil.copy(path, target)
    for module in _modules(target):
        with suppress(ExperimentError):
            text, changes = modern(Source.of_file(module))
            if changes:
                module.write_text(text, encoding="utf-8")


def _modules(path: Path) -> list[Path]:
    """Return the files of a module or package; none for data."""
    return sorted(path.rglob("*.py")) if path.is_dir() else [path] if path.suffix == ".py" else []


def _named(text: str) -> Iterator[str]:
    """Yield the files and folders that code may use: modules, packages, and files named in strings."""
    try:
        with as_of_old():
            tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                yield from (file for alias in names for file in _files(alias.name))
            case ast.ImportFrom(module=str(module), level=0):
                yield from _files(module)
            case ast.Constant(value=str(name)) if 0 < len(name) < _LONGEST_NAME and name.isprintable():
                parts = PurePosixPath(name).parts
                if parts and parts[0] != "/" and ".." not in parts and "." in parts[-1]:
                    yield name


def _files(module: str) -> tuple[str, str]:
    top = module.partition(".")[0]
    return f"{top}.py", top
