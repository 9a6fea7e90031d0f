"""Installed packages: their entry points, digests of their code, and those that an extra installs."""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import re
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache, lru_cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES, ModuleSpec
from importlib.metadata import Distribution, EntryPoint, PackageNotFoundError
from importlib.util import find_spec
from pathlib import Path

from nrp_core.errors import BackendLoadError


def require_extra(module: str, requirement: str, what: str) -> None:
    """Refuse to go on without a package that an extra installs.

    Args:
        module: the name under which it is imported.
        requirement: the distribution and its extra, as in ``nrp-lab[gym]``.
        what: the feature that needs it, for the message.

    Raises:
        BackendLoadError: it is not installed; the message has the command that installs it.
    """
    try:
        found = find_spec(module)
    except ValueError:  # it was made unavailable in this process
        found = None
    if found is None:
        raise BackendLoadError(f"{what} needs {module}", remedy=f"pip install '{requirement}'")


_SUFFIXES = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)


@cache
def fingerprint(package: str) -> str:
    """Return a digest of the code of a top-level package or module, independent of its place.

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


State = tuple[tuple[str, int], ...]
"""The folders of ``sys.path`` and the times of the last installation or removal there, ns."""


def installed() -> State:
    """Return the state that the entry points depend on, as a key of caches."""
    state = []
    for entry in sys.path:
        with suppress(OSError):  # a folder that is not there, as Python allows
            state.append((entry, os.stat(entry or os.curdir).st_mtime_ns))  # noqa: PTH116  this runs often
    return tuple(state)


def entries(group: str) -> list[EntryPoint]:
    """Return the entry points of a group; of two distributions of one name the first on the path counts."""
    found: dict[str, list[EntryPoint]] = {}
    for folder, changed_ns in installed():
        for distribution, groups in _read(folder, changed_ns):
            if group in groups:
                name = re.sub(r"[-_.]+", "_", name_and_version(distribution)[0]).lower()
                found.setdefault(name, groups[group])
    return [entry for some in found.values() for entry in some]


@lru_cache(maxsize=64)
def _read(folder: str, _changed_ns: int) -> list[tuple[Distribution, dict[str, list[EntryPoint]]]]:
    """Return the distributions in a folder that have entry points, and these by their groups."""
    found = []
    for distribution in importlib.metadata.distributions(path=[folder]):
        groups: dict[str, list[EntryPoint]] = {}
        for entry in distribution.entry_points:
            groups.setdefault(entry.group, []).append(entry)
        if groups:
            found.append((distribution, groups))
    return found


@lru_cache(maxsize=64)
def name_and_version(distribution: Distribution) -> tuple[str, str]:
    """Return the name and version of a distribution, without parsing its metadata (0.5 ms) at each use."""
    metadata = distribution.metadata
    return metadata["Name"], metadata["Version"]


@lru_cache(maxsize=64)
def _plugins(_state: State) -> dict[str, str]:
    found = {"nrp_core": "nrp-core"}
    for folder, changed_ns in _state:
        for distribution, groups in _read(folder, changed_ns):
            ours = (some for group, some in groups.items() if group.startswith("nrp_core."))
            packages = (entry.module.partition(".")[0] for some in ours for entry in some)
            found |= dict.fromkeys(packages, name_and_version(distribution)[0])
    return found


def plugin_packages() -> dict[str, str]:
    """Return the top-level packages of the core and of all installed plugins, with their distributions."""
    return _plugins(installed())


@cache
def is_installed(package: str) -> bool:
    """Whether a top-level package is part of the installed software, the standard library included."""
    try:
        spec = find_spec(package)
    except (ImportError, ValueError):  # a module created in memory
        return False
    if spec is None:
        return False
    places = [*(spec.submodule_search_locations or ()), *([spec.origin or ""] if spec.has_location else [])]
    software = (f"{sys.prefix}{os.sep}", f"{sys.base_prefix}{os.sep}")
    return not places or any(place.startswith(software) for place in places)


@cache
def required_versions(packages: frozenset[str]) -> dict[str, str]:
    """Return the versions of the distributions of some packages, and of all that they require, by name.

    The extra ``models`` counts where it is installed: its packages read files of robots.
    """
    from packaging.requirements import Requirement  # slow to import

    plugins = plugin_packages()
    others = importlib.metadata.packages_distributions() if packages - plugins.keys() else {}
    names = (others.get(package, ()) for package in packages)
    waiting = [Requirement(name) for some in names for name in some]
    waiting += [Requirement(plugins[package]) for package in packages & plugins.keys()]
    found: dict[str, str] = {}
    while waiting:
        wanted = waiting.pop()
        name = re.sub(r"[-_.]+", "-", wanted.name).lower()
        with suppress(PackageNotFoundError):
            if name not in found:
                distribution = importlib.metadata.distribution(name)
                found[name] = distribution.version
                lines = map(Requirement, distribution.requires or ())
                waiting += [
                    one for one in lines if one.marker is None or one.marker.evaluate({"extra": "models"})
                ]
    return dict(sorted(found.items()))
