"""Cells and synapses of NEST in a script of PyNN: ``sim.native_cell_type("iaf_cond_alpha")``."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_core.brain.files.sonata.models import LEAK_NS
from nrp_core.brain.network.synapses.tsodyks_markram import TSODYKS_MARKRAM
from nrp_core.errors import CapabilityError, did_you_mean
from nrp_legacy.nest.models import CELLS, SYNAPSES, defaults_of


def native_cell(sim: ModuleType, name: str) -> type:
    """Return the cell type of PyNN that a model of NEST is; it takes NEST's parameters in NEST's units.

    Raises:
        CapabilityError: there is none.
    """
    if name not in CELLS:
        raise CapabilityError(f"NEST's cell type '{name}' is not supported{did_you_mean(name, CELLS)}")
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


def native_synapse(sim: ModuleType, name: str) -> type:
    """Return the synapse type of PyNN that a model of NEST is; it takes NEST's parameters in NEST's units.

    What it has beyond ours is left out.
    """
    known = SYNAPSES.get(name, SYNAPSES["static_synapse"])

    def begin(self: Any, weight: Any = 1.0, delay: Any = None, **given: Any) -> None:
        own = {"weight": weight} | ({} if delay is None else {"delay": delay})
        if known.kind == TSODYKS_MARKRAM:
            own |= {name: given[theirs] for name, theirs in _TSODYKS if theirs in given}
        base.__init__(self, **own)

    base: Any = sim.TsodyksMarkramSynapse if known.kind == TSODYKS_MARKRAM else sim.StaticSynapse
    return type(base.__name__, (base,), {"__init__": begin})


_TSODYKS = (("U", "U"), ("tau_rec", "tau_rec"), ("tau_facil", "tau_fac"))
