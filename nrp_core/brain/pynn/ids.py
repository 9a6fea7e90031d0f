"""One cell of a population, which is also its global id."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

from pyNN import common

from nrp_core.brain.pynn.arguments import UnknownParameterError


class ID(int, common.IDMixin):
    """A cell of PyNN."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name != "parent" and not hasattr(type(self), name):
            self.parent._require([name])
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        """Return a parameter; an attribute of populations is refused: one cell was given in place of some."""
        if name in ("parent", "set") or name.startswith("_"):
            return super().__getattr__(name)
        if name in vars(self.parent) or hasattr(type(self.parent), name):
            place = self.parent.id_to_index(self)
            label = self.parent.label
            raise UnknownParameterError(
                f"this is one cell of '{label}', which has no '{name}'; a slice is a view of it: "
                f"[{place}:{place + 1}]"
            )
        return super().__getattr__(name)
