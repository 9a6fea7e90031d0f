"""Cell types that scripts give as equations."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from nrp_core.brain.network.cells import CellType
from nrp_core.brain.network.equations.cell import CellEquations
from nrp_core.brain.network.equations.expressions import TextOrigin
from nrp_core.brain.network.equations.model import CELL_TYPE, INPUT
from nrp_core.brain.network.parameters import Parameter
from nrp_core.brain.pynn.models import beyond_pynn, checked
from nrp_core.brain.pynn.quantities import require_dictionaries, require_texts, value_with_unit
from nrp_core.errors import NetworkError, did_you_mean

_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})
_NANO: Final = 1e-9


def equation_cell(
    equations: str,
    threshold: str = "",
    reset: str = "",
    refractory: str = "0 ms",
    *,
    parameters: Mapping[str, Any] = _NOTHING,
    initial: Mapping[str, Any] = _NOTHING,
    receptors: Mapping[str, str] = _NOTHING,
    method: str = "",
    name: str = CELL_TYPE,
    **unknown: Any,
) -> type:
    """Return a cell type of equations, in the notation of Brian2.

    It is used as any of PyNN's: ``sim.Population(10, Cell)``, or ``Cell(tau=...)`` for other values, which
    are numbers in the unit of the default.

    Args:
        equations: one a line: ``dv/dt = ... : mV (unless refractory)`` for a state variable, ``I = ... : nA``
            for an expression with a name, ``tau : ms`` for a parameter; the unit is that of scripts and
            recordings.
        threshold: the condition for a spike.
        reset: assignments to state variables after a spike, one a line or divided by ``;``.
        refractory: a time such as ``2 ms``, an expression of parameters, or a condition in which the cell
            does not spike.
        parameters: default value and unit of each parameter, e.g. ``{"tau": "20 ms"}``. Currents are
            injected into a parameter of the name ``i_offset``.
        initial: values of state variables at time 0, e.g. ``{"v": "-65 mV"}``; by default 0.
        receptors: what a spike does, by receptor, e.g. ``{"excitatory": "ge += weight"}``, or ``ge`` for
            short.
        method: ``exact`` (linear equations), or ``runge_kutta``; by default the first where it is possible.
        name: the name of the cell type in messages.
        unknown: not allowed.

    Raises:
        NetworkError: the texts do not fit together; the message names the line.
    """
    texts = {"equations": equations, "threshold": threshold, "reset": reset, "refractory": refractory}
    require_texts(CELL_TYPE, {**texts}, _EXAMPLES, unknown)
    require_dictionaries(CELL_TYPE, {"parameters": parameters, "initial": initial, "receptors": receptors})
    defaults = {
        key: value_with_unit("parameters", key, value, CELL_TYPE) for key, value in parameters.items()
    }
    units = {key: unit.text for key, (_, unit) in defaults.items()}
    cell = CellEquations(**texts, receptors=dict(receptors), units=units, method=method)
    state = {key: Parameter(0.0, variable.unit.text) for key, variable in cell.model.variables.items()}
    state |= {key: _initial(cell, key, value) for key, value in initial.items()}
    summary = "A cell given as equations:\n\n" + cell.equations.strip("\n")
    kind = CellType(
        name, summary, {key: Parameter(v, unit.text) for key, (v, unit) in defaults.items()}, state
    )
    cell.require_values(name, {key: np.array([v]) for key, (v, _) in defaults.items()}, {})
    return bound(kind, cell)


_EXAMPLES: Final = {
    "equations": "dv/dt = -v/tau : mV", "threshold": "v > v_thresh", "reset": "v = v_reset",
    "refractory": "2 ms",
}  # fmt: skip


def bound(kind: CellType, cell: CellEquations, **own: Any) -> type:
    """Return PyNN's class of a cell type that is given as equations.

    Args:
        kind: the cell type.
        cell: its equations.
        own: attributes of the class that differ from those of the cell type.
    """
    current = cell.model.parameters.get(INPUT)
    body = {
        "equations": cell,
        "cell_type": CELL_TYPE,
        "receptor_types": tuple(cell.model.receptors),
        "conductance_based": cell.model.is_conductance_based,
        "injectable": current is not None,
        "input_per_na": _NANO / current.scale if current is not None else 0.0,
        "weight_units": {name: effect.unit.text for name, effect in cell.model.receptors.items()},
    }
    base: Any = beyond_pynn(kind)
    body["recordable"] = [*base.recordable, *cell.model.recorded]
    body["units"] = base.units | {name: unit.text for name, unit in cell.model.recorded.items()}
    return checked(type(kind.name, (base,), {"__doc__": kind.summary, **body, **own}))


def _initial(cell: CellEquations, name: str, value: Any) -> Parameter:
    """Return a state variable with an initial value, in its unit."""
    if name not in cell.model.variables:
        raise NetworkError(
            f"EquationCell: initial has no state variable '{name}'{did_you_mean(name, cell.model.variables)}"
        )
    unit = cell.model.variables[name].unit
    number, given = value_with_unit("initial", name, value, CELL_TYPE)
    if given.dimension != unit.dimension and number != 0.0:
        TextOrigin("initial", f"{name}: {value}").refuse(f"'{name}' is in {unit.text}")
    return Parameter(number * given.scale / unit.scale, unit.text)
