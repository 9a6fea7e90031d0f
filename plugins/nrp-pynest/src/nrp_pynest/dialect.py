"""The modules ``nest`` and ``nest.*`` for scripts, found by the door for dialects of PyNN."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any, ClassVar

from nrp_core.brain import Network
from nrp_pynest.api import nest_module
from nrp_pynest.currents import injected
from nrp_pynest.kernel import Kernel
from nrp_pynest.network import Conversion


class Dialect:
    """The module ``nest`` of a script.

    Args:
        pynn: the simulator of PyNN in the same script.
        nest: the module, by default one that only builds a network.
    """

    runner: ClassVar[str] = "nest"

    def __init__(self, pynn: ModuleType, nest: ModuleType | None = None) -> None:
        self._pynn, self._kernel = pynn, None
        if nest is None:
            self._kernel = Kernel(pynn.state.stream("nest"))
            nest = nest_module(self._kernel)
        self._nest = nest

    @property
    def library_names(self) -> Mapping[str, Any]:
        """The names of PyNN's library, unchanged."""
        return vars(self._pynn)

    def module(self, name: str) -> ModuleType | None:
        """Return ``nest`` or a module in it; None if the name is not NEST's."""
        first, *rest = name.split(".")
        found: Any = self._nest if first == "nest" else None
        for part in rest if found is not None else ():
            found = vars(found).get(part)
            if not isinstance(found, ModuleType):
                return None
        return found if isinstance(found, ModuleType) else None

    def missing(self, _name: str, _importer: Mapping[str, Any]) -> ModuleType | None:
        """Return None: other modules are the script's own affair."""
        return None

    def network(self, variables: Mapping[str, Any]) -> Network | None:
        """Return the network that calls of NEST built; None if there were none."""
        if self._kernel is None or not self._kernel.groups:
            return None
        made = Conversion(self._kernel)
        return replace(made.network, views=made.views(variables), currents=tuple(injected(made)))
