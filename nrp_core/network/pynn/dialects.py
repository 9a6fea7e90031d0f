"""Dialects of PyNN: the modules that scripts for another simulator import, over a simulator of ours.

An entry point in ``nrp_core.pynn_dialects`` has the name of a module that such scripts import, for example
``pyNN.other`` or a package. It is a :class:`Dialect`, which is loaded when a script imports the module.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any, ClassVar, Protocol

from nrp_core.network.data import Network
from nrp_core.registry import Registry


class Modules(Protocol):
    """Modules that a script finds in place of those that are installed."""

    @property
    def library_names(self) -> Mapping[str, Any]:
        """The names that replace those of PyNN's library, such as ``pyNN.random.RandomDistribution``."""

    def module(self, name: str) -> ModuleType | None:
        """Return the module of a dotted name, or None for the installed one.

        Raises:
            NrpError: this module has no equivalent.
        """

    def missing(self, name: str, importer: Mapping[str, Any]) -> ModuleType | None:
        """Return a placeholder for a module that is not installed, or None; see :meth:`module`.

        Args:
            name: its dotted name.
            importer: the variables of the module that imports it.
        """


class Dialect(Modules, Protocol):
    """The modules of another simulator, made from one of ours.

    Attributes:
        runner: the name of the :mod:`runner <nrp_core.pynn.runners>` of scripts in this dialect.
    """

    runner: ClassVar[str]

    def __init__(self, pynn: ModuleType) -> None: ...

    def network(self, variables: Mapping[str, Any]) -> Network | None:
        """Return the network that a script built without PyNN, from its variables; None if there is none."""


DIALECTS: Registry[type[Dialect]] = Registry("nrp_core.pynn_dialects", "dialect of PyNN")


class Dialects:
    """All installed dialects over one simulator, see :class:`Modules`.

    Args:
        pynn: the simulator; the modules build its network.
    """

    def __init__(self, pynn: ModuleType) -> None:
        self._pynn = pynn
        self._made: dict[type[Dialect], Dialect] = {}

    @property
    def library_names(self) -> Mapping[str, Any]:
        return vars(self._pynn)

    def module(self, name: str) -> ModuleType | None:
        dialect = self.dialect_with(name)
        return None if dialect is None else dialect.module(name)

    def missing(self, name: str, importer: Mapping[str, Any]) -> ModuleType | None:
        found = (self._dialect(each).missing(name, importer) for each in DIALECTS.names())
        return next((module for module in found if module is not None), None)

    def network(self, variables: Mapping[str, Any]) -> Network | None:
        """Return the network that a script built with modules of a dialect instead of PyNN, if it did."""
        return next(filter(None, (dialect.network(variables) for dialect in self._made.values())), None)

    def dialect_with(self, name: str) -> Dialect | None:
        """Return the dialect that has a module, or one of the packages that it is in.

        Raises:
            UnknownBackendError: the dialect is in a distribution of this project that is not installed.
        """
        installed, parts = DIALECTS.names(), name.split(".")
        packages = (".".join(parts[:count]) for count in range(1, len(parts) + 1))
        found = next((one for one in packages if one in installed or DIALECTS.distribution_with(one)), None)
        return None if found is None else self._dialect(found)

    def _dialect(self, name: str) -> Dialect:
        kind = DIALECTS.load(name)
        if kind not in self._made:
            self._made[kind] = kind(self._pynn)
        return self._made[kind]
