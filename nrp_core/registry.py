"""Find plugins by entry points, ours and those of third parties alike.

A group is read as metadata (nothing is imported), a plugin is imported when it is asked for by name.
A broken plugin does not hide others. The user of a group defines the type of its plugins::

    READERS: Registry[Reader] = Registry("nrp_core.networks", "reader of networks")
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Final, Generic, TypeVar, cast

from nrp_core._support.audit_events import LOADS
from nrp_core._support.packages import State, entries, installed, name_and_version
from nrp_core.errors import (
    BackendLoadError,
    DuplicateBackendError,
    IncompatibleBackendError,
    UnknownBackendError,
    did_you_mean,
)

T = TypeVar("T")

_MEDIUM: Final = (
    "Buoyancy", "Hydrodynamics", "LiftDrag", "LiftDragPlugin", "MulticopterMotorModel", "Thruster",
    "nrp_drag",
)  # fmt: skip

OPTIONAL: Final[Mapping[str, Mapping[str, Sequence[str]]]] = {
    "nrp-brain-brian2": {
        f"nrp_core.{group}": ["brian2"] for group in ("brain", "networks", "pynn_dialects", "pynn_runners")
    },
    "nrp-brain-composite": {"nrp_core.brain": ["composite"]},
    "nrp-brain-nest": {"nrp_core.brain": ["nest"]},
    "nrp-brain-pynn": {"nrp_core.brain": ["pynn"]},
    "nrp-cockpit": {"nrp_core.commands": ["cockpit", "demo", "design", "share"]},
    "nrp-conformance": {"nrp_core.commands": ["conformance"]},
    "nrp-ebrains": {
        "nrp_core.experiment_readers": [".json"],
        "nrp_core.importers": [".json"],
        "nrp_core.platforms": ["nrp_core_4"],
    },
    "nrp-formats": {
        "nrp_core.commands": ["import-connectome"],
        "nrp_core.exporters": ["nwb", "sonata"],
        "nrp_core.networks": [".json", ".nir"],
    },
    "nrp-lab": {"nrp_core.commands": ["benchmark", "diff", "evolve", "paper", "sweep"]},
    "nrp-legacy": {
        "nrp_core.commands": ["import"],
        "nrp_core.experiment_readers": [".exc"],
        "nrp_core.platforms": ["hbp_nrp"],
        "nrp_core.script_languages": ["python2"],
    },
    "nrp-medium": {"nrp_core.drives": _MEDIUM},
    "nrp-pynest": {"nrp_core.pynn_dialects": ["nest"], "nrp_core.pynn_runners": ["nest"]},
    "nrp-spynnaker": {
        "nrp_core.pynn_dialects": ["pyNN.spiNNaker", "spynnaker", "spynnaker7", "spynnaker8"],
        "nrp_core.pynn_runners": ["spinnaker"],
    },
    "nrp-world-drake": {"nrp_core.world": ["drake"]},
    "nrp-world-gazebo": {"nrp_core.world": ["gazebo"]},
    "nrp-world-gymnasium": {"nrp_core.world": ["gymnasium"]},
    "nrp-world-opensim": {"nrp_core.world": ["opensim"]},
    "nrp-world-ros": {"nrp_core.commands": ["ros-bridge"], "nrp_core.world": ["ros"]},
}
"""The plugins of distributions of this project that may not be installed: names by distribution and group."""

_SETUP: Final = Path(__file__).parents[1] / "scripts" / "setup"
"""In a clone of the repository, what installs these distributions."""


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
        named = ("unknown", "?") if entry.dist is None else name_and_version(entry.dist)
        return cls(entry.name, *named, entry.value)

    @property
    def package(self) -> str:
        """The top-level package of its code."""
        return self.target.partition(":")[0].partition(".")[0]

    def __str__(self) -> str:
        return f"{self.distribution} {self.version} ({self.target})"


@dataclass(frozen=True)
class Registry(Generic[T]):
    """The plugins of one entry-point group.

    Args:
        group: the entry-point group.
        kind: the kind of the plugins in messages, e.g. ``brain backend``.
        bases: a plugin is a class that derives from one of these, and :meth:`load` makes one;
            empty for plain objects.
        interface_version: the version of the interface that such a class must be written for, which it
            carries as ``interface_version``; None where the interface has no versions.
    """

    group: str
    kind: str
    bases: Sequence[type] = ()
    interface_version: int | None = None

    def providers(self) -> list[Provider]:
        """Return every installed plugin, by name, without importing any."""
        return list(_providers(self.group, installed()))

    def names(self) -> list[str]:
        """Return the names of all installed plugins."""
        return sorted({provider.name for provider in self.providers()})

    def load(self, name: str) -> T:
        """Import a plugin and, where it is a class, make one.

        Raises:
            UnknownBackendError: no package provides the name.
            DuplicateBackendError: two distributions do.
            BackendLoadError: it does not import, or does not have the type of its group.
            IncompatibleBackendError: it was written for another interface version.
        """
        provider = self.provider(name)
        sys.audit(LOADS, provider.package)
        plugin = self._import(provider)
        if not self.bases:
            return cast(T, plugin)
        if not (isinstance(plugin, type) and issubclass(plugin, tuple(self.bases))):
            valid = " or ".join(base.__name__ for base in self.bases)
            raise BackendLoadError(f"{self.kind} '{name}' of {provider} is not a subclass of {valid}")
        self._require_version(provider, getattr(plugin, "interface_version", None))
        return cast(Callable[[], T], plugin)()

    def load_all(self) -> dict[str, T]:
        """Import every plugin, by name.

        Raises:
            BackendError: one cannot be used.
        """
        return {name: self.load(name) for name in self.names()}

    def provider(self, name: str) -> Provider:
        """Return who provides a name.

        Raises:
            UnknownBackendError: no package does.
            DuplicateBackendError: two distributions do.
        """
        found = [provider for provider in self.providers() if provider.name == name]
        if not found and (distribution := self.distribution_with(name)):
            raise UnknownBackendError(
                f"the {self.kind} '{name}' is in {distribution}, which is not installed",
                remedy=f"scripts/setup {distribution}" if _SETUP.is_file() else f"pip install {distribution}",
            )
        if not found:
            names = self.names()
            example = "" if self.interface_version is None else ": install one, e.g. pip install nrp-core"
            hint = did_you_mean(name, names) if names else f"; none is installed{example}"
            raise UnknownBackendError(f"no {self.kind} is called '{name}'{hint}")
        if len(found) > 1:
            owners = " and ".join(map(str, found))
            raise DuplicateBackendError(
                f"two distributions provide the {self.kind} '{name}': {owners}; remove one of them",
                remedy=f"pip uninstall {found[-1].distribution}",
            )
        return found[0]

    def distribution_with(self, name: str) -> str | None:
        """Return the distribution of this project that has a plugin, installed or not; None for others."""
        return next((one for one, groups in OPTIONAL.items() if name in groups.get(self.group, ())), None)

    def _import(self, provider: Provider) -> object:
        from nrp_core._support.driver import NoMatches

        try:
            return _plugin(self.group, id(provider), provider)
        except NoMatches as error:
            raise BackendLoadError(f"{self.kind} '{provider.name}' of {provider} vanished") from error
        except Exception as error:
            if isinstance(error, ImportError) and (error.name or "").startswith("nrp_core."):
                raise IncompatibleBackendError(
                    f"{self.kind} '{provider.name}' of {provider} fits another version of nrp-core: {error}",
                    remedy=f"pip install --upgrade {provider.distribution}",
                ) from error
            raise BackendLoadError(
                f"{self.kind} '{provider.name}' of {provider} does not import: {type(error).__name__}: "
                f"{_describe(error)}",
                remedy=_reinstall(provider) if isinstance(error, ImportError) else "",
            ) from error

    def _require_version(self, provider: Provider, version: int | None) -> None:
        wanted = self.interface_version
        if wanted is None or version == wanted:
            return
        older = provider.distribution if (version or 0) < wanted else "nrp-core"
        raise IncompatibleBackendError(
            f"{self.kind} '{provider.name}' of {provider} was written for interface version {version}; "
            f"this nrp-core has version {wanted}",
            remedy=f"pip install --upgrade {older}",
        )


@lru_cache(maxsize=64)
def _providers(group: str, _state: State) -> tuple[Provider, ...]:
    """Return the plugins of a group by name."""
    found = {Provider.of(entry) for entry in entries(group)}
    return tuple(sorted(found, key=lambda p: (p.name, p.distribution)))


@lru_cache(maxsize=256)
def _plugin(group: str, _identity: int, provider: Provider) -> object:
    """Return an imported plugin, cached: a look-up takes 1 ms, and each new world makes several.

    After an installation, :func:`_providers` returns other objects, whose plugins are looked up again.
    """
    from nrp_core._support.driver import Driver

    return Driver(group, provider.name).driver


def _reinstall(provider: Provider) -> str:
    return f"pip install --force-reinstall {provider.distribution}"


def _describe(error: Exception) -> str:
    """Return the message of an error of an import, with the place to correct if there is one."""
    if isinstance(error, ImportError):
        return str(error)
    if isinstance(error, SyntaxError):
        return f"{error.msg}, at {error.filename}:{error.lineno}"
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{error}, at {last.filename}:{last.lineno}"
