"""PyNN's composed cells: a membrane with any number of named receptors, as cells in equations."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar, Final

from pyNN.standardmodels import cells, receptors

from nrp_core.errors import NetworkError
from nrp_core.network.cells import CellType
from nrp_core.network.equations.cell import CellEquations
from nrp_core.network.parameters import Parameter
from nrp_core.network.pynn.arguments import require_kind, require_names, require_values
from nrp_core.network.pynn.equation_models import bound
from nrp_core.network.pynn.models import own_name

_NAME: Final = "PointNeuron"


@dataclass(frozen=True, slots=True)
class _Membrane:
    """The equations of a membrane, to which ``{current}`` is the sum of the synaptic currents, nA.

    Args:
        pynn: PyNN's component.
        equations: its equations.
        threshold: the condition for a spike.
        reset: the changes that a spike makes.
    """

    pynn: Any
    equations: str
    threshold: str
    reset: str


@dataclass(frozen=True, slots=True)
class _Response:
    """The equations of a receptor, whose name prefixes theirs.

    Args:
        pynn: PyNN's component.
        equations: its equations.
        current: the current that it lets in, nA.
        effect: the effect of a spike.
    """

    pynn: Any
    equations: str
    current: str
    effect: str


_MEMBRANES: Final = {
    "LIF": _Membrane(
        cells.LIF,
        "dv/dt = (v_rest - v)/tau_m + ({current} + i_offset)/cm : mV (unless refractory)",
        "v >= v_thresh",
        "v = v_reset",
    ),
    "AdExp": _Membrane(  # Brette & Gerstner (2005), J Neurophysiol 94:3637
        cells.AdExp,
        """
        upstroke = delta_T*exp(min((v - v_thresh)/delta_T, 200)) : mV
        dv/dt = (v_rest - v + upstroke)/tau_m + ({current} + i_offset - w)/cm : mV (unless refractory)
        dw/dt = (a*(v - v_rest) - w)/tau_w : nA
        """,
        "v > v_spike",
        "v = v_reset; w += b",
    ),
}
_DUAL = """
d{name}_gsyn/dt = ({name}_rise - {name}_gsyn)/{name}_{decay} : uS
d{name}_rise/dt = -{name}_rise/{name}_{rise} : uS
"""
"""Two exponentials, of which an alpha function is the limit."""
_CONDUCTANCE = "{name}_gsyn*({name}_e_syn - v)"
_RESPONSES: Final = {
    "CurrExpPostSynapticResponse": _Response(
        receptors.CurrExpPostSynapticResponse,
        "d{name}_isyn/dt = -{name}_isyn/{name}_tau_syn : nA",
        "{name}_isyn",
        "{name}_isyn",
    ),
    "CondExpPostSynapticResponse": _Response(
        receptors.CondExpPostSynapticResponse,
        "d{name}_gsyn/dt = -{name}_gsyn/{name}_tau_syn : uS",
        _CONDUCTANCE,
        "{name}_gsyn",
    ),
    "CondAlphaPostSynapticResponse": _Response(
        receptors.CondAlphaPostSynapticResponse,
        _DUAL.replace("{decay}", "tau_syn").replace("{rise}", "tau_syn"),
        _CONDUCTANCE,
        "{name}_rise += e*weight",
    ),
    "CondBetaPostSynapticResponse": _Response(
        receptors.CondBetaPostSynapticResponse,
        _DUAL.replace("{decay}", "tau_decay").replace("{rise}", "tau_rise"),
        _CONDUCTANCE,
        # the peak is the weight; where the times are equal this is e*weight
        "{name}_rise += weight*exp(1/exprel(log({name}_tau_rise/{name}_tau_decay)))",
    ),
}
_ALIASES: Final = {
    "ExpPSR": "CondExpPostSynapticResponse", "AlphaPSR": "CondAlphaPostSynapticResponse",
    "BetaPSR": "CondBetaPostSynapticResponse",
}  # fmt: skip
_UNUSED: Final = "locations"
"""A parameter for cells with a shape, which PyNN ignores for others too."""


class _Component:
    """Base of the parts of a composed cell: keeps the values that the script gave."""

    default_parameters: ClassVar[Mapping[str, Any]]
    given: Mapping[str, Any]

    def __init__(self, **parameters: Any) -> None:
        require_names(type(self).__name__, parameters, type(self).default_parameters)
        require_values(type(self).__name__, parameters)
        self.given = {name: value for name, value in parameters.items() if name != _UNUSED}


@cache
def composed_cells() -> dict[str, Any]:
    """Return the parts of composed cells, and the function that composes them, by PyNN's names."""
    parts = {name: _component(name, part.pynn) for name, part in _MEMBRANES.items()}
    parts |= {name: _component(name, part.pynn) for name, part in _RESPONSES.items()}
    aliases = {alias: parts[name] for alias, name in _ALIASES.items()}
    return {**parts, **aliases, _NAME: point_neuron}


def _component(name: str, pynn: Any) -> type:
    body = {
        "__doc__": pynn.__doc__, "default_parameters": pynn.default_parameters,
        "default_initial_values": pynn.default_initial_values, "units": pynn.units,
    }  # fmt: skip
    return type(name, (_Component,), body)


def point_neuron(neuron: Any, **post_synaptic_receptors: Any) -> Any:
    """Return a cell of a membrane and named receptors, for ``sim.Population``.

    The parameters and variables of a receptor have its name before them, e.g. ``AMPA.tau_syn`` and
    ``AMPA.gsyn``.

    Args:
        neuron: the membrane, e.g. ``sim.LIF(tau_m=10.0)``.
        post_synaptic_receptors: the receptors by name, e.g. ``AMPA=sim.AlphaPSR(tau_syn=1.0)``.

    Raises:
        NetworkError: the parts do not make a cell.
    """
    parts = composed_cells()
    membranes, responses = (tuple(parts[name] for name in names) for names in (_MEMBRANES, _RESPONSES))
    require_kind(_NAME, "membrane", neuron, membranes, f"one of {', '.join(_MEMBRANES)}")
    for name, response in post_synaptic_receptors.items():
        require_kind(_NAME, f"receptor '{name}'", response, responses, f"one of {', '.join(_RESPONSES)}")
    kinds = tuple((name, type(response).__name__) for name, response in post_synaptic_receptors.items())
    if len({_RESPONSES[kind].pynn.conductance_based for _, kind in kinds}) > 1:
        raise NetworkError(f"{_NAME}: its receptors must be all conductances or all currents, as in PyNN")
    given = {
        f"{name}.{key}": value
        for name, response in post_synaptic_receptors.items()
        for key, value in response.given.items()
    }
    return _composed(type(neuron).__name__, kinds)(**neuron.given, **given)


@cache
def _composed(neuron: str, kinds: tuple[tuple[str, str], ...]) -> Any:
    """Return the type of the cells with a membrane and receptors (names and kinds)."""
    membrane = _MEMBRANES[neuron]
    responses = {name: _RESPONSES[kind] for name, kind in kinds}
    parameters = dict(_values(membrane.pynn, "default_parameters"))
    state = dict(_values(membrane.pynn, "default_initial_values"))
    for name, response in responses.items():
        for key, value in _values(response.pynn, "default_parameters"):
            parameters[f"{name}.{key}"] = value
        for key, value in _values(response.pynn, "default_initial_values"):
            state[f"{name}.{key}"] = value
    current = " + ".join(response.current.format(name=name) for name, response in responses.items())
    lines = [membrane.equations.format(current=current or "0*nA")]
    lines += [response.equations.format(name=name) for name, response in responses.items()]
    equations = CellEquations(
        equations="\n".join(lines),
        threshold=membrane.threshold,
        reset=membrane.reset,
        refractory="tau_refrac",
        receptors={name: response.effect.format(name=name) for name, response in responses.items()},
        units={own_name(name): parameter.unit for name, parameter in parameters.items()},
    )
    return bound(CellType(_NAME, f"{neuron} with receptors", parameters, state), equations)


def _values(pynn: Any, which: str) -> Iterator[tuple[str, Parameter]]:
    for name, value in getattr(pynn, which).items():
        if name != _UNUSED:
            unit = pynn.units.get(name, "mV" if name.startswith("e_") else "ms")  # PyNN gives receptors none
            yield name, Parameter(value, unit)
