"""The module ``brian2`` in scripts of PyNN: it is refused with the key that runs such a script."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any, ClassVar

from nrp_core.brain import Network
from nrp_core.errors import CapabilityError


class Dialect:
    """Refuses scripts of Brian2 where a network for any backend is read."""

    runner: ClassVar[str] = ""

    def __init__(self, pynn: ModuleType) -> None:
        self._pynn = pynn

    @property
    def library_names(self) -> Mapping[str, Any]:
        """The names of PyNN's library, unchanged."""
        return vars(self._pynn)

    def module(self, name: str) -> ModuleType | None:
        """Refuse ``brian2``.

        Raises:
            CapabilityError: always.
        """
        raise CapabilityError(
            f"'{name}': a script of Brian2 runs only in Brian2; write 'backend: brian2' and 'native: true' "
            "in the section 'brain'"
        )

    def missing(self, _name: str, _importer: Mapping[str, Any]) -> ModuleType | None:
        """Return None: other modules are the script's own affair."""
        return None

    def network(self, _variables: Mapping[str, Any]) -> Network | None:
        """Return None: no network is built in this way."""
        return None
