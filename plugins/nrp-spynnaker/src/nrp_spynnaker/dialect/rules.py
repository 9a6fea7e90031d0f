"""Plasticity rules that only sPyNNaker has, or parametrises in its own way."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from nrp_core.brain.pynn.arguments import require_names, require_values
from nrp_core.brain.pynn.invalid import InvalidValueError
from nrp_core.clock import MS_PER_S

_VOGELS: Final[Mapping[str, Any]] = {"alpha": None, "tau": 20.0, "A_plus": 0.01, "A_minus": 0.01}
"""Its parameters in order; ``alpha`` has no default, and ``A_minus`` no effect."""


def vogels_rule(pynn: Any) -> type:
    """Return the rule of Vogels et al. (2011, Science 334:1569) with sPyNNaker's parameters.

    Args:
        pynn: the class of PyNN's ``Vogels2011Rule``.
    """

    def begin(self: Any, *values: Any, **given: Any) -> None:
        given |= zip(_VOGELS, values, strict=False)
        require_names("Vogels2011Rule", given, _VOGELS)
        own = {**_VOGELS, **given}
        require_values("Vogels2011Rule", own)
        if own["tau"] <= 0:
            raise InvalidValueError(f"Vogels2011Rule: tau is {own['tau']!r}; it must be more than 0")
        pynn.__init__(self, tau=own["tau"], eta=own["A_plus"], rho=own["alpha"] / (2 * own["tau"]) * MS_PER_S)

    doc = (
        "Each pair of spikes strengthens by ``A_plus``, each spike of the source weakens by ``alpha A_plus``."
    )
    return type("Vogels2011Rule", (pynn,), {"__init__": begin, "__doc__": doc})


def nearest_pair_rule(pairs: Any) -> type:
    """Return the rule of the nearest pairs of spikes, with the parameters of that of all pairs.

    Args:
        pairs: the class of PyNN's ``SpikePairRule``.
    """
    return type(
        "SpikeNearestPairRule", (pairs,), {"__doc__": "Weight changes by the nearest pairs of spikes."}
    )


def triplet_rule(timing: Any, additive: Any) -> tuple[type, type]:
    """Return the rule of Pfister & Gerstner (2006, J Neurosci 26:9673), and its weight dependence.

    Args:
        timing: the class of PyNN's ``PfisterSpikeTripletRule``, which has all amplitudes.
        additive: the class of ``AdditiveWeightDependence``.
    """
    times = ("tau_plus", "tau_minus", "tau_x", "tau_y", "A_plus", "A_minus")
    weights = {"w_min": 0.0, "w_max": 1.0, "A3_plus": 0.01, "A3_minus": 0.01}

    def begin(self: Any, *values: Any, **given: Any) -> None:
        given |= zip(times, values, strict=False)
        require_names("PfisterSpikeTriplet", given, times)
        missing = [name for name in times if name not in given]
        if missing:
            raise InvalidValueError(f"PfisterSpikeTriplet has no default for {', '.join(missing)}")
        timing.__init__(self, **given)

    def begin_weights(self: Any, *values: Any, **given: Any) -> None:
        given |= zip(weights, values, strict=False)
        require_names("WeightDependenceAdditiveTriplet", given, weights)
        own = {**weights, **given}
        self.amplitudes = {name: own.pop(name) for name in ("A3_plus", "A3_minus")}
        additive.__init__(self, **own)

    return (
        # a network has PyNN's names of the rules
        type("PfisterSpikeTripletRule", (timing,), {"__init__": begin, "__doc__": timing.__doc__}),
        type(
            "AdditiveWeightDependence", (additive,), {"__init__": begin_weights, "__doc__": additive.__doc__}
        ),
    )


def stdp_mechanism(pynn: Any) -> type:
    """Return the type of synapses with STDP, with sPyNNaker's arguments.

    Args:
        pynn: the class of PyNN's ``STDPMechanism``.
    """

    def begin(self: Any, *arguments: Any, **given: Any) -> None:
        if given.pop("neuromodulation", False):
            raise InvalidValueError(
                "STDPMechanism: neuromodulation=True does not say how rewards act; leave it out, and make a "
                "projection of extra_models.Neuromodulation(tau_c=..., tau_d=...) with receptor_type='reward'"
            )
        given.pop("pad_to_length", None)  # room for synapses that are never made
        given.pop("mad", None)  # how version 7 read its rows
        if given.pop("backprop_delay", True) is False:
            given["dendritic_delay_fraction"] = 0.0
        pynn.__init__(self, *arguments, **given)
        amplitudes = getattr(self.weight_dependence, "amplitudes", None)
        if amplitudes is not None:
            if type(self.timing_dependence).__name__ != "PfisterSpikeTripletRule":
                raise InvalidValueError(
                    "STDPMechanism: WeightDependenceAdditiveTriplet is that of PfisterSpikeTriplet; another "
                    "rule takes AdditiveWeightDependence"
                )
            self.timing_dependence.parameter_space.update(**amplitudes)
            self.parameter_space.update(**amplitudes)

    return type("STDPMechanism", (pynn,), {"__init__": begin, "__doc__": pynn.__doc__})
