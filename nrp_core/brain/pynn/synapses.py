"""PyNN's synapse types: static, Tsodyks-Markram, and spike-pair plasticity."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from pyNN.parameters import LazyArray
from pyNN.standardmodels import (
    StandardSynapseType,
    STDPTimingDependence,
    STDPWeightDependence,
    synapses,
)

from nrp_core.brain.network.data import STATIC, STDP, TSODYKS_MARKRAM
from nrp_core.brain.pynn.arguments import require_arguments, require_kind, require_names
from nrp_core.brain.pynn.invalid import InvalidValueError
from nrp_core.brain.pynn.models import untranslated
from nrp_core.errors import CapabilityError, NetworkError

if TYPE_CHECKING:
    from nrp_core.brain.pynn.simulator import Simulator


_RULES = {
    "timing_dependence": (STDPTimingDependence, "SpikePairRule"),
    "weight_dependence": (STDPWeightDependence, "AdditiveWeightDependence"),
}


class SynapseType(StandardSynapseType):
    """What all synapse types share.

    Attributes:
        kind: what a network calls it.
        given: the weight and delay as the script gave them; a missing delay is the smallest.
    """

    kind: ClassVar[str]
    # PyNN checks column by column as it connects; here each projection is checked once, as a whole
    parameter_checks: ClassVar[dict[str, Any]] = {}
    _simulator: Simulator

    def __init__(self, *args: Any, **parameters: Any) -> None:
        name, own = type(self).__name__, type(self).default_parameters
        if own:
            require_names(name, parameters, own)
        else:  # a rule made of parts takes the parts
            require_arguments(name, super().__init__, parameters)
        self._require_possible(parameters)
        super().__init__(*args, **parameters)
        weight, delay = parameters.get("weight"), parameters.get("delay")
        self.given = {
            "weight": 0.0 if weight is None else weight,
            "delay": self._get_minimum_delay() if delay is None else delay,
        }

    def _require_possible(self, parameters: Mapping[str, Any]) -> None:
        """Check what PyNN finds only later, or says without a name.

        Raises:
            InvalidValueError: a text is no function of the distance, or a fraction no number from 0 to 1.
        """
        name = type(self).__name__
        for parameter, value in parameters.items():
            if isinstance(value, str):
                try:
                    LazyArray(value)
                except Exception as error:  # noqa: BLE001 - whatever the user wrote
                    raise InvalidValueError(f"{name}: {parameter} is {value!r}. {error}") from None
        fraction = parameters.get("dendritic_delay_fraction", 1.0)
        if not (isinstance(fraction, (int, float)) and 0 <= fraction <= 1):
            raise InvalidValueError(
                f"{name}: dendritic_delay_fraction is {fraction!r}; it must be a number between 0 and 1"
            )

    @property
    def plasticity(self) -> Mapping[str, str]:
        """PyNN's names of the parts of a plasticity rule."""
        return {}

    def _get_minimum_delay(self) -> float:
        return self._simulator.state.default_delay


class StaticSynapse(SynapseType, synapses.StaticSynapse):
    """A weight and a delay (ms) that stay."""

    kind = STATIC
    translations = untranslated(synapses.StaticSynapse.default_parameters)


class TsodyksMarkramSynapse(SynapseType, synapses.TsodyksMarkramSynapse):
    """A synapse that tires (``U``, ``tau_rec``) and facilitates (``tau_facil``); times in ms."""

    kind = TSODYKS_MARKRAM
    translations = untranslated(synapses.TsodyksMarkramSynapse.default_parameters)


class STDPMechanism(SynapseType, synapses.STDPMechanism):
    """Plasticity by spike pairs, additive or multiplicative."""

    kind = STDP

    @property
    def plasticity(self) -> Mapping[str, str]:
        parts = {"timing_dependence": self.timing_dependence, "weight_dependence": self.weight_dependence}
        return {name: type(part).__name__ for name, part in parts.items()}

    def __init__(self, *args: Any, **parameters: Any) -> None:
        for rule, (kind, example) in _RULES.items():
            valid = f"one such as sim.{example}()"
            require_kind("STDPMechanism", rule, parameters.get(rule), (kind, type(None)), valid)
        super().__init__(*args, **parameters)

    def _build_translations(self) -> None:
        if self.voltage_dependence is not None:
            raise CapabilityError("STDPMechanism: voltage dependence is not supported; leave it out")
        if self.timing_dependence is None or self.weight_dependence is None:
            raise NetworkError("STDPMechanism needs a timing_dependence and a weight_dependence")
        self.translations = untranslated(self.get_parameter_names())
