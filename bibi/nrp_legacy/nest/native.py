"""Cells and synapses of NEST in a script of PyNN: ``sim.native_cell_type("iaf_cond_alpha")``."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from nrp_core.brain.files.sonata.models import LEAK_NS
from nrp_core.brain.network.synapses.tsodyks_markram import TSODYKS_MARKRAM
from nrp_core.errors import CapabilityError, did_you_mean
from nrp_legacy.nest.kernel import Kernel
from nrp_legacy.nest.models import CELLS, defaults_of


def native_cell(sim: ModuleType, name: str, kernel: Kernel) -> type:
    """Return the PyNN cell type for a model of NEST; its parameters are NEST's, in NEST's units.

    Args:
        sim: the simulator of PyNN.
        name: of the model, or of a copy of one (``CopyModel``).
        kernel: knows the copies.

    Raises:
        CapabilityError: there is none.
    """
    original, defaults = kernel.copies.get(name, (name, {}))
    if original not in CELLS:
        raise CapabilityError(f"NEST's cell type '{name}' is not supported{did_you_mean(name, CELLS)}")
    model, base = CELLS[original], getattr(sim, CELLS[original].cell_type)

    def begin(self: Any, **given: Any) -> None:
        values = {**defaults_of(original), **defaults, **given}
        ours = {
            own: values[theirs.name] * theirs.scale
            for own, theirs in model.parameters.items()
            if theirs.name in values
        }
        if original in LEAK_NS:
            ours["tau_m"] = values["C_m"] / values["g_L"]
        base.__init__(self, **ours)

    return type(base.__name__, (base,), {"__init__": begin})


def native_synapse(sim: ModuleType, name: str, kernel: Kernel) -> type:
    """Return the PyNN synapse type for a model of NEST; its parameters are NEST's, in NEST's units.

    Parameters without a counterpart are left out.
    """
    known = kernel.synapse_model(name)

    def begin(self: Any, weight: Any = 1.0, delay: Any = None, **given: Any) -> None:
        own = {"weight": weight} | ({} if delay is None else {"delay": delay})
        if known.kind == TSODYKS_MARKRAM:
            values = {**known.defaults, **given}
            own |= {name: values[theirs] for name, theirs in _TSODYKS}
        base.__init__(self, **own)

    base: Any = sim.TsodyksMarkramSynapse if known.kind == TSODYKS_MARKRAM else sim.StaticSynapse
    return type(base.__name__, (base,), {"__init__": begin})


_TSODYKS = (("U", "U"), ("tau_rec", "tau_rec"), ("tau_facil", "tau_fac"))
