"""Synapse laws given as equations: the texts, and what they mean."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.brain.network.equations.courses import Course
from nrp_core.brain.network.equations.declarations import Assignments
from nrp_core.brain.network.equations.expressions import WEIGHT
from nrp_core.brain.network.equations.model import Variable
from nrp_core.brain.network.equations.units import Unit

SYNAPSE_TYPE: Final = "EquationSynapse"
"""The type of all synapses whose law is given as equations."""
SHARE: Final = "share"
"""The share of the weight with which a spike arrives."""


@dataclass(frozen=True)
class SynapseTexts:
    """What a user wrote.

    Args:
        equations: one equation a line.
        on_pre: what a spike of the source does: assignments.
        on_post: what a spike of the target does.
        units: unit of each parameter.
        initial: value and unit of state variables at time 0; others begin at 0.
        weight_unit: the unit of ``weight``; ``1`` for its number in the units of scripts.
    """

    equations: str
    on_pre: str = ""
    on_post: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    initial: Mapping[str, str] = field(default_factory=dict)
    weight_unit: str = "1"


@dataclass(frozen=True, slots=True)
class SynapseModel:
    """The meaning of a law's equations.

    Args:
        variables: the state variables by name.
        courses: what each does between spikes.
        definitions: expressions with a name, each after those that it needs.
        parameters: units of parameters by name.
        on_pre: what a spike of the source changes, in this order.
        on_post: what a spike of the target changes.
        initial: values of state variables at time 0, in SI units.
        weight_unit: the unit of ``weight``.
    """

    variables: Mapping[str, Variable]
    courses: Mapping[str, Course]
    definitions: Mapping[str, ast.expr]
    parameters: Mapping[str, Unit]
    on_pre: Assignments
    on_post: Assignments
    initial: Mapping[str, float]
    weight_unit: Unit

    @property
    def is_plastic(self) -> bool:
        """Whether spikes change the weight; otherwise they arrive with a share of it."""
        return any(name == WEIGHT for name, _ in (*self.on_pre, *self.on_post))
