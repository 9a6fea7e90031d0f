"""Cell types and synapse laws that scripts give as equations: in dictionaries, in NESTML, or PyNN's own."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from pyNN.standardmodels import StandardSynapseType

from nrp_core.errors import BackendLoadError, NetworkError, did_you_mean
from nrp_core.network.cells import CellType
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.equations.expressions import TextOrigin
from nrp_core.network.equations.model import CELL_TYPE, INPUT
from nrp_core.network.equations.synapse import SYNAPSE_TYPE, SynapseEquations
from nrp_core.network.parameters import Parameter
from nrp_core.network.pynn.models import beyond_pynn, checked, untranslated
from nrp_core.network.pynn.synapses import SynapseType
from nrp_core.paths import existing_file
from nrp_core.registry import Registry
from nrp_core.units import Unit, quantity


def value_with_unit(where: str, name: str, value: Any, kind: str) -> tuple[float, Unit]:
    """Return a number and its unit, from a text or a plain number.

    Args:
        where: the argument that has it.
        name: the owner of the value.
        value: the value.
        kind: the kind of object that equations define, by its name in scripts.

    Raises:
        NetworkError: it is not a quantity.
    """
    place = TextOrigin(where, f"{name}: {value}", kind=kind)
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (str, int, float, np.number)):
        place.refuse(
            "its default is a number with a unit, e.g. '20 ms'; values of each one go to the type itself"
        )
    try:
        return quantity(str(value))
    except ValueError as error:
        place.refuse(str(error))


def require_texts(
    kind: str, texts: Mapping[str, Any], examples: Mapping[str, str], unknown: Mapping[str, Any]
) -> None:
    """Refuse arguments that are not texts, and unknown arguments.

    Args:
        kind: the kind of object that equations define, by its name in scripts.
        texts: the arguments that are texts.
        examples: an example of each.
        unknown: other arguments.

    Raises:
        NetworkError: an argument is wrong.
    """
    for argument in unknown:
        hint = did_you_mean(argument, [*examples, "parameters", "initial", "receptors", "method"])
        raise NetworkError(
            f"{kind} has no argument '{argument}'{hint}; parameters are given as "
            f"parameters={{'{argument}': '20 ms'}}"
        )
    for what, text in texts.items():
        if not isinstance(text, str):
            raise NetworkError(f"{kind}: {what} is a text, e.g. {examples[what]!r}, not {text!r}")


def require_dictionaries(kind: str, arguments: Mapping[str, object]) -> None:
    """Refuse arguments that are not dictionaries.

    Args:
        kind: the kind of object that equations define, by its name in scripts.
        arguments: the arguments by name.

    Raises:
        NetworkError: an argument is something else.
    """
    for name, given in arguments.items():
        if not isinstance(given, Mapping):
            example = {"receptors": "{'excitatory': 'ge'}", "initial": "{'v': '-65 mV'}"}
            valid = example.get(name, "{'tau': '20 ms'}")
            raise NetworkError(f"{kind}: {name} is a dictionary, e.g. {valid}, not {given!r}")


_NOTHING: Final[Mapping[str, Any]] = MappingProxyType({})
_NANO: Final = 1e-9


def equation_cell(
    equations: str,
    threshold: str = "",
    reset: str = "",
    refractory: str = "0 ms",
    *,
    on_step: str = "",
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
        on_step: assignments to state variables in each step, after the spikes that arrive there.
        parameters: default value and unit of each parameter, e.g. ``{"tau": "20 ms"}``. Currents are
            injected into a parameter of the name ``i_offset``.
        initial: values of state variables at time 0, e.g. ``{"v": "-65 mV"}``; by default 0.
        receptors: the effect of a spike, by receptor, e.g. ``{"excitatory": "ge += weight"}``, or ``ge`` for
            short.
        method: ``exact`` (linear equations), or ``runge_kutta``; by default the first where it is possible.
        name: the name of the cell type in messages.
        unknown: not allowed.

    Raises:
        NetworkError: the texts do not fit together; the message names the line.
    """
    texts = {
        "equations": equations, "threshold": threshold, "reset": reset, "refractory": refractory,
        "on_step": on_step,
    }  # fmt: skip
    require_texts(CELL_TYPE, {**texts}, _CELL_EXAMPLES, unknown)
    require_dictionaries(CELL_TYPE, {"parameters": parameters, "initial": initial, "receptors": receptors})
    defaults = {
        key: value_with_unit("parameters", key, value, CELL_TYPE) for key, value in parameters.items()
    }
    units = {key: unit.text for key, (_, unit) in defaults.items()}
    cell = CellEquations(**texts, receptors=dict(receptors), units=units, method=method, step_ms=None)
    state = {key: Parameter(0.0, variable.unit.text) for key, variable in cell.model.variables.items()}
    state |= {key: _initial(cell, key, value) for key, value in initial.items()}
    summary = "A cell given as equations:\n\n" + cell.equations.strip("\n")
    kind = CellType(
        name, summary, {key: Parameter(v, unit.text) for key, (v, unit) in defaults.items()}, state
    )
    cell.require_values(name, {key: np.array([v]) for key, (v, _) in defaults.items()}, {})
    return bound(kind, cell)


_CELL_EXAMPLES: Final = {
    "equations": "dv/dt = -v/tau : mV", "threshold": "v > v_thresh", "reset": "v = v_reset",
    "refractory": "2 ms", "on_step": "w += a*(v - v_rest)",
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


PROGRAM: Final = "nrp-nestml"
INSTALL: Final = "pip install nrp-nestml"
_TIME_LIMIT_S: Final = 300


def nestml_cell(path: Path | str) -> type:
    """Return the neuron in a file of NESTML as a cell type of equations.

    Its parameters and variables have the names and units of the file; a weight is in the unit of the variable
    that a spike changes, and currents are injected into the continuous port.

    Args:
        path: the file.

    Raises:
        NetworkError: the program ``nrp-nestml`` is not installed, or the neuron has something that
            cells in equations do not have; the message names the line.
    """
    file = existing_file(path)
    try:
        arguments = _translated(file)
    except ValueError as error:
        raise NetworkError(str(error), path=file) from error
    return equation_cell(**arguments)


def _translated(file: Path) -> dict[str, Any]:
    """Return the program's output.

    Raises:
        ValueError: the program is not installed, or reports that it cannot translate the file.
    """
    program = shutil.which(PROGRAM, path=str(Path(sys.executable).parent)) or shutil.which(PROGRAM)
    if program is None:
        raise ValueError(f"cells of NESTML need the program {PROGRAM}; try: {INSTALL}")
    try:
        done = subprocess.run(
            [program, str(file)], capture_output=True, text=True, check=False, timeout=_TIME_LIMIT_S
        )
    except subprocess.TimeoutExpired:
        raise ValueError(f"{PROGRAM} has not answered in {_TIME_LIMIT_S} s") from None
    try:
        found: dict[str, Any] = json.loads(done.stdout)
    except json.JSONDecodeError:
        said = done.stderr.strip().splitlines()[-1:] or ["nothing"]
        raise ValueError(f"{PROGRAM} failed with exit code {done.returncode} and said: {said[0]}") from None
    if "error" in found:
        raise ValueError(found["error"])
    return found


_SYNAPSE_EXAMPLES: Final = {
    "equations": "dx/dt = (1 - x)/tau : 1 (event-driven)", "on_pre": "share = x; x *= 0.5",
    "on_post": "weight += a_plus*x", "weight_unit": "nA",
}  # fmt: skip


def equation_synapse(
    equations: str,
    on_pre: str = "",
    on_post: str = "",
    *,
    parameters: Mapping[str, Any] = _NOTHING,
    initial: Mapping[str, Any] = _NOTHING,
    weight_unit: str = "1",
    name: str = SYNAPSE_TYPE,
    **unknown: Any,
) -> type:
    """Return a synapse type of equations, in the notation of Brian2.

    It is used as any of PyNN's: ``sim.Projection(a, b, connector, Law(weight=0.1, delay=1.0))``, with other
    values as in ``Law(tau=...)``, which are numbers in the unit of the default.

    Args:
        equations: one a line: ``dx/dt = ... : 1 (event-driven)`` for a state variable of each synapse,
            ``y = ... : 1`` for an expression with a name, ``tau : ms`` for a parameter.
        on_pre: the effect of a spike of the source: assignments to state variables, one per line or separated
            by ``;``. The spike arrives with ``share = ...`` of the weight, or changes it: ``weight += ...``.
        on_post: the effect of a spike of the target, in laws that change the weight.
        parameters: default value and unit of each parameter, e.g. ``{"tau": "20 ms"}``.
        initial: values of state variables at time 0, e.g. ``{"x": 1}``; by default 0.
        weight_unit: the unit of ``weight``, e.g. ``nA``; ``1`` for its number in the units of scripts.
        name: the name of the synapse type in messages.
        unknown: not allowed.

    Raises:
        NetworkError: the texts do not fit together; the message names the line.
    """
    texts = {"equations": equations, "on_pre": on_pre, "on_post": on_post, "weight_unit": weight_unit}
    require_texts(SYNAPSE_TYPE, texts, _SYNAPSE_EXAMPLES, unknown)
    require_dictionaries(SYNAPSE_TYPE, {"parameters": parameters, "initial": initial})
    defaults = {
        key: value_with_unit("parameters", key, value, SYNAPSE_TYPE) for key, value in parameters.items()
    }
    units = {key: unit.text for key, (_, unit) in defaults.items()}
    law = SynapseEquations(**texts, units=units, initial={key: str(value) for key, value in initial.items()})
    own = {"weight": 0.0, "delay": None, **{key: value for key, (value, _) in defaults.items()}}
    body = {
        "__doc__": "A synapse given as equations:\n\n" + equations.strip("\n"),
        "kind": SYNAPSE_TYPE,
        "equations": law,
        "default_parameters": own,
        "translations": untranslated(own),
    }
    return type(name, (SynapseType, StandardSynapseType), body)


SYNAPSES: Final[Registry[type]] = Registry("nrp_core.synapses", "synapse type")
"""The synapse types of packages, each made by :func:`equation_synapse`; scripts use them by these names."""


def registered_synapse(name: str) -> type:
    """Return the synapse type that a package registers under a name.

    Raises:
        BackendError: it does not import, is no synapse type of equations, or two packages provide it.
    """
    law = SYNAPSES.load(name)
    if not isinstance(law, type) or not isinstance(getattr(law, "equations", None), SynapseEquations):
        raise BackendLoadError(
            f"the {SYNAPSES.kind} '{name}' of {SYNAPSES.provider(name)} is not a result of equation_synapse"
        )
    return type(name, (law,), {"__doc__": law.__doc__})
