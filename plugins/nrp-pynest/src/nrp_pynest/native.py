"""NEST in a script of PyNN: ``sim.native_cell_type("iaf_cond_alpha")``, and connectors that call NEST."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import ModuleType
from typing import Any

import numpy as np
from pyNN.parameters import LazyArray

from nrp_core.errors import CapabilityError, did_you_mean
from nrp_core.network.nest_models import LEAK_NS
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM
from nrp_pynest.cerebellum import CEREBELLAR, cerebellar_cell
from nrp_pynest.kernel import Kernel
from nrp_pynest.models import PARROT, STANDARD, defaults_of

_LAWS = (("TsodyksMarkramSynapse", "tsodyks_synapse"), ("STDPMechanism", "stdp_synapse"))


class ProjectionModel(str):  # noqa: SLOT000 - few of them are made
    """``projection.nest_synapse_model``: the name of NEST's model, which knows its projection.

    Args:
        name: the name in NEST.
        projection: the projection.
        listed: returns the connector of pairs of indices.
    """

    _projection: Any
    _listed: Callable[[list[tuple[int, int]]], Any]

    def __new__(
        cls, name: str, projection: Any, listed: Callable[[list[tuple[int, int]]], Any]
    ) -> ProjectionModel:
        made = super().__new__(cls, name)
        made._projection, made._listed = projection, listed
        return made

    def connect(self, pre: Iterable[Any], post: Iterable[Any], rule: Any) -> None:
        """Add synapses to the projection, with the weights, delays and law of its synapse type.

        Args:
            pre: cells of the first population.
            post: cells of the second population.
            rule: as ``nest.Connect`` takes it.

        Raises:
            CapabilityError: the rule is another one than one-to-one and all-to-all.
        """
        of = self._projection
        sources = [int(of.pre.id_to_index(cell)) for cell in pre]
        targets = [int(of.post.id_to_index(cell)) for cell in post]
        name = rule.get("rule") if isinstance(rule, Mapping) else rule
        if name == "one_to_one" and len(sources) == len(targets):
            pairs = list(zip(sources, targets, strict=True))
        elif name in (None, "all_to_all"):
            pairs = [(i, j) for j in targets for i in sources]
        else:
            raise CapabilityError(
                f"nest.Connect of {len(sources)} and {len(targets)} cells of a projection takes the rules "
                f"one_to_one (as many cells on both sides) and all_to_all, not '{name}'"
            )
        self._listed(pairs).connect(of)


def synapse_model_of(projection: Any, sim: Any) -> ProjectionModel:
    """Return ``nest_synapse_model`` of a projection."""
    kind = projection.synapse_type
    name = next((theirs for own, theirs in _LAWS if isinstance(kind, getattr(sim, own))), "static_synapse")
    return ProjectionModel(name, projection, sim.FromListConnector)


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
    if original in CEREBELLAR:
        return cerebellar_cell(sim, original)
    if original not in STANDARD:
        hint = did_you_mean(name, [*STANDARD, *CEREBELLAR])
        raise CapabilityError(f"NEST's cell type '{name}' is not supported{hint}")
    model, base = STANDARD[original], getattr(sim, STANDARD[original].cell_type)

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

    kept = {"injectable": False} if original == PARROT else {}
    return type(base.__name__, (base,), {"__init__": begin, **kept})


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
