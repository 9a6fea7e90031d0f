"""A cell given as equations, as data of a network."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property
from typing import Any, ClassVar, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.equations import linear
from nrp_core.network.equations.declarations import (
    OF_CELLS,
    Names,
    assignment,
    assignments_of,
    definitions_of,
    expression,
    lines_of,
    names_of,
    parameters_of,
    variables_of,
)
from nrp_core.network.equations.expressions import (
    ANY,
    RANDOM,
    STEP,
    TIME,
    TRUTH,
    WEIGHT,
    TextOrigin,
    dimension_of,
    names_in,
    parsed,
    require_dimension,
    require_known,
    resolved,
)
from nrp_core.network.equations.model import (
    CELL_TYPE,
    EXACT,
    INPUT,
    METHODS,
    RECEPTORS,
    RUNGE_KUTTA,
    Effect,
    Model,
    Texts,
    Variable,
    value_of,
)
from nrp_core.network.frozen_values import Plain, require_timestep
from nrp_core.units import AMPERE, NONE, SECOND, Unit, as_unit, quantity, times

_ALWAYS: Final = "(also refractory)"
"""After the effect of a spike: it is not lost while the cell is refractory."""


def read(texts: Texts) -> Model:
    """Return the meaning of the texts of a cell.

    Raises:
        NetworkError: a mistake, with its line.
    """
    lines = lines_of(texts.equations, CELL_TYPE, OF_CELLS)
    parameters = parameters_of(texts.units, lines, CELL_TYPE)
    _require_current(parameters)
    names = names_of(lines, parameters, texts.units, CELL_TYPE)
    own = {*parameters, *(line.name for line in lines)}
    variables = variables_of(lines, names, own)
    if not variables:
        TextOrigin("equations", texts.equations).refuse(
            "there is no state variable, e.g. 'dv/dt = -v/tau : mV'"
        )
    definitions = {name: resolved(node, own) for name, node in definitions_of(lines, names).items()}
    if not texts.threshold.strip():
        TextOrigin("threshold", "").refuse("a cell needs a threshold, e.g. threshold='v > v_thresh'")
    threshold = resolved(_threshold(texts.threshold, names), {*own, RANDOM, STEP})
    refractory, lasts = _refractory(texts.refractory, names)
    targets = {name: variable.unit.dimension for name, variable in variables.items()}
    reset, on_step = (
        tuple(
            (name, resolved(value, own))
            for name, value in assignments_of(text, where, CELL_TYPE, targets, names)
        )
        for where, text in (("reset", texts.reset), ("on_step", texts.on_step))
    )
    effects = _receptors(texts.receptors, variables, names)
    receptors = {name: replace(one, factor=resolved(one.factor, own)) for name, one in effects.items()}
    model = Model(
        variables, definitions, parameters, threshold, reset, resolved(refractory, own), lasts,
        receptors, RUNGE_KUTTA, {line.name: line.unit for line in lines if line.recorded}, on_step,
    )  # fmt: skip
    return replace(model, method=_method(texts.method, model))


def _require_current(parameters: Mapping[str, Unit]) -> None:
    if INPUT in parameters and parameters[INPUT].dimension != AMPERE:
        TextOrigin("parameters", f"{INPUT}: {parameters[INPUT].text}").refuse(
            f"'{INPUT}' is the injected current, in A; give another parameter another name"
        )


def _threshold(text: str, names: Names) -> ast.expr:
    """Return the condition for a spike; with a random number it may also use the step."""
    drawn = {RANDOM: NONE, STEP: SECOND} if re.search(rf"\b{RANDOM}\b", text) else {}
    known = Names({**names.dimensions, **drawn}, names.constant)
    return expression(text, TextOrigin("threshold", text), known, TRUTH, "a threshold", random=True)


def _refractory(text: str, names: Names) -> tuple[ast.expr, bool]:
    """Return the refractory time or condition, and whether it is a time."""
    place = TextOrigin("refractory", text)
    try:
        number, unit = quantity(text)
    except ValueError:
        node = parsed(text or "0", place)
        require_known(node, names.dimensions, place)
        found = dimension_of(node, names.dimensions, place)
        if found != TRUTH:
            require_dimension(node, names.dimensions, place, SECOND, "a refractory time")
        return node, found != TRUTH
    if unit.dimension != SECOND and number != 0.0:
        place.refuse(f"a refractory period is a time, e.g. '2 ms', not in {as_unit(unit.dimension)}")
    if number < 0.0:
        place.refuse("a refractory period is 0 or more")
    return ast.Constant(number * unit.scale), True


def _receptors(
    texts: Mapping[str, str], variables: Mapping[str, Variable], names: Names
) -> dict[str, Effect]:
    found = {}
    for receptor, text in texts.items():
        place = TextOrigin(f"receptor '{receptor}'", text)
        is_further = receptor in RECEPTORS or receptor[-1:].isdigit()  # such as excitatory2
        misspelt = not is_further and get_close_matches(receptor, RECEPTORS)
        if misspelt or not receptor.isidentifier():
            place.refuse(f"there is no receptor '{receptor}'{did_you_mean(receptor, RECEPTORS)}")
        effect = text.strip().removesuffix(_ALWAYS).rstrip()
        written = effect if "=" in effect else f"{effect} += {WEIGHT}"
        found[receptor] = replace(_effect(written, place, variables, names), always=effect != text.strip())
    return found


def _effect(text: str, place: TextOrigin, variables: Mapping[str, Variable], names: Names) -> Effect:
    target = re.split(r"[-+*/]?=", text)[0].strip()
    known = {**names.dimensions, WEIGHT: NONE}
    name, value = assignment(text, place, variables, Names(known, names.constant))
    parts = linear.coefficients_of(value, {*variables, WEIGHT}, {})
    if parts is None or WEIGHT not in parts or ast.unparse(parts.get(target, ast.Constant(0))) != "1.0":
        place.refuse(f"a spike adds to a variable in proportion to its weight, e.g. '{target} += {WEIGHT}'")
    factor = parts[WEIGHT]
    if parts.keys() != {target, WEIGHT} or not names.constant.issuperset(names_in(factor)):
        place.refuse("the effect of a spike depends on its weight and on parameters only")
    of = dimension_of(factor, known, place)
    unit = variables[name].unit
    if of not in (NONE, ANY):
        own = times(unit.dimension, of, -1)
        unit = Unit(as_unit(own), 1.0, own)
    return Effect(name, factor, unit)


def _method(text: str, model: Model) -> str:
    if text not in ("", *METHODS):
        TextOrigin("method", text).refuse(f"there is no method '{text}'{did_you_mean(text, METHODS)}")
    curved = linear.first_nonlinear(model)
    if text == EXACT and curved is not None:
        curved.place.refuse(
            f"d{curved.name}/dt is not linear in the state variables, so there is no exact method; leave out "
            f"`method`, or write method='{RUNGE_KUTTA}'"
        )
    return text or (EXACT if curved is None else RUNGE_KUTTA)


@dataclass(frozen=True)
class CellEquations(Plain, Texts):
    """The texts of a cell, which fit together.

    Args:
        step_ms: the only step of a brain with which the texts are right; None: any.

    Raises:
        NetworkError: a text contradicts itself or another; the message names its line.
    """

    KIND: ClassVar[str] = CELL_TYPE

    step_ms: float | None = None

    def __post_init__(self) -> None:
        require_timestep(self.step_ms)
        _ = self.model

    def data(self) -> dict[str, Any]:
        found = super().data()
        if self.step_ms is None:  # cells without one have the digest that they always had
            del found["step_ms"]
        return found

    @cached_property
    def model(self) -> Model:
        """What the texts mean."""
        return read(self)

    def require_values(
        self, owner: str, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> None:
        """Check the parameters and initial values of cells.

        Args:
            owner: the population, for the message.
            parameters: every parameter in its unit, shape ``(n,)``.
            states: initial values of state variables.

        Raises:
            NetworkError: a name is missing or unknown, a refractory period is negative, or a cell would fire
                in every step.
        """
        for name in self.model.parameters.keys() - parameters.keys():
            raise NetworkError(f"{owner} needs the parameter '{name}' of its equations")
        kinds: tuple[tuple[str, Mapping[str, FloatArray], Mapping[str, object]], ...] = (
            ("parameter", parameters, self.model.parameters),
            ("state variable", states, self.model.variables),
        )
        for what, given, valid in kinds:
            for name in given.keys() - valid.keys():
                raise NetworkError(
                    f"{owner}: its equations have no {what} '{name}'{did_you_mean(name, valid)}"
                )
        self.require_periods(owner, self.in_si(parameters))
        self._require_finite(owner, parameters, states)

    def require_periods(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        """Check that refractory periods are not negative, and that the reset ends a spike.

        Args:
            owner: the population, for the message.
            known: every parameter in SI units.

        Raises:
            NetworkError: a cell could not go on after a spike.
        """
        self._require_refractory(owner, known)
        self._require_end_of_spike(owner, known)

    def _require_finite(
        self, owner: str, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> None:
        model = self.model
        known = self.state_at_start(parameters, states)
        for name, variable in model.variables.items():
            try:
                rate = np.atleast_1d(value_of(variable.rate, known, model.definitions))
            except KeyError:  # a state variable has no initial value here
                continue
            for wrong in np.flatnonzero(~np.isfinite(rate))[:1]:
                zeros = [
                    one for one in names_in(variable.rate) if one in parameters and 0.0 in parameters[one]
                ]
                hint = f" ({', '.join(dict.fromkeys(zeros))} = 0)" if zeros else ""
                raise NetworkError(f"{owner}: d{name}/dt of cell {wrong} is not finite at time 0{hint}")

    def in_si(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return parameters in SI units, by name."""
        return {name: array * self.model.parameters[name].scale for name, array in values.items()}

    def state_at_start(
        self, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> dict[str, Any]:
        """Return the parameters and state of cells at time 0, in SI units.

        Args:
            parameters: every parameter in its unit, shape ``(n,)``.
            states: initial values of state variables, in their units.
        """
        variables = self.model.variables
        values = {name: array * variables[name].unit.scale for name, array in states.items()}
        return {TIME: 0.0, INPUT: 0.0, **self.in_si(parameters), **values}

    def _require_refractory(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        try:
            lasts = value_of(self.model.refractory, known, self.model.definitions)
        except KeyError:  # it depends on the state
            return
        if not self.model.lasts:
            return
        cells = np.flatnonzero(~(np.atleast_1d(lasts) >= 0.0))
        if len(cells):
            raise NetworkError(
                f"{owner}: the refractory period of cell {cells[0]}, '{self.refractory}', is "
                f"{np.atleast_1d(lasts)[cells[0]] * 1e3:g} ms; it must be 0 or more"
            )

    def _require_end_of_spike(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        after: dict[str, Any] = dict(known)
        for name, value in self.model.reset:
            try:
                after[name] = value_of(value, after, self.model.definitions)
            except KeyError:  # it depends on the state before the spike
                after.pop(name, None)
        try:
            again = np.atleast_1d(value_of(self.model.threshold, after, self.model.definitions))
        except KeyError:  # it depends on the state before the spike
            return
        if again.any() and any(name in after for name in names_in(self.model.threshold)):
            raise NetworkError(
                f"{owner}: after the reset, '{self.reset.strip()}', cell {int(np.argmax(again))} still meets "
                f"the threshold, '{self.threshold.strip()}', so it would fire without end"
            )
