"""Find plugins by entry points; there is no other way in, for ours as for anybody's.

A group is read as metadata (nothing is imported), a plugin is imported when it is asked for by name.
One broken plugin hides no other.
"""

from __future__ import annotations

import importlib.metadata
import sys
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar, cast

from stevedore.driver import DriverManager
from stevedore.exception import NoMatches

from nrp_core._support.fingerprint import fingerprint
from nrp_core.brain.interface import BrainBackend
from nrp_core.errors import (
    BackendLoadError,
    DuplicateBackendError,
    IncompatibleBackendError,
    UnknownBackendError,
    did_you_mean,
)
from nrp_core.simulation import INTERFACE_VERSION
from nrp_core.world.interface import WorldBackend

BRAIN_GROUP = "nrp_core.brain"
WORLD_GROUP = "nrp_core.world"

T = TypeVar("T")


class _Driver(DriverManager[Any]):
    """Stevedore's driver, reading the metadata itself.

    Its on-disk cache misses changes of the last minutes and forgets which distribution an entry
    point came from.
    """

    def list_entry_points(self) -> list[EntryPoint]:
        # what pip leaves behind when it is interrupted lists a distribution's entries a second time
        return list(dict.fromkeys(_entries(self.namespace)))


@dataclass(frozen=True, slots=True)
class Provider:
    """Who provides a plugin: entry-point name, distribution, its version, and the target."""

    name: str
    distribution: str
    version: str
    target: str

    @classmethod
    def of(cls, entry: EntryPoint) -> Provider:
        """Read an entry point."""
        if entry.dist is None:
            return cls(entry.name, "unknown", "?", entry.value)
        return cls(entry.name, entry.dist.name, entry.dist.version, entry.value)

    @property
    def package(self) -> str:
        """The top-level package of its code."""
        return self.target.partition(":")[0].partition(".")[0]

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} ({self.target})"


@dataclass(frozen=True, slots=True)
class Registry(Generic[T]):
    """The plugins of one entry-point group.

    Args:
        group: the entry-point group.
        kind: what a plugin is called in messages, e.g. ``brain backend``.
        base: the class a plugin must derive from, or None for any object.
    """

    group: str
    kind: str
    base: type[T] | None = None

    EMPTY: ClassVar[str] = "install one, e.g. pip install nrp-core"

    def providers(self) -> list[Provider]:
        """Return every installed plugin, by name, without importing any."""
        return sorted(
            {Provider.of(entry) for entry in _entries(self.group)}, key=lambda p: (p.name, p.distribution)
        )

    def names(self) -> list[str]:
        """Return the names of all installed plugins."""
        return sorted({provider.name for provider in self.providers()})

    def load(self, name: str) -> T:
        """Import a plugin and, where it is a class, make one.

        Raises:
            UnknownBackendError: nobody provides the name.
            DuplicateBackendError: two distributions do.
            BackendLoadError: it does not import, or is not what its group holds.
            IncompatibleBackendError: it was written for another interface version.
        """
        provider = self.provider(name)
        plugin = self._import(provider)
        if self.base is None:
            return cast(T, plugin)
        if not (isinstance(plugin, type) and issubclass(plugin, self.base)):
            raise BackendLoadError(
                f"{self.kind} '{name}' of {provider} is not a subclass of {self.base.__name__}"
            )
        version = getattr(plugin, "interface_version", None)
        if version != INTERFACE_VERSION:
            raise IncompatibleBackendError(
                f"{self.kind} '{name}' of {provider} was written for interface version {version}; "
                f"this nrp-core has version {INTERFACE_VERSION}: "
                + _upgrade(provider.distribution if (version or 0) < INTERFACE_VERSION else "nrp-core")
            )
        return plugin()

    def provider(self, name: str) -> Provider:
        """Return who provides a name.

        Raises:
            UnknownBackendError: nobody does.
            DuplicateBackendError: two distributions do.
        """
        found = [provider for provider in self.providers() if provider.name == name]
        if not found:
            names = self.names()
            hint = did_you_mean(name, names) if names else f"; none is installed: {self.EMPTY}"
            raise UnknownBackendError(f"no {self.kind} is called '{name}'{hint}")
        if len(found) > 1:
            owners = " and ".join(map(str, found))
            raise DuplicateBackendError(
                f"two distributions provide the {self.kind} '{name}': {owners}; "
                f"remove one: pip uninstall {found[-1].distribution}"
            )
        return found[0]

    def _import(self, provider: Provider) -> object:
        try:
            driver = _Driver(self.group, provider.name, on_load_failure_callback=_raise)
        except NoMatches as error:
            raise BackendLoadError(f"{self.kind} '{provider.name}' of {provider} vanished") from error
        except Exception as error:
            raise BackendLoadError(
                f"{self.kind} '{provider.name}' of {provider} does not import: "
                f"{type(error).__name__}: {error}; try: pip install --force-reinstall {provider.distribution}"
            ) from error
        return driver.driver


def _entries(group: str) -> EntryPoints:
    """Return the entry points of a group; the metadata of what is installed is read once for all groups."""
    folders = (Path(entry) for entry in sys.path)
    state = tuple((str(one), one.stat().st_mtime_ns) for one in folders if one.is_dir())
    found: EntryPoints = _installed(state).select(group=group)
    return found


@lru_cache(maxsize=1)
def _installed(_state: tuple[tuple[str, int], ...]) -> Any:
    """Return all entry points.

    Args:
        _state: the folders that programs are installed in, and when something there last came or went.
    """
    return importlib.metadata.entry_points()


def _raise(_manager: object, _entry: EntryPoint, error: BaseException) -> None:
    raise error


def _upgrade(distribution: str) -> str:
    return f"pip install --upgrade {distribution}"


def brains() -> Registry[BrainBackend]:
    """Return the registry of brain backends."""
    return Registry(BRAIN_GROUP, "brain backend", BrainBackend)


def worlds() -> Registry[WorldBackend]:
    """Return the registry of world backends."""
    return Registry(WORLD_GROUP, "world backend", WorldBackend)


def plugins(group: str, kind: str) -> Registry[Any]:
    """Return the registry of any other entry-point group, whose plugins are plain objects."""
    return Registry(group, kind)


def code_of(brain: str, world: str) -> dict[str, str]:
    """Return the fingerprints of the core and of two backends, by the names of their packages.

    Raises:
        UnknownBackendError, DuplicateBackendError: there is no such backend, or there are two.
    """
    packages = brains().provider(brain).package, worlds().provider(world).package
    return {package: fingerprint(package) for package in ("nrp_core", *packages)}
