"""The network equivalents of SONATA's synapse models: synapse type, parameters, plasticity rule.

Constants and defaults of ``nest:`` models come from NEST's documentation; ``nest:stdp_synapse`` is the
rule of Guetig et al. (2003, J. Neurosci. 23:3697), which with exponents of 0 or 1 is the additive or the
multiplicative pair rule.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core.brain import STATIC, STDP, TSODYKS_MARKRAM, FloatArray, IndexArray, Population
from nrp_core.errors import CapabilityError
from nrp_core.network.synapses import LAWS, SynapseLaw
from nrp_formats.sonata.items import SonataItems

Values = Callable[[str, float], FloatArray]
"""Returns an attribute of the edges by its name, or a given number for edges without it."""


@dataclass(frozen=True, slots=True)
class Chosen:
    """Some edges of one model, from cells of one type to cells of one type on one receptor.

    Args:
        owner: the owner of the edges, for messages.
        values: returns attributes of the edges.
        target: the postsynaptic cells.
        post_index: indices of the postsynaptic cells, shape ``(n,)``.
        tau_minus: ``tau_minus`` of the postsynaptic cells, ms, NaN if they have none; shape ``(n,)``.
        receptor: ``excitatory`` or ``inhibitory``.
        weight_scale: the factor from the file's unit to PyNN's, times the number of synapses of an edge;
            shape ``(n,)``.
    """

    owner: str
    values: Values
    target: Population
    post_index: IndexArray
    tau_minus: FloatArray
    receptor: str
    weight_scale: FloatArray


@dataclass(frozen=True, slots=True)
class Synapses:
    """The arguments of a :class:`~nrp_core.network.data.Projection` that describe its synapses."""

    synapse_type: str = STATIC
    synapse_parameters: Mapping[str, FloatArray] = field(default_factory=dict)
    plasticity: Mapping[str, str] = field(default_factory=dict)


def _as_in_pynn(law: SynapseLaw) -> Callable[[Chosen], Synapses]:
    """Return a function that makes synapses of a law from attributes under PyNN's names."""

    def synapses(chosen: Chosen) -> Synapses:
        named = {name: chosen.values(name, default) for name, default in law.defaults.items()}
        return Synapses(law.name, named)

    return synapses


def _tsodyks(chosen: Chosen) -> Synapses:
    tau_psc, values = chosen.values("tau_psc", 3.0), chosen.values
    name = "tau_syn_E" if chosen.receptor == "excitatory" else "tau_syn_I"
    taus = chosen.target.parameters.get(name, np.zeros(chosen.target.size))[chosen.post_index]
    wrong = np.abs(tau_psc - taus) > 1e-9
    if wrong.any():
        edge = int(np.argmax(wrong))
        raise CapabilityError(
            f"{chosen.owner}: tau_psc of nest:tsodyks_synapse is {tau_psc[edge]:g} ms and the time constant "
            f"of the synapses of '{chosen.target.label}' {taus[edge]:g} ms; networks have one number for both"
        )
    names = {"U": values("U", 0.5), "tau_rec": values("tau_rec", 800.0), "tau_facil": values("tau_fac", 0.0)}
    return Synapses(TSODYKS_MARKRAM, names)


def _stdp(chosen: Chosen) -> Synapses:
    values = chosen.values
    exponents = np.unique(np.concatenate([values("mu_plus", 1.0), values("mu_minus", 1.0)]))
    if len(exponents) != 1 or exponents[0] not in (0.0, 1.0):
        raise CapabilityError(
            f"{chosen.owner}: mu_plus and mu_minus of nest:stdp_synapse are "
            f"{', '.join(f'{e:g}' for e in exponents)}; the nearest rules are additive (both 0) and "
            "multiplicative (both 1)"
        )
    rate = values("lambda", 0.01)
    limit = values("Wmax", 100.0) * chosen.weight_scale
    tau_minus = np.where(np.isnan(chosen.tau_minus), 20.0, chosen.tau_minus)
    rule = {
        "A_plus": rate, "A_minus": rate * values("alpha", 1.0), "tau_plus": values("tau_plus", 20.0),
        "tau_minus": tau_minus, "w_min": np.zeros(len(rate)), "w_max": limit,
        "dendritic_delay_fraction": np.ones(len(rate)),
    }  # fmt: skip
    dependence = "Multiplicative" if exponents[0] else "Additive"
    return Synapses(STDP, rule, {"timing": "SpikePairRule", "weight": f"{dependence}WeightDependence"})


_MODELS: Final[Mapping[str, Callable[[Chosen], Synapses]]] = {
    "static_synapse": _as_in_pynn(LAWS[STATIC]),
    **{law.pynn: _as_in_pynn(law) for law in LAWS.values() if not (law.parts or law.continuous)},
    "tsodyks_synapse": _tsodyks,
    "stdp_synapse": _stdp,
}

_NAMES_OF: Final[Mapping[str, frozenset[str]]] = {
    "static_synapse": frozenset(),
    **{law.pynn: frozenset(law.defaults) for law in LAWS.values() if not (law.parts or law.continuous)},
    "tsodyks_synapse": frozenset({"U", "tau_rec", "tau_fac", "tau_psc"}),
    "stdp_synapse": frozenset({"lambda", "alpha", "mu_plus", "mu_minus", "tau_plus", "Wmax"}),
}
"""The attributes of edges that each model uses, besides those of all."""
MODEL_NAMES: Final = frozenset().union(*_NAMES_OF.values())
"""The attributes of edges that a model of synapses uses."""


def unused_of_synapses(items: SonataItems) -> Iterator[str]:
    """Yield a sentence for each attribute of edges that only other models of synapses use."""
    models = {text.rpartition(":")[2] or "static_synapse" for text in items.texts("model_template").values()}
    used = frozenset().union(*(_NAMES_OF[name] for name in models))
    for name in sorted((items.names() & MODEL_NAMES) - used):
        of = ", ".join(sorted(models))
        yield f"'{name}' of the edges '{items.name}' is not used: {of} has no such parameter"


def models_of(
    items: SonataItems,
) -> Iterator[tuple[str, Callable[[Chosen], Synapses], npt.NDArray[np.bool_]]]:
    """Yield the name of each model among edges, the function that makes its synapses, and its edges.

    Raises:
        CapabilityError: a model is not supported; the message names the nearest.
    """
    types: dict[str, list[int]] = {}
    for number, template in items.texts("model_template").items():
        name = template.rpartition(":")[2] or "static_synapse"
        if name not in _MODELS:
            nearest = difflib.get_close_matches(name, list(_MODELS), 1, 0.0)[0]
            raise CapabilityError(
                f"edge type {number} of '{items.name}' is of model '{template}', which is not "
                f"supported; the nearest supported model: {nearest}"
            )
        types.setdefault(name, []).append(number)
    for name, numbers in types.items():
        yield name, _MODELS[name], np.isin(items.type_ids, numbers)
