"""Rules of STDP and structural plasticity that only sPyNNaker has, or parametrises in its own way."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from copy import copy
from typing import Any, Final

from pyNN.parameters import ParameterSpace

from nrp_core.clock import MS_PER_S
from nrp_core.network.pynn.arguments import (
    InvalidValueError,
    raising,
    require_kind,
    require_names,
    require_values,
)
from nrp_core.network.pynn.simulator import Simulator
from nrp_core.network.rewiring import Rewiring

# mypy: disable-error-code="misc"


class RandomSelection:
    """The source of a new synapse is any cell of any population with such a projection to the target."""

    rewiring: Final[Mapping[str, Any]] = {"partner": "RandomSelection"}


class LastNeuronSelection:
    """The source of a new synapse is a cell that fired in the previous time step.

    Args:
        spike_buffer_size: the number of spikes in a step that are remembered.
    """

    def __init__(self, spike_buffer_size: int = 64) -> None:
        self.rewiring = {"partner": "LastNeuronSelection", "spike_buffer_size": spike_buffer_size}


class DistanceDependentFormation:
    """New synapses form with a Gaussian probability of the distance on a periodic grid.

    Args:
        grid: its size.
        p_form_forward, sigma_form_forward: the probability at distance 0 and its spread.
        p_form_lateral, sigma_form_lateral: the same within one population.
    """

    def __init__(
        self, grid: Any = (16, 16), p_form_forward: float = 0.16, sigma_form_forward: float = 2.5,
        p_form_lateral: float = 1.0, sigma_form_lateral: float = 1.0,
    ) -> None:  # fmt: skip
        try:
            grid_x, grid_y = (int(size) for size in grid)  # parts are ignored, as in sPyNNaker
        except (TypeError, ValueError, OverflowError):
            raise InvalidValueError(
                f"DistanceDependentFormation: grid is {grid!r}; it must be two whole numbers"
            ) from None
        self.rewiring = {
            "grid_x": grid_x, "grid_y": grid_y, "p_form_forward": p_form_forward,
            "sigma_form_forward": sigma_form_forward, "p_form_lateral": p_form_lateral,
            "sigma_form_lateral": sigma_form_lateral,
        }  # fmt: skip


class RandomByWeightElimination:
    """Synapses vanish with one probability below a weight, and with another from there on.

    Args:
        threshold: the weight, nA or uS.
        prob_elim_depressed: the probability below it.
        prob_elim_potentiated: the probability from there on.
        mid_weight: the earlier name of the threshold.
    """

    def __init__(
        self, threshold: float | None = None, prob_elim_depressed: float = 0.0245,
        prob_elim_potentiated: float = 1.36e-4, mid_weight: float | None = None,
    ) -> None:  # fmt: skip
        threshold = mid_weight if threshold is None else threshold
        if threshold is None:
            raise InvalidValueError("RandomByWeightElimination has no default for threshold")
        self.rewiring = {
            "threshold": threshold, "prob_elim_depressed": prob_elim_depressed,
            "prob_elim_potentiated": prob_elim_potentiated,
        }  # fmt: skip


RULES: Final = (
    RandomSelection, LastNeuronSelection, DistanceDependentFormation, RandomByWeightElimination,
)  # fmt: skip
_PARTS: Final = {
    "partner_selection": ((RandomSelection, LastNeuronSelection), "sim.RandomSelection()"),
    "formation": (DistanceDependentFormation, "sim.DistanceDependentFormation()"),
    "elimination": (RandomByWeightElimination, "sim.RandomByWeightElimination(threshold=0.5)"),
}
_SETTINGS: Final = ("f_rew", "initial_weight", "initial_delay", "s_max", "with_replacement", "seed")
_STDP: Final = ("timing_dependence", "weight_dependence", "voltage_dependence", "dendritic_delay_fraction")


def structural_mechanisms(simulator: Simulator, stdp: type) -> dict[str, type]:
    """Return the synapse types whose synapses form and vanish, with constant weights and with STDP.

    Args:
        simulator: has the type of static synapses.
        stdp: sPyNNaker's type of synapses with STDP.
    """
    static = simulator.types["StaticSynapse"]
    return {
        "StructuralMechanismStatic": _mechanism("StructuralMechanismStatic", static, ()),
        "StructuralMechanismSTDP": _mechanism("StructuralMechanismSTDP", stdp, _STDP),
    }


def _mechanism(name: str, base: Any, own: tuple[str, ...]) -> type:
    order = [*_PARTS, *own, *_SETTINGS, "weight", "delay", *(["backprop_delay"] if own else [])]
    signature = inspect.Signature(
        [inspect.Parameter(each, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None) for each in order]
    )

    def begin(self: Any, *arguments: Any, **options: Any) -> None:
        require_names(name, options, order)
        given = signature.bind(*arguments, **options).arguments
        if own and given.pop("backprop_delay", None) is False:
            given["dendritic_delay_fraction"] = 0.0
        base.__init__(self, **{key: given[key] for key in (*own, "weight", "delay") if key in given})
        self.rewiring = _rewiring(name, given, _of_new_synapses(self))

    return type(name, (base,), {"__init__": begin, "__doc__": f"{base.__doc__} Synapses form and vanish."})


def _of_new_synapses(synapses: Any) -> dict[str, float]:
    """Return the parameters of the law of a synapse, without weight and delay."""
    space = synapses.parameter_space
    own = [key for key in synapses.get_parameter_names() if key not in ("weight", "delay")]
    return {key: float(space[key].base_value) for key in own}


def _rewiring(name: str, given: Mapping[str, Any], parameters: Mapping[str, float]) -> Rewiring:
    found: dict[str, Any] = {"parameters": parameters}
    for part, (kinds, example) in _PARTS.items():
        require_kind(name, part, given.get(part), kinds, f"one such as {example}")
        found |= given[part].rewiring
    settings = {key: given[key] for key in _SETTINGS if given.get(key) is not None}
    delay = settings.pop("initial_delay", None)
    if delay is not None:
        low, high = delay if isinstance(delay, (tuple, list)) and len(delay) == 2 else (delay, delay)
        settings |= {"initial_delay_low": low, "initial_delay_high": high}
    with raising(InvalidValueError):
        return Rewiring(**found, **settings)


# mypy: disable-error-code="misc"


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


def static_synapse(pynn: Any) -> type:
    """Return the type of synapses with constant weights, whose arguments may have no names.

    Args:
        pynn: the class of PyNN's ``StaticSynapse``.
    """

    def begin(self: Any, *values: Any, **given: Any) -> None:
        given |= zip(("weight", "delay", _ROOM), values, strict=False)
        given.pop(_ROOM, None)
        pynn.__init__(self, **given)

    return type("StaticSynapse", (pynn,), {"__init__": begin, "__doc__": pynn.__doc__})


_ROOM: Final = "pad_to_length"
"""An argument that makes room for synapses that are never made."""
_PAIRS: Final = ("SpikePairRule", "SpikeNearestPairRule")


def _in_pynn(timing: Any, weight: Any) -> Any:
    """Return a rule of pairs with PyNN's amplitudes.

    With an additive dependence, PyNN multiplies amplitudes by ``w_max``; sPyNNaker 7.4.1 does not
    (``weight_dependence_additive.py``).
    """
    if type(timing).__name__ not in _PAIRS or type(weight).__name__ != "AdditiveWeightDependence":
        return timing
    w_max = weight.parameter_space["w_max"].base_value
    if not w_max:  # weights stay at 0
        return timing
    given = dict(timing.parameter_space.items())
    scaled = {name: given[name].base_value / w_max for name in ("A_plus", "A_minus")}
    made = copy(timing)
    made.parameter_space = ParameterSpace({**given, **scaled}, timing.get_schema())
    return made


def stdp_mechanism(pynn: Any) -> type:
    """Return the type of synapses with STDP, with sPyNNaker's arguments and amplitudes.

    Args:
        pynn: the class of PyNN's ``STDPMechanism``.
    """

    def begin(self: Any, *arguments: Any, **given: Any) -> None:
        if given.pop("neuromodulation", False):
            raise InvalidValueError(
                "STDPMechanism: neuromodulation=True does not say how rewards act; leave it out, and make a "
                "projection of extra_models.Neuromodulation(tau_c=..., tau_d=...) with receptor_type='reward'"
            )
        given.pop(_ROOM, None)
        given.pop("mad", None)  # how version 7 read its rows
        if given.pop("backprop_delay", True) is False:
            given["dendritic_delay_fraction"] = 0.0
        pynn.__init__(self, *arguments, **given)
        amplitudes = getattr(self.weight_dependence, "amplitudes", None)
        if amplitudes is None:
            self.timing_dependence = _in_pynn(self.timing_dependence, self.weight_dependence)
        else:
            if type(self.timing_dependence).__name__ != "PfisterSpikeTripletRule":
                raise InvalidValueError(
                    "STDPMechanism: WeightDependenceAdditiveTriplet is that of PfisterSpikeTriplet; another "
                    "rule takes AdditiveWeightDependence"
                )
            self.timing_dependence.parameter_space.update(**amplitudes)

    return type("STDPMechanism", (pynn,), {"__init__": begin, "__doc__": pynn.__doc__})
