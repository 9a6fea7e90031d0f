"""PyNN's synapse types: one class for each synapse law."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, ClassVar, Final

from pyNN.parameters import LazyArray
from pyNN.standardmodels import StandardSynapseType, synapses

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.pynn.arguments import (
    InvalidValueError,
    raising,
    require_arguments,
    require_by_name,
    require_kind,
    require_names,
    require_values,
)
from nrp_core.network.pynn.models import RULE_PARTS, untranslated
from nrp_core.network.pynn.simulator import Simulator
from nrp_core.network.rewiring import MODULATORY, Neuromodulation
from nrp_core.network.synapses import LAWS, STDP, SynapseLaw

_FUNCTIONS: Final = "; a function of Python, such as lambda d: numpy.exp(-d), may use any name"
_MODULATION: Final = ("weight", *(one.name for one in fields(Neuromodulation)))
"""The arguments of synapses that reward or punish, in order."""


class SynapseType(StandardSynapseType):
    """Base of all synapse types.

    Attributes:
        kind: the name of the law in a network.
        weight, delay: from the script; a missing weight is 0, a missing delay the smallest. Synapses that
            transmit voltages have no delay.
    """

    kind: ClassVar[str]
    delay: Any = None
    # PyNN checks column by column as it connects; here each projection is checked once, as a whole
    parameter_checks: ClassVar[dict[str, Any]] = {}
    _simulator: Simulator

    def __init__(self, *args: Any, **parameters: Any) -> None:
        name, own = type(self).__name__, type(self).default_parameters
        if own:
            require_by_name(name, args, own)
            require_names(name, parameters, own)
        else:  # a rule composed of parts takes the parts' parameters
            require_arguments(name, super().__init__, parameters)
        self._require_possible(parameters)
        super().__init__(*args, **parameters)
        weight, delay = parameters.get("weight"), parameters.get("delay")
        self.weight = 0.0 if weight is None else weight
        if "delay" in own or not own:
            self.delay = self._get_minimum_delay() if delay is None else delay

    def _require_possible(self, parameters: Mapping[str, Any]) -> None:
        """Check errors that PyNN reports only later, or without a name.

        Raises:
            InvalidValueError: a string is not a function of the distance, or a fraction is not from 0 to 1.
        """
        name = type(self).__name__
        for parameter, value in parameters.items():
            if isinstance(value, (bool, type)):
                require_values(name, {parameter: value})
            if isinstance(value, str):
                try:
                    LazyArray(value)
                except Exception as error:  # noqa: BLE001 - whatever the user wrote
                    hint = _FUNCTIONS if "is not defined" in str(error) else ""
                    raise InvalidValueError(f"{name}: {parameter} is {value!r}. {error}{hint}") from None
        fraction = parameters.get("dendritic_delay_fraction", 1.0)
        if not (isinstance(fraction, (int, float)) and 0 <= fraction <= 1):
            raise InvalidValueError(
                f"{name}: dendritic_delay_fraction is {fraction!r}; it must be a number between 0 and 1"
            )

    @property
    def plasticity(self) -> Mapping[str, str]:
        """PyNN's names for the parts of a plasticity rule."""
        return {}

    def _get_minimum_delay(self) -> float:
        return self._simulator.state.default_delay

    def get_native_names(self, *names: str) -> list[str]:
        """Return the names themselves; a projection also reads state variables, which PyNN lacks."""
        return [*names] or [*self.translations]


class STDPMechanism(SynapseType, synapses.STDPMechanism):
    """Plasticity by the times of spikes, composed of a rule for times and one for weights."""

    kind = STDP

    @property
    def plasticity(self) -> Mapping[str, str]:
        parts = {"timing_dependence": self.timing_dependence, "weight_dependence": self.weight_dependence}
        return {name: type(part).__name__ for name, part in parts.items()}

    def __init__(self, *args: Any, **parameters: Any) -> None:
        for rule, kind in RULE_PARTS.items():
            valid = f"one such as sim.{LAWS[STDP].first_parts[rule]}()"
            given = {**parameters, **dict(zip(RULE_PARTS, args, strict=False))}
            require_kind("STDPMechanism", rule, given.get(rule), (kind, type(None)), valid)
        super().__init__(*args, **parameters)

    def _build_translations(self) -> None:
        if self.voltage_dependence is not None:
            raise CapabilityError("STDPMechanism: voltage dependence is not supported; leave it out")
        if self.timing_dependence is None or self.weight_dependence is None:
            raise NetworkError("STDPMechanism needs a timing_dependence and a weight_dependence")
        for name, part in LAWS[STDP].chosen_parts(list(self.plasticity.values())) or ():
            for other, needed in part.requires.items():
                if self.plasticity[other] != needed:
                    raise NetworkError(
                        f"STDPMechanism: {name} is defined with {needed}, not {self.plasticity[other]}"
                    )
        self.translations = untranslated(self.get_parameter_names())


def synapse_types() -> list[type]:
    """Return the class of every law."""
    return [STDPMechanism if law.parts else _synapse_type(law) for law in LAWS.values()]


def neuromodulation(simulator: Simulator) -> type:
    """Return the type of synapses that reward or punish; their delay is a time step.

    A projection of them onto the receptor ``reward`` or ``punishment`` decides how much STDP changes the
    weights onto the same cells. Arguments are ``weight``, the change of dopamine by a spike, and those of
    :class:`~nrp_core.network.rewiring.Neuromodulation`.
    """
    static = simulator.types["StaticSynapse"]

    def begin(self: Any, *values: Any, **given: Any) -> None:
        require_names("Neuromodulation", given, _MODULATION)
        given |= zip(_MODULATION, values, strict=False)
        static.__init__(self, weight=given.pop("weight", 0.0), delay=simulator.state.dt)
        with raising(InvalidValueError):
            self.neuromodulation = Neuromodulation(**given)

    doc = "Synapses onto ``reward`` or ``punishment``: their spikes decide on changes by STDP."
    return type("Neuromodulation", (static,), {"__init__": begin, "__doc__": doc, "receptors": MODULATORY})


def _synapse_type(law: SynapseLaw) -> type:
    """Return the class of a law, PyNN's own where it has one."""
    base = getattr(synapses, law.pynn, None)
    body: dict[str, Any] = {"kind": law.name, "__doc__": law.summary}
    if base is None:
        base = StandardSynapseType
    # floats, also where PyNN has whole numbers: it would cut off the fraction of a wrong value
    delay: dict[str, Any] = {} if law.continuous else {"delay": None}
    body["default_parameters"] = {"weight": 0.0, **delay, **law.defaults}
    body["translations"] = untranslated(body["default_parameters"])
    return type(law.pynn, (SynapseType, base), body)
