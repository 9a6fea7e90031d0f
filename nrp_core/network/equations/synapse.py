"""A synapse law given as equations, as data of a network."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.equations.declarations import (
    OF_SYNAPSES,
    Assignments,
    Line,
    Names,
    assignments_of,
    definitions_of,
    lines_of,
    names_of,
    parameters_of,
    variables_of,
)
from nrp_core.network.equations.expressions import TIME, WEIGHT, TextOrigin, names_in, parsed, resolved
from nrp_core.network.equations.linear import ONE, Coefficients, coefficients_of
from nrp_core.network.equations.model import Variable, value_of
from nrp_core.network.frozen_values import Plain
from nrp_core.units import NONE, Dimension, Unit, as_unit, quantity, unit_of

_VALID = (
    "between spikes a variable has a closed form if it is linear in itself, e.g. 'dx/dt = (1 - x)/tau : 1', "
    "and in variables that only decay, e.g. 'dy/dt = -y/tau_y : 1'"
)
DOPAMINE: Final = "dopamine"
"""The dopamine of the target less its baseline, in equations of the weight."""
_PRODUCT: Final = f"the weight follows a variable that only decays, 'd{WEIGHT}/dt = c*{DOPAMINE} : 1'"
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


SYNAPSE_TYPE: Final = "EquationSynapse"
"""The type of all synapses whose law is given as equations."""
SHARE: Final = "share"
"""The share of the weight with which a spike arrives."""


@dataclass(frozen=True)
class SynapseTexts:
    """What a user wrote.

    Args:
        equations: one equation a line.
        on_pre: assignments that a spike of the source makes.
        on_post: assignments that a spike of the target makes.
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
        courses: the time course of each between spikes.
        definitions: expressions with a name, each after those that it needs.
        parameters: units of parameters by name.
        on_pre: the variables that a spike of the source changes, in this order.
        on_post: the variables that a spike of the target changes.
        initial: values of state variables at time 0, in SI units.
        weight_unit: the unit of ``weight``.
        eligibility: the variable whose product with dopamine the weight follows between spikes; empty if
            only spikes change it.
    """

    variables: Mapping[str, Variable]
    courses: Mapping[str, Course]
    definitions: Mapping[str, ast.expr]
    parameters: Mapping[str, Unit]
    on_pre: Assignments
    on_post: Assignments
    initial: Mapping[str, float]
    weight_unit: Unit
    eligibility: str = ""

    @property
    def is_plastic(self) -> bool:
        """Whether the weight changes; otherwise spikes arrive with a share of it."""
        return bool(self.eligibility) or any(name == WEIGHT for name, _ in (*self.on_pre, *self.on_post))


_TAKEN = {
    SHARE: "the share of the weight with which a spike arrives",
    "delay": "that of the synapse",
    "w": "that of a weight in Brian2; here the weight is 'weight'",
}


def read_synapse(texts: SynapseTexts) -> SynapseModel:
    """Return the meaning of the texts of a synapse law.

    Raises:
        NetworkError: a mistake, with its line.
    """
    written = lines_of(texts.equations, SYNAPSE_TYPE, OF_SYNAPSES)
    of_weight = [line for line in written if line.name == WEIGHT and line.is_derivative]
    lines = [line for line in written if line not in of_weight]
    parameters = parameters_of(texts.units, lines, SYNAPSE_TYPE)
    _require_free(lines, texts.units)
    names = names_of(lines, parameters, texts.units, SYNAPSE_TYPE)
    own = {*parameters, *(line.name for line in lines), WEIGHT, SHARE}
    variables = variables_of(lines, names, own)
    definitions = {name: resolved(node, own) for name, node in definitions_of(lines, names).items()}
    weight_unit = _unit(texts.weight_unit)
    targets = {name: variable.unit.dimension for name, variable in variables.items()}
    targets |= {WEIGHT: weight_unit.dimension, SHARE: NONE}
    changes = {}
    for where, text in (("on_pre", texts.on_pre), ("on_post", texts.on_post)):
        known = Names({**names.dimensions, WEIGHT: weight_unit.dimension, SHARE: NONE}, names.constant)
        found = assignments_of(text, where, SYNAPSE_TYPE, targets, known)
        changes[where] = tuple((name, resolved(value, own)) for name, value in found)
    _require_purpose(changes["on_pre"], changes["on_post"], bool(of_weight))
    courses = courses_of(variables, definitions)
    return SynapseModel(
        variables, courses, definitions, parameters, changes["on_pre"], changes["on_post"],
        _initial(texts.initial, variables), weight_unit,
        _eligibility(of_weight, variables, courses, weight_unit),
    )  # fmt: skip


def _eligibility(
    lines: Sequence[Line], variables: Mapping[str, Variable], courses: Mapping[str, Course], weight: Unit
) -> str:
    """Return the variable in the equation of the weight; empty without one.

    Raises:
        NetworkError: the equation has another form.
    """
    if not lines:
        return ""
    line, *others = lines
    for other in others:
        other.place.refuse(f"'{WEIGHT}' is defined twice")
    product = parsed(line.expression or "", line.place)
    factors = [product.left, product.right] if isinstance(product, ast.BinOp) else []
    names = [one.id for one in factors if isinstance(one, ast.Name) and one.id != DOPAMINE]
    if not (isinstance(getattr(product, "op", None), ast.Mult) and len(names) == 1 and names[0] in variables):
        line.place.refuse(f"d{WEIGHT}/dt is not the product of a state variable and '{DOPAMINE}'; {_PRODUCT}")
    name, course = names[0], courses[names[0]]
    if course.constant is not ZERO or course.drivers or course.rate is ZERO:
        variables[name].place.refuse(f"'{name}' does not only decay; {_PRODUCT}")
    for what, unit in (("the equation", line.unit), (f"'{name}'", variables[name].unit)):
        if unit.dimension != weight.dimension:
            own, of_weight = as_unit(unit.dimension), as_unit(weight.dimension)
            line.place.refuse(f"{what} is in {own}, and '{WEIGHT}' in {of_weight}")
    return name


def _require_free(lines: list[Line], units: Mapping[str, str]) -> None:
    """Refuse names that mean something else at a synapse."""
    places = {
        name: TextOrigin("parameters", f"{name}: {text}", kind=SYNAPSE_TYPE) for name, text in units.items()
    }
    places |= {line.name: line.place for line in lines}
    for name in _TAKEN.keys() & places.keys():
        places[name].refuse(f"'{name}' is reserved, it is {_TAKEN[name]}; choose another name")


def _unit(text: str) -> Unit:
    try:
        return unit_of(text)
    except ValueError as error:
        TextOrigin("weight_unit", text, kind=SYNAPSE_TYPE).refuse(str(error))


def _require_purpose(on_pre: Assignments, on_post: Assignments, follows_dopamine: bool) -> None:
    """Refuse laws that neither transmit a share nor change the weight, and those that do both."""
    shares = [k for k, (name, _) in enumerate(on_pre) if name == SHARE]
    plastic = follows_dopamine or any(name == WEIGHT for name, _ in (*on_pre, *on_post))
    place = TextOrigin("on_pre", "; ".join(name for name, _ in on_pre), kind=SYNAPSE_TYPE)
    after = TextOrigin("on_post", "; ".join(name for name, _ in on_post), kind=SYNAPSE_TYPE)
    if any(name == SHARE or SHARE in names_in(value) for name, value in on_post):
        after.refuse("'share' is that of an arriving spike, so it stands in on_pre")
    if not shares and not plastic:
        place.refuse(
            "it has no effect; a spike arrives with 'share = ...' of the weight, or it changes the weight, "
            "'weight += ...'"
        )
    if shares and plastic:
        place.refuse("a law sets the share of the weight that arrives or changes the weight, not both")
    if shares and on_post:
        after.refuse(
            "spikes of the target have an effect in laws that change the weight, not in those of a share"
        )
    if shares and any(WEIGHT in names_in(value) for _, value in on_pre):
        place.refuse("a share is that of any weight, so it does not depend on 'weight'")
    first = shares[0] if shares else len(on_pre)
    if any(SHARE in names_in(value) for _, value in on_pre[: first + 1]):
        place.refuse("'share' is used before it has a value; begin with 'share = ...'")


def _initial(texts: Mapping[str, str], variables: Mapping[str, Variable]) -> dict[str, float]:
    """Return the initial values of all state variables in SI units."""
    found = dict.fromkeys(variables, 0.0)
    for name, text in texts.items():
        place = TextOrigin("initial", f"{name}: {text}", kind=SYNAPSE_TYPE)
        if name not in variables:
            place.refuse(f"there is no state variable '{name}'{did_you_mean(name, variables)}")
        try:
            number, unit = quantity(text)
        except ValueError as error:
            place.refuse(str(error))
        _require_unit(unit, variables[name].unit.dimension, name, number, place)
        found[name] = number * unit.scale
    return found


def _require_unit(unit: Unit, dimension: Dimension, name: str, number: float, place: TextOrigin) -> None:
    if unit.dimension != dimension and number != 0.0:
        place.refuse(f"'{name}' is in {as_unit(dimension)}, not in {as_unit(unit.dimension)}")


@dataclass(frozen=True)
class SynapseEquations(Plain, SynapseTexts):
    """The texts of a synapse law, which fit together.

    Raises:
        NetworkError: a text contradicts itself or another; the message names its line.
    """

    KIND: ClassVar[str] = SYNAPSE_TYPE

    def __post_init__(self) -> None:
        _ = self.model

    @cached_property
    def model(self) -> SynapseModel:
        """What the texts mean."""
        return read_synapse(self)

    def require_values(
        self, owner: str, item: Callable[[int], str], parameters: Mapping[str, FloatArray]
    ) -> None:
        """Check the parameters of synapses.

        Args:
            owner: the projection, for the message.
            item: returns the description of the synapse at an index.
            parameters: every parameter in its unit, shape ``(n,)``.

        Raises:
            NetworkError: a name is missing or unknown, or an equation has no finite solution.
        """
        known = self.model.parameters
        for name in known.keys() - parameters.keys():
            raise NetworkError(f"{owner} needs the parameter '{name}' of its equations")
        for name in parameters.keys() - known.keys():
            raise NetworkError(
                f"{owner}: its equations have no parameter '{name}'{did_you_mean(name, known)}"
            )
        values = self.in_si(parameters)
        for name, course in self.model.courses.items():
            for coefficient in course.coefficients:
                found = np.atleast_1d(value_of(coefficient, values, self.model.definitions))
                for wrong in np.flatnonzero(~np.isfinite(found))[:1]:
                    used = ", ".join(
                        f"{one} = {parameters[one][wrong]:g} {known[one].text}".removesuffix(" 1")
                        for one in dict.fromkeys(names_in(coefficient))
                        if one in known
                    )
                    raise NetworkError(f"{owner}: d{name}/dt of {item(int(wrong))} is not finite ({used})")

    def require_weight_unit(self, owner: str, unit: Unit) -> None:
        """Check that the weights of a projection have the unit that the equations require.

        Raises:
            NetworkError: they are of another kind.
        """
        own = self.model.weight_unit.dimension
        if own not in (NONE, unit.dimension):
            raise NetworkError(
                f"{owner}: 'weight' is in {as_unit(own)} in the equations of its synapses (weight_unit), "
                f"and weights onto its target are in {unit.text}"
            )

    def weight_scale(self, unit: Unit) -> float:
        """Return the factor of weights in the equations: 1, or the size of their unit."""
        return 1.0 if self.model.weight_unit.dimension == NONE else unit.scale

    def in_si(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return parameters in SI units, by name."""
        return {name: array * self.model.parameters[name].scale for name, array in values.items()}
