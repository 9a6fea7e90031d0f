"""PyNN's standard models as a network holds them: PyNN's own parameter names and units."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn

from pyNN.standardmodels import ModelNotAvailable, build_translations, cells, synapses

from nrp_core.brain.pynn.arguments import require_arguments, require_names, require_values
from nrp_core.errors import CapabilityError

CELLS = (
    "IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_cond_exp", "IF_cond_alpha", "Izhikevich",
    "EIF_cond_exp_isfa_ista", "EIF_cond_alpha_isfa_ista", "HH_cond_exp",
    "SpikeSourcePoisson", "SpikeSourceArray",
)  # fmt: skip

_NEAREST = {
    "IF_cond_exp_gsfa_grr": "EIF_cond_exp_isfa_ista",
    "IF_facets_hardware1": "IF_cond_exp",
    "GIF_cond_exp": "EIF_cond_exp_isfa_ista",
    "PointNeuron": "IF_cond_exp",
    "LIF": "IF_cond_exp",
    "AdExp": "EIF_cond_exp_isfa_ista",
    "MultiCompartmentNeuron": "HH_cond_exp",
    "SpikeSourcePoissonRefractory": "SpikeSourcePoisson",
    "SpikeSourceGamma": "SpikeSourcePoisson",
    "SpikeSourceInhGamma": "SpikeSourcePoisson",
    "SimpleStochasticSynapse": "StaticSynapse",
    "ElectricalSynapse": "StaticSynapse",
    "StochasticTsodyksMarkramSynapse": "TsodyksMarkramSynapse",
    "MultiQuantalSynapse": "TsodyksMarkramSynapse",
    "AdditivePotentiationMultiplicativeDepression": "AdditiveWeightDependence",
    "GutigWeightDependence": "MultiplicativeWeightDependence",
    "Vogels2011Rule": "SpikePairRule",
}


def untranslated(names: Iterable[str]) -> dict[str, Any]:
    """Return PyNN's translation table for parameters that keep their names and units."""
    table: dict[str, Any] = build_translations(*((name, name) for name in names))
    return table


def cell_types() -> dict[str, type]:
    """Return every supported cell type."""
    return {name: _cell_type(getattr(cells, name)) for name in CELLS}


def _cell_type(base: Any) -> type:
    # PyNN lists a receptor for gap junctions in NEURON with HH_cond_exp
    receptors = tuple(name for name in base.receptor_types if name in ("excitatory", "inhibitory"))

    def begin(self: Any, **parameters: Any) -> None:
        require_names(base.__name__, parameters, base.default_parameters)
        require_values(base.__name__, parameters)
        base.__init__(self, **parameters)

    body = {"translations": untranslated(base.default_parameters), "receptor_types": receptors}
    return type(base.__name__, (base,), {"__doc__": base.__doc__, "__init__": begin, **body})


class RulePart:
    """What the parts of plasticity rules share: a check of what they are given."""

    def __init__(self, *arguments: Any, **parameters: Any) -> None:
        require_arguments(type(self).__name__, super().__init__, parameters)
        super().__init__(*arguments, **parameters)


class AdditiveWeightDependence(RulePart, synapses.AdditiveWeightDependence):
    """Weight changes that do not depend on the weight, within ``w_min`` and ``w_max``."""

    translations = untranslated(synapses.AdditiveWeightDependence.default_parameters)


class MultiplicativeWeightDependence(RulePart, synapses.MultiplicativeWeightDependence):
    """Weight changes in proportion to the distance from ``w_min`` or ``w_max``."""

    translations = untranslated(synapses.MultiplicativeWeightDependence.default_parameters)


class SpikePairRule(RulePart, synapses.SpikePairRule):
    """Weight changes by the time between pairs of spikes; time constants in ms."""

    translations = untranslated(synapses.SpikePairRule.default_parameters)


def unavailable_models() -> dict[str, type]:
    """Return a stand-in for each of PyNN's models that networks cannot hold; making one raises."""
    return {name: _unavailable(name, nearest) for name, nearest in _NEAREST.items()}


def native_model(kind: str, choices: Sequence[str]) -> Callable[[str], NoReturn]:
    """Return PyNN's function for models of one simulator, which raises: networks are for all of them.

    Args:
        kind: what the function is asked for, e.g. ``cell type``.
        choices: names of the standard models of that kind.
    """

    def refuse(name: str, *_: object, **__: object) -> NoReturn:
        alike = name.replace("psc", "curr")
        nearest = difflib.get_close_matches(alike.lower(), [choice.lower() for choice in choices], 1, 0.0)
        hint = next(choice for choice in choices if choice.lower() == nearest[0])
        raise CapabilityError(f"the {kind} '{name}' is of one simulator alone; the nearest of all is {hint}")

    return refuse


def _unavailable(name: str, nearest: str) -> type:
    def refuse(*_: object, **__: object) -> NoReturn:
        raise CapabilityError(f"{name} is not supported; the nearest that is: {nearest}")

    return type(name, (ModelNotAvailable,), {"__init__": refuse})
