"""``nrp.config.brain_root`` and ``nrp.brain``: the variables of the brain file."""

from __future__ import annotations

from typing import Any

from nrp_core.brain.network.data import Network
from nrp_core.dsl import brain as any_brain
from nrp_core.dsl.selection.selectors import Selector
from nrp_legacy.live.built import built_of
from nrp_legacy.live.cells import Cells

_NOTHING = object()


class BrainRoot:
    """The module of the brain file; changes of its cells and synapses change the running brain.

    Args:
        network: the network that the file has built, None if it is not known yet.
    """

    def __init__(self, network: Network | None) -> None:
        self._network = network
        self._built = None if network is None else built_of(network)

    def __deepcopy__(self, memo: object) -> BrainRoot:
        """Return the root itself, so that variables are not copies."""
        return self

    def __getattr__(self, name: str) -> Any:
        if name[:2] == "__":
            raise AttributeError(name)
        found = self.found(name)
        return getattr(any_brain, name) if found is _NOTHING else found

    def found(self, name: str) -> Any:
        """Return the neurons of this name, otherwise the value of the file's variable."""
        network, built = self._network, self._built
        if network is None or built is None:
            return _NOTHING
        if name in network.views or name in network.populations:
            return Cells(built, f"brain.{name}", network.neurons(name))
        if name in built.variables:
            return built.show(built.variables[name], f"brain.{name}")
        return _NOTHING


class Brain(Selector):
    """The object ``nrp.brain``: its attributes are selectors, or values of variables of the brain file.

    Args:
        root: holds the variables.
    """

    __slots__ = ("_root",)

    def __init__(self, root: Any) -> None:
        super().__init__(any_brain._find, repr(any_brain))
        self._root = root

    def __getattr__(self, name: str) -> Any:
        held = self._root.found(name) if isinstance(self._root, BrainRoot) else _NOTHING
        return super().__getattr__(name) if held is _NOTHING or isinstance(held, Cells) else held
