"""Cells of NEST in a script of PyNN: ``sim.native_cell_type("iaf_cond_alpha")``."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_core.brain.sonata.models import LEAK_NS
from nrp_core.errors import CapabilityError, did_you_mean
from nrp_legacy.nest.models import CELLS, defaults_of


def native_cell(sim: ModuleType, name: str) -> type:
    """Return the cell type of PyNN that a model of NEST is; it takes NEST's parameters in NEST's units.

    Raises:
        CapabilityError: there is none.
    """
    if name not in CELLS:
        raise CapabilityError(f"the cell type '{name}' of NEST is not known{did_you_mean(name, CELLS)}")
    model, base = CELLS[name], getattr(sim, CELLS[name].cell_type)

    def begin(self: Any, **given: Any) -> None:
        values = {**defaults_of(name), **given}
        ours = {
            own: values[theirs.name] * theirs.scale
            for own, theirs in model.parameters.items()
            if theirs.name in values
        }
        if name in LEAK_NS:
            ours["tau_m"] = values["C_m"] / values["g_L"]
        base.__init__(self, **ours)

    return type(base.__name__, (base,), {"__init__": begin})
