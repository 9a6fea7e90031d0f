"""How the synapses of a projection were made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final


@dataclass(frozen=True)
class Origin:
    """How a projection was made, for backends that need distributions instead of drawn values.

    Args:
        connector: PyNN's name of the connector, e.g. ``FixedProbabilityConnector``.
        parameters: its parameters: numbers, Booleans and strings; None for arrays.
        weight: the weight as given: a number, a distribution such as ``normal(mu=0.5, sigma=0.1)``, or a
            function of the distance ``d`` such as ``0.1*exp(-d)``; None if each synapse got its own.
        delay: the delay (ms) from the script, in the same form.
    """

    connector: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    weight: Any = None
    delay: Any = None


LISTED: Final = Origin("FromListConnector")
"""The origin of synapses that follow no rule."""
