"""What the variables of a synapse do between spikes, in closed form."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.brain.network.equations.expressions import TIME, TextOrigin
from nrp_core.brain.network.equations.linear import ONE, Coefficients, coefficients_of
from nrp_core.brain.network.equations.model import Variable

_VALID = (
    "between spikes a variable has a closed form if it is linear in itself, e.g. 'dx/dt = (1 - x)/tau : 1', "
    "and in variables that only decay, e.g. 'dy/dt = -y/tau_y : 1'"
)
ZERO: Final = ast.Constant(0.0)
"""The coefficient of what an equation does not have."""


@dataclass(frozen=True, slots=True)
class Course:
    """A linear equation ``dx/dt = rate x + constant + the sum of factor y``.

    Args:
        rate: the coefficient of the variable itself.
        constant: the part that does not depend on variables.
        drivers: the factors of other variables, which only decay: ``dy/dt = rate y``.
    """

    rate: ast.expr = ZERO
    constant: ast.expr = ZERO
    drivers: Mapping[str, ast.expr] = field(default_factory=dict)

    @property
    def coefficients(self) -> list[ast.expr]:
        """All of its coefficients."""
        return [self.rate, self.constant, *self.drivers.values()]


def courses_of(variables: Mapping[str, Variable], definitions: Mapping[str, ast.expr]) -> dict[str, Course]:
    """Return the courses of state variables.

    Raises:
        NetworkError: an equation has no closed form of this kind; the message names its line.
    """
    found = {name: _linear(variable, variables, definitions) for name, variable in variables.items()}
    courses = {}
    for name, coefficients in found.items():
        drivers = {key: factor for key, factor in coefficients.items() if key not in (name, ONE)}
        for driver in drivers:
            if found[driver].keys() - {driver}:
                variables[name].place.refuse(f"'{driver}' does not only decay; {_VALID}")
        courses[name] = Course(coefficients.get(name, ZERO), coefficients.get(ONE, ZERO), drivers)
    return courses


def _linear(
    variable: Variable, variables: Mapping[str, Variable], definitions: Mapping[str, ast.expr]
) -> Coefficients:
    place: TextOrigin = variable.place
    found = coefficients_of(variable.rate, {*variables, TIME}, definitions)
    if found is None:
        place.refuse(f"d{variable.name}/dt is not linear in the state variables; {_VALID}")
    if TIME in found:
        place.refuse(f"d{variable.name}/dt depends on the time; {_VALID}")
    return found
