"""PyNN's standard models, with PyNN's parameter names and units."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Final, NoReturn

import numpy as np
from pyNN.parameters import ArrayParameter
from pyNN.parameters import Sequence as PyNNSequence
from pyNN.standardmodels import (
    ModelNotAvailable,
    StandardCellType,
    STDPTimingDependence,
    STDPWeightDependence,
    build_translations,
    cells,
    synapses,
)

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.network.cells import CELLS, CellType
from nrp_core.network.pynn.arguments import in_units, require_by_name, require_names, require_values
from nrp_core.network.synapses import LAWS, RulePart, SynapseLaw


def own_name(name: str) -> str:
    """Return the name in networks, without the dot of those of receptors (``AMPA.gsyn``)."""
    return name.replace(".", "_")


def columns_of(owner: str, kind: Any, parameters: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield evaluated parameters of cells by name; one with several values a cell is divided into columns.

    Args:
        owner: the population, for the message.
        kind: the cell type.
        parameters: the values of each parameter.

    Raises:
        NetworkError: a cell has another number of values than its type.
    """
    for name, values in parameters.items():
        n = _length(kind, name)
        if not n:
            yield name, values
            continue
        rows = [np.atleast_1d(one.value) for one in np.atleast_1d(np.asarray(values, dtype=object))]
        wrong = next((len(row) for row in rows if len(row) != n), n)
        if wrong != n:
            raise NetworkError(f"{owner}: {name} has {wrong} values; it must have {n}")
        for k, column in enumerate(np.array(rows, dtype=float).T):
            yield f"{name}_{k}", column


def values_of(name: str, kind: Any, arrays: Mapping[str, Any]) -> Any:
    """Return a parameter of each cell in the script's form, from the arrays by names in networks."""
    n = _length(kind, name)
    if not n:
        return arrays[own_name(name)]
    rows = zip(*(arrays[f"{name}_{k}"] for k in range(n)), strict=True)
    found = np.empty(len(arrays[f"{name}_0"]), dtype=object)
    found[:] = [ArrayParameter(row) for row in rows]
    return found


def _length(kind: Any, name: str) -> int:
    """Return how many values of a parameter each cell has; 0 for a number, or a sequence of any length."""
    default = kind.default_parameters.get(name)
    several = isinstance(default, ArrayParameter) and not isinstance(default, PyNNSequence)
    return len(default.value) if several else 0


RULE_PARTS: Final = {"timing_dependence": STDPTimingDependence, "weight_dependence": STDPWeightDependence}
"""The base class of each part of a plasticity rule."""


_ROWS: Final = 2
"""Axes of an array that has a row for each cell, as spike times may be given."""


def untranslated(names: Iterable[str]) -> dict[str, Any]:
    """Return PyNN's translation table for parameters that keep their units, and their names but for a dot."""
    # PyNN would evaluate a name with a dot as an attribute, but multiplies by a factor
    rows = ((name, own_name(name), *([1.0] if "." in name else [])) for name in names)
    table: dict[str, Any] = build_translations(*rows)
    return table


def cell_types() -> dict[str, type]:
    """Return every supported cell type."""
    return {name: checked(getattr(cells, name, None) or beyond_pynn(cell)) for name, cell in CELLS.items()}


def beyond_pynn(cell: CellType) -> type:
    """Return the base class of a cell that PyNN does not have, like those of its standard cells."""
    known = {**cell.parameters, **cell.state}
    body = {
        "default_parameters": {name: parameter.default for name, parameter in cell.parameters.items()},
        "default_initial_values": {name: variable.default for name, variable in cell.state.items()},
        "units": {name: parameter.unit for name, parameter in known.items()},
        "recordable": ["spikes", *cell.state],
        "receptor_types": ("excitatory", "inhibitory"),
        "conductance_based": "_cond_" in cell.name,
        "injectable": True,
    }
    return type(cell.name, (StandardCellType,), {"__doc__": cell.summary, **body})


def checked(base: Any) -> type:
    """Return a cell type that checks the names and values of its arguments."""
    # PyNN lists a receptor for gap junctions in NEURON with HH_cond_exp
    receptors = tuple(name for name in base.receptor_types if name.isidentifier())

    def begin(self: Any, *arguments: Any, **parameters: Any) -> None:
        require_by_name(base.__name__, arguments, base.default_parameters)
        require_names(base.__name__, parameters, base.default_parameters)
        parameters = {
            name: list(value) if isinstance(value, np.ndarray) and value.ndim == _ROWS else value
            for name, value in in_units(base.__name__, parameters, base.units).items()
        }
        require_values(base.__name__, parameters)
        base.__init__(self, **parameters)

    defaults = {  # whose type is that of the values: no parameter is a whole number
        name: float(value) if isinstance(value, int) else value
        for name, value in base.default_parameters.items()
    }
    body = {
        "translations": untranslated(defaults),
        "receptor_types": receptors,
        "default_parameters": defaults,
    }
    return type(base.__name__, (base,), {"__doc__": base.__doc__, "__init__": begin, **body})


class _RulePart:
    """Base of the parts of plasticity rules: checks their arguments."""

    default_parameters: ClassVar[dict[str, float]]

    def __init__(self, *arguments: Any, **parameters: Any) -> None:
        require_names(type(self).__name__, parameters, type(self).default_parameters)
        super().__init__(*arguments, **parameters)


def rule_parts() -> dict[str, type]:
    """Return the classes from which scripts compose plasticity rules."""
    return {
        name: _rule_part(name, RULE_PARTS[kind], part, law)
        for law in LAWS.values()
        for kind, classes in law.parts.items()
        for name, part in classes.items()
    }


def _rule_part(name: str, kind: type, part: RulePart, law: SynapseLaw) -> type:
    """Return the class of a part, PyNN's own where it has one."""
    base = getattr(synapses, name, None)
    body: dict[str, Any] = {"__doc__": part.summary, "translations": untranslated(part.parameters)}
    if base is None:
        body["default_parameters"] = {one: law.parameters[one].default for one in part.parameters}
    return type(name, (_RulePart, base or kind), body)


def unavailable_models() -> dict[str, type]:
    """Return placeholders for the unsupported PyNN models; their constructors raise."""
    nearest = {other: cell.name for cell in CELLS.values() for other in cell.stands_for}
    for law in LAWS.values():
        nearest |= dict.fromkeys(law.stands_for, law.pynn)
        for classes in law.parts.values():
            nearest |= {other: name for name, part in classes.items() for other in part.stands_for}
    return {name: _unavailable(name, chosen) for name, chosen in nearest.items()}


def native_model(kind: str, choices: Sequence[str]) -> Callable[[str], NoReturn]:
    """Return a stand-in for PyNN's functions for native models of one simulator; it raises.

    Args:
        kind: the kind of model, e.g. ``cell type``.
        choices: names of the standard models of that kind.
    """

    def refuse(name: str, *_: object, **__: object) -> NoReturn:
        alike = name.replace("psc", "curr")
        nearest = difflib.get_close_matches(alike.lower(), [choice.lower() for choice in choices], 1, 0.0)
        hint = next(choice for choice in choices if choice.lower() == nearest[0])
        raise CapabilityError(
            f"the {kind} '{name}' exists in one simulator only; the nearest standard model is {hint}"
        )

    return refuse


def _unavailable(name: str, nearest: str) -> type:
    def refuse(*_: object, **__: object) -> NoReturn:
        raise CapabilityError(f"{name} is not supported; the nearest supported model: {nearest}")

    return type(name, (ModelNotAvailable,), {"__init__": refuse})
