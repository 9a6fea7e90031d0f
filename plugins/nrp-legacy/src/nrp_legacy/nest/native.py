"""Cells and synapses of NEST in a script of PyNN: ``sim.native_cell_type("iaf_cond_alpha")``."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np
from pyNN.parameters import LazyArray

from nrp_core.brain.network.nest_models import LEAK_NS
from nrp_core.brain.network.synapses import STDP, TSODYKS_MARKRAM
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

    PyNN passes such parameters on as they are, weights in nS or pA. Those without a counterpart are left out.
    """
    known = kernel.synapse_model(name)

    def begin(self: Any, weight: Any = None, delay: Any = None, **given: Any) -> None:
        values = {**known.defaults, **given}
        sent = values["weight"] if weight is None else weight
        weight = sent * _KILO if isinstance(sent, (int, float, np.ndarray)) else LazyArray(sent) * _KILO
        own = {"weight": weight} | ({} if delay is None else {"delay": delay})
        if known.kind == TSODYKS_MARKRAM:
            own |= {name: values[theirs] for name, theirs in _TSODYKS}
        elif known.kind == STDP:
            own |= _pair_rule(sim, values)
        base.__init__(self, **own)

    base = getattr(sim, _BASES.get(known.kind, "StaticSynapse"))
    return type(base.__name__, (base,), {"__init__": begin})


def _pair_rule(sim: ModuleType, values: Mapping[str, Any]) -> dict[str, Any]:
    rate = values["lambda"]
    timing = {"tau_plus": values["tau_plus"], "A_plus": rate, "A_minus": rate * values["alpha"]}
    weight = sim.MultiplicativeWeightDependence if values["mu_plus"] else sim.AdditiveWeightDependence
    return {
        "timing_dependence": sim.SpikePairRule(**timing),
        "weight_dependence": weight(w_min=0.0, w_max=values["Wmax"] * _KILO),
    }


_KILO = 1e-3
_BASES = {TSODYKS_MARKRAM: "TsodyksMarkramSynapse", STDP: "STDPMechanism"}
_TSODYKS = (("U", "U"), ("tau_rec", "tau_rec"), ("tau_facil", "tau_fac"))
