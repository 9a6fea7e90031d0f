"""What a run depends on: the one answer, for whoever keeps a run, reuses it, or explains a difference."""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import os
import platform
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import ModuleType
from typing import Any, Self

from platformdirs import user_cache_path
from pydantic import BaseModel

from nrp_core._support.packages import fingerprint, is_installed, plugin_packages, required_versions
from nrp_core._support.used_files import FilesRead, variable_now, version_of
from nrp_core.experiment.model.experiment import EMPTY_SCENE, Experiment
from nrp_core.experiment.model.section import Tree
from nrp_core.recording.sealing import file_digest
from nrp_core.scene.model import Scene, files_behind

_READ_IN_C = {".h5", ".hdf5", ".nwb", ".nrpnet", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".db"}
"""Suffixes of files that libraries in C open, of which Python does not learn."""
_LONGEST_NAME = 200
_CHANGED = "changed while it was read"
_UNKNOWN = "everything, as far as is known,"


@dataclass(frozen=True, slots=True)
class Dependencies:
    """The files and packages that a run read, without its settings.

    Args:
        files: digests of the files, by path.
        folders: digests of the names in folders that the experiment's own files list, by path.
        variables: values of environment variables; None: not set.
        packages: fingerprints of the code of packages: the core, the plugins that were loaded, and modules
            outside of the installed software.
        versions: of Python, and of all distributions that these packages require.
    """

    files: Mapping[str, str] = field(default_factory=dict)
    folders: Mapping[str, str] = field(default_factory=dict)
    variables: Mapping[str, str | None] = field(default_factory=dict)
    packages: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Return the dependencies of data from :meth:`to_data`; what is missing is empty."""
        return cls(**{one.name: dict(data.get(one.name) or {}) for one in fields(cls)})

    @classmethod
    def recorded(cls, run: Mapping[str, Any]) -> Self:
        """Return the dependencies in ``run.json``; of versions up to 0.3 only packages and versions."""
        older = {"packages": run.get("code"), "versions": run.get("distributions")}
        return cls.from_data(run.get("dependencies") or older)

    def to_data(self, root: Path | None = None) -> dict[str, Any]:
        """Return them as JSON objects, with files and folders below ``root`` relative to it."""
        data = asdict(self)
        for kind in ("files", "folders"):
            data[kind] = {_relative(path, root): digest for path, digest in data[kind].items()}
        return data

    def changes(self, root: Path | None = None) -> list[str]:
        """Return the changes since then, a phrase for each; empty: the run would be the same.

        Args:
            root: the folder that relative paths start from.
        """
        home = root or Path()
        return [
            *(f"the file {path}" for path, digest in self.files.items() if _now(home / path) != digest),
            *(f"the files in {path}" for path, names in self.folders.items() if _names(home / path) != names),
            *(
                f"the variable {name}"
                for name, value in self.variables.items()
                if variable_now(name) != value
            ),
            *(f"the code of {name}" for name in self.changed_packages()),
            *self.changed_versions(),
        ]

    def without_files_below_root(self) -> Self:
        """Return them without files and folders that :meth:`to_data` made relative, which a recording has."""
        files = {path: digest for path, digest in self.files.items() if Path(path).is_absolute()}
        return replace(self, files=files, folders={})

    def changed_packages(self) -> list[str]:
        """Return the names of packages whose code is different now."""
        return [name for name, digest in self.packages.items() if fingerprint(name) != digest]

    def changed_versions(self) -> list[str]:
        """Return the distributions whose installed version has changed, with both versions."""
        return [
            f"{name} {version} (now {_version(name) or 'none'})"
            for name, version in self.versions.items()
            if _version(name) != version
        ]


def dependencies(
    files: FilesRead, experiment: Experiment | None, scene: Scene | None = None, own: Path | None = None
) -> Dependencies:
    """Return the dependencies of a run up to now.

    Args:
        files: was active while the experiment was loaded, opened and run.
        experiment: the experiment, if it could be loaded.
        scene: its scene, if its world was opened.
        own: a folder that the run writes to, whose files do not count.
    """
    others = files.elsewhere(_folders_of_plugins())
    read = {*read_files(files, experiment, scene, own), *_outside(others, own)}
    derived = user_cache_path()
    packages = _with_modules(files.packages)
    roots = {name for name in packages if name not in sys.stdlib_module_names}
    plugins = plugin_packages()
    code = {name for name in roots if name in plugins or not is_installed(name)}
    return Dependencies(
        {
            str(path): _digest(path) if files.is_unchanged(path) else _CHANGED
            for path in sorted(read)
            if not path.is_relative_to(derived)
        },
        {path: _names(Path(path)) for path in sorted(files.folders) if own is None or Path(path) != own},
        dict(sorted(files.variables.items())),
        {name: fingerprint(name) for name in sorted(code)},
        {"Python": platform.python_version(), **required_versions(frozenset(roots))},
    )


def changes_since(run: Mapping[str, Any], file: Path | None) -> list[str]:
    """Return the changed dependencies of a recorded run, a phrase for each; empty if none changed.

    Args:
        run: the contents of its ``run.json``.
        file: the file of the experiment that was recorded; None: it has none.
    """
    written = run.get("file")
    if "dependencies" not in run:
        return [_UNKNOWN]
    levels = 0 if written is None else len(Path(written).parts) - 2
    return Dependencies.recorded(run).changes(None if file is None else file.parents[levels])


def read_files(
    files: FilesRead, experiment: Experiment | None, scene: Scene | None = None, own: Path | None = None
) -> list[Path]:
    """Return the files of an experiment that a run has read so far; the arguments as above.

    They are those that it names, those of its scene, and others in the same folders.
    """
    named = {path for path in named_files(experiment) if path.is_file()} if experiment else set()
    found = named | set(files_behind(scene) if scene else ())
    models = experiment.models if experiment else ()
    found |= {*files.below({path.parent for path in named} | set(models))}
    found |= {path for script in found if script.suffix == ".py" for path in _read_in_c(script)}
    found = {path for path in found if not files.is_output(path)}
    return _outside(found, own)  # it may be beside the experiment, and is read to be completed


def _outside(paths: Iterable[Path], own: Path | None) -> list[Path]:
    own = own.resolve() if own else None
    return sorted(path for path in paths if own is None or own not in path.resolve().parents)


def named_files(experiment: Experiment) -> Iterator[Path]:
    """Return the files that an experiment was read from and those that it names.

    The scene ``empty`` is code of the core, which has a fingerprint.
    """
    yield from _places(experiment.source)
    yield from (path for path in _paths(experiment) if path != EMPTY_SCENE)


def _places(tree: Tree) -> Iterator[Path]:
    if tree.place.path is not None:
        yield tree.place.path
    children = tree.value.values() if isinstance(tree.value, dict) else tree.value
    for child in children if isinstance(tree.value, (dict, list)) else ():
        yield from _places(child)


def _paths(value: Any) -> Iterator[Path]:
    match value:
        case Path():
            yield value
        case BaseModel():
            for name in type(value).model_fields:
                yield from _paths(getattr(value, name))
        case dict():
            for item in value.values():
                yield from _paths(item)
        case list() | tuple():
            for item in value:
                yield from _paths(item)


def _read_in_c(script: Path) -> Iterator[Path]:
    """Yield the files that a script names and that it may read by a library in C."""
    with suppress(OSError, SyntaxError, ValueError):
        for name in _names_read_in_c(script.read_bytes()):
            if (path := script.parent / name).is_file():
                yield path


@lru_cache(maxsize=64)
def _names_read_in_c(data: bytes) -> tuple[str, ...]:
    texts = (node.value for node in ast.walk(ast.parse(data)) if isinstance(node, ast.Constant))
    names = (text[:_LONGEST_NAME] for text in texts if isinstance(text, str))
    return tuple(name for name in names if Path(name).suffix.lower() in _READ_IN_C)


def _folders_of_plugins() -> list[Path]:
    """Return the folders of the core and of imported plugins, whose code has fingerprints."""
    modules = (sys.modules.get(name) for name in plugin_packages())
    return [Path(folder) for module in modules for folder in getattr(module, "__path__", ())]


def _with_modules(packages: Iterable[str]) -> set[str]:
    """Return packages, and those that modules outside of released distributions use in turn."""
    found: set[str] = set()
    waiting = sorted(packages)
    while waiting:
        name = waiting.pop()
        if name not in found and name not in sys.stdlib_module_names:
            found.add(name)
            if name not in plugin_packages() and not is_installed(name):
                waiting += _used_by(name)
    return found


def _used_by(package: str) -> set[str]:
    modules = [one for name, one in sys.modules.items() if f"{name}.".startswith(f"{package}.")]
    values = [value for module in modules for value in vars(module).values()]
    names = (
        value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", None)
        for value in values
    )
    used = {name.partition(".")[0] for name in names if isinstance(name, str)}
    return used & sys.modules.keys() - {"__main__"}


def _relative(path: str, root: Path | None) -> str:
    is_inside = root is not None and Path(path).is_relative_to(root)
    return Path(path).relative_to(root).as_posix() if is_inside and root is not None else path


def _now(path: Path) -> str:
    return _digest(path) if path.is_file() else "missing"


def _digest(path: Path) -> str:
    version = version_of(str(path))
    return _digest_of_version(path, version) if version else "missing"


@cache
def _digest_of_version(path: Path, _version: tuple[int, int]) -> str:
    """Return the digest of a file, cached until the file changes; the runs of a sweep share files."""
    return file_digest(path)


def _names(folder: Path) -> str:
    """Return a digest of the names in a folder, those of caches aside."""
    with suppress(OSError):
        names = sorted(name for name in os.listdir(folder) if name != "__pycache__")  # noqa: PTH208
        return hashlib.blake2b("\0".join(names).encode("utf-8", "surrogateescape")).hexdigest()[:32]
    return "missing"


def _version(name: str) -> str:
    if name == "Python":
        return platform.python_version()
    try:
        return importlib.metadata.version(name)
    except PackageNotFoundError:
        return ""
