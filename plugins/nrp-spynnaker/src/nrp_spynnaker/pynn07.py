"""Spellings of PyNN 0.7, in which scripts until about 2018 are written, for the classes of a simulator.

Weights and delays belonged to the connector, amplitudes of plasticity to the rule for weights, and a
projection had a ``target`` and ``synapse_dynamics``. Each function returns a class of today that takes these,
too.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from pyNN.random import AbstractRNG

from nrp_core.network.pynn.arguments import InvalidSynapseError, InvalidValueError, WrongKindError

CONNECTORS: Final = (
    "AllToAllConnector", "DistanceDependentProbabilityConnector", "FixedTotalNumberConnector",
    "SmallWorldConnector", "FixedNumberPostConnector", "FixedNumberPreConnector", "FixedProbabilityConnector",
    "OneToOneConnector",
)  # fmt: skip
"""The connectors that had weights and delays."""
_OWN: Final = {
    "OneToOneConnector": 0, "AllToAllConnector": 0, "FixedProbabilityConnector": 1,
    "FixedNumberPreConnector": 1, "FixedNumberPostConnector": 1, "DistanceDependentProbabilityConnector": 1,
    "FixedTotalNumberConnector": 1,
}  # fmt: skip
"""How many arguments without a name a connector has before those of weights and delays.

In PyNN 0.7 ``allow_self_connections`` comes between them, in sPyNNaker 7 it comes last.
"""
_LIMITS: Final = ("low", "high")
_CONSTRAINED: Final = {"redraw": "normal_clipped", "clip": "normal_clipped_to_boundary"}
"""What a normal distribution with ``boundaries`` is called, by its ``constrain``."""


@dataclass(frozen=True, slots=True)
class TsodyksMarkramMechanism:
    """Short-term plasticity, without weight and delay, which belonged to the connector."""

    U: float = 0.5
    tau_rec: float = 100.0
    tau_facil: float = 0.0
    u0: float = 0.0
    x0: float = 1.0
    y0: float = 0.0


@dataclass(frozen=True, slots=True)
class SynapseDynamics:
    """The dynamics of a synapse; if both are given, the slow one is used."""

    fast: TsodyksMarkramMechanism | None = None
    slow: Any = None


def distribution(today: type) -> type:
    """Return distributions whose limits may come in any order, and that take ``boundaries``."""

    class RandomDistribution(today):
        def __init__(
            self, distribution: str = "uniform", parameters_pos: Any = None, rng: Any = None,
            boundaries: Any = None, constrain: str = "clip", *, parameters: Any = None, **named: Any,
        ) -> None:  # fmt: skip
            parameters_pos = parameters if parameters_pos is None else parameters_pos
            if distribution == "uniform":
                if parameters_pos is not None and len(parameters_pos) == len(_LIMITS):
                    parameters_pos = sorted(parameters_pos)
                if named.keys() >= set(_LIMITS):
                    named |= zip(_LIMITS, sorted(named[limit] for limit in _LIMITS), strict=True)
                if boundaries is not None and _contain(boundaries, parameters_pos or named.values()):
                    boundaries = None
            if boundaries is not None:
                distribution = _within(distribution, constrain)
                named |= zip(_LIMITS, boundaries, strict=True)
                if parameters_pos is not None:
                    named |= zip(("mu", "sigma"), parameters_pos, strict=True)
                    parameters_pos = None
            super().__init__(distribution, parameters_pos, rng, **named)

    return RandomDistribution


def _contain(boundaries: Any, limits: Iterable[float]) -> bool:
    low, high = sorted(boundaries)
    return all(low <= limit <= high for limit in limits)


def _within(name: str, constrain: str) -> str:
    """Return the name of a distribution within boundaries."""
    if name != "normal" or constrain not in _CONSTRAINED:
        raise InvalidValueError(
            f"the distribution '{name}' takes no boundaries with constrain={constrain!r}; a normal one does, "
            f"with {' or '.join(map(repr, _CONSTRAINED))}"
        )
    return _CONSTRAINED[constrain]


def mechanism(today: type) -> type:
    """Return STDP whose rule for weights may have the amplitudes."""

    class STDPMechanism(today):
        def __init__(
            self, timing_dependence: Any = None, weight_dependence: Any = None, *values: Any, **more: Any
        ) -> None:
            amplitudes = getattr(weight_dependence, "of_timing", {})
            for name, value in amplitudes.items():
                timing_dependence.parameter_space[name] = value
            self.of_mechanism = {
                "timing_dependence": timing_dependence, "weight_dependence": weight_dependence, **more
            }  # fmt: skip
            super().__init__(timing_dependence, weight_dependence, *values, **more)

    return STDPMechanism


def dependence(today: type) -> type:
    """Return a weight dependence with the amplitudes, which now belong to the timing."""

    class Dependence(today):
        def __init__(self, *values: Any, A_plus: Any = None, A_minus: Any = None, **more: Any) -> None:  # noqa: N803
            given = {"A_plus": A_plus, "A_minus": A_minus}
            self.of_timing = {name: value for name, value in given.items() if value is not None}
            super().__init__(*values, **more)

    return _named_as(today, Dependence)


def connector(today: type) -> type:
    """Return a connector with weights and delays."""
    own = _OWN.get(today.__name__)

    class Connector(today):
        def __init__(
            self, *values: Any, weights: Any = None, delays: Any = None, verbose: bool = False, **more: Any
        ) -> None:
            if own is not None:
                place = own + 1
                if _are_generators(values[place : place + 1]):
                    more["rng"], values = values[place], (*values[:place], *values[place + 1 :])
                values, given = _divided(values, own)
                weights, delays = (*given, *(weights, delays)[len(given) :])
            super().__init__(*values, **more)
            each = (("weight", weights), ("delay", delays))
            self.of_synapses = {name: _of_distance(value) for name, value in each if value is not None}

    return _named_as(today, Connector)


def _divided(values: tuple[Any, ...], own: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return the arguments of a connector that it has today, and its weights and delays."""
    for place in (own, own + 1):
        if _are_weights(values[place:]):
            itself = values[place + 2 : place + 3]
            today = itself if itself and isinstance(itself[0], bool) else ()
            return (*values[:place], *today), values[place : place + 2]
    return values, ()


def _are_weights(values: tuple[Any, ...]) -> bool:
    """Return whether arguments are weights and delays, instead of today's arguments of connectors."""
    return bool(values) and not isinstance(values[0], (bool, str, type(None)))


def _are_generators(values: tuple[Any, ...]) -> bool:
    """Return whether a generator is given in the place of the weights, as in PyNN 0.8 to 0.10."""
    return any(isinstance(value, AbstractRNG) for value in values)


def _of_distance(value: Any) -> Any:
    """Return a weight or delay; an expression of the distance ``d`` becomes a function with NumPy's names."""
    return eval(f"lambda d: {value}", dict(vars(np))) if isinstance(value, str) else value


def projection(today: type, types: Mapping[str, Any], noticed: Callable[[], None] = lambda: None) -> type:
    """Return projections with ``target`` and ``synapse_dynamics``.

    Args:
        today: the class of projections.
        types: the classes of the simulator.
        noticed: is called if a script has used one of these spellings.
    """

    class Projection(today):
        def __init__(
            self, presynaptic_population: Any, postsynaptic_population: Any, connector: Any = None,
            synapse_type: Any = None, *values: Any, target: str | None = None,
            synapse_dynamics: SynapseDynamics | None = None, rng: Any = None, **more: Any,
        ) -> None:  # fmt: skip
            if rng is not None and hasattr(connector, "rng"):
                connector.rng = rng
            given = getattr(connector, "of_synapses", {})
            if given or target is not None or synapse_dynamics is not None:
                noticed()
            if synapse_type is None and (given or synapse_dynamics is not None):
                synapse_type = _synapse(types, given, synapse_dynamics)
            elif given:
                raise InvalidSynapseError(
                    f"a projection has weights or delays of its {type(connector).__name__} and a synapse "
                    f"type, {type(synapse_type).__name__}; give both to the synapse type, as weight and delay"
                )
            if target is not None:
                more["receptor_type"] = target
            super().__init__(
                presynaptic_population, postsynaptic_population, connector, synapse_type, *values, **more
            )

    return _named_as(today, Projection)


def _synapse(types: Mapping[str, Any], given: Mapping[str, Any], dynamics: SynapseDynamics | None) -> Any:
    if dynamics is not None and dynamics.slow is not None:
        return types["STDPMechanism"](**{**dynamics.slow.of_mechanism, **given})
    if dynamics is None or dynamics.fast is None:
        return types["StaticSynapse"](**given)
    fast = dynamics.fast
    return types["TsodyksMarkramSynapse"](U=fast.U, tau_rec=fast.tau_rec, tau_facil=fast.tau_facil, **given)


def by_name(today: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that takes keywords, a name and a value, or a dictionary."""

    def method(self: Any, *old: Any, **values: Any) -> Any:
        match old:
            case ():
                given: Mapping[str, Any] = {}
            case (str() as name, value):
                given = {name: value}
            case (Mapping() as given,):
                pass
            case _:
                raise WrongKindError(
                    f"parameters are given by name and value, in a dictionary or by keyword, not {old!r:.60}"
                )
        return today(self, **{**given, **values})

    return method


def _named_as(today: type, kind: type) -> type:
    kind.__name__ = kind.__qualname__ = today.__name__
    kind.__doc__ = today.__doc__
    return kind
