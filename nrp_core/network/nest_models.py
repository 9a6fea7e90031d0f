"""NEST's point neurons as PyNN's cells: parameters, units (pF, nS, pA) and defaults.

The defaults are those that NEST's documentation lists.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nrp_core.network.cells import CELLS, PEAK_MV

_KILO = 1e-3
"""pF to nF, pA to nA, nS to uS."""


@dataclass(frozen=True, slots=True)
class NestParameter:
    """The source of a parameter.

    Args:
        name: its name in the file.
        scale: the factor from its unit to PyNN's.
        default: its default in the file's unit.
    """

    name: str
    scale: float
    default: float


@dataclass(frozen=True, slots=True)
class CellModel:
    """A model of a cell.

    Args:
        cell_type: PyNN's cell type.
        parameters: parameters by PyNN name; omitted ones have PyNN's name and default.
        weight_scale: the factor from the file's unit to PyNN's.
        leaks: whether a leak may take the place of its membrane time constant.
        initial: the state variables that the file may set, by PyNN name.
        fixed: parameters of the file that must have one value, since the cell has no such parameter.
    """

    cell_type: str
    parameters: Mapping[str, NestParameter]
    weight_scale: float = 1.0
    leaks: bool = False
    initial: Mapping[str, NestParameter] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)

    @property
    def names(self) -> set[str]:
        """The names of its parameters in the file."""
        given = {one.name for one in (*self.parameters.values(), *self.initial.values())}
        return given | self.fixed.keys() | (CELLS[self.cell_type].parameters.keys() - self.parameters.keys())


def _lif(v_reset: float = -70.0) -> dict[str, NestParameter]:
    return {
        "cm": NestParameter("C_m", _KILO, 250.0),
        "tau_m": NestParameter("tau_m", 1.0, 10.0),
        "tau_refrac": NestParameter("t_ref", 1.0, 2.0),
        "v_rest": NestParameter("E_L", 1.0, -70.0),
        "v_reset": NestParameter("V_reset", 1.0, v_reset),
        "v_thresh": NestParameter("V_th", 1.0, -55.0),
        "i_offset": NestParameter("I_e", _KILO, 0.0),
    }


def _synapses(excitatory: float, inhibitory: float) -> dict[str, NestParameter]:
    return {
        "tau_syn_E": NestParameter("tau_syn_ex", 1.0, excitatory),
        "tau_syn_I": NestParameter("tau_syn_in", 1.0, inhibitory),
    }


_REVERSAL = {"e_rev_E": NestParameter("E_ex", 1.0, 0.0), "e_rev_I": NestParameter("E_in", 1.0, -85.0)}
_CONDUCTANCE = {**_lif(v_reset=-60.0), **_synapses(0.2, 2.0), **_REVERSAL}
_ADAPTIVE = {
    **_CONDUCTANCE,
    "cm": NestParameter("C_m", _KILO, 281.0),
    "tau_refrac": NestParameter("t_ref", 1.0, 0.0),
    "v_rest": NestParameter("E_L", 1.0, -70.6),
    "v_thresh": NestParameter("V_th", 1.0, -50.4),
    "a": NestParameter("a", 1.0, 4.0),
    "b": NestParameter("b", _KILO, 80.5),
    "delta_T": NestParameter("Delta_T", 1.0, 2.0),
    "tau_w": NestParameter("tau_w", 1.0, 144.0),
    "v_spike": NestParameter("V_peak", 1.0, 0.0),
}
_IZHIKEVICH = CellModel(
    "Izhikevich",
    {
        "i_offset": NestParameter("I_e", _KILO, 0.0),
        **{
            name: NestParameter(name, 1.0, value)
            for name, value in zip("abcd", (0.02, 0.2, -65.0, 8.0), strict=True)
        },
    },
    initial={"v": NestParameter("V_m", 1.0, -65.0), "u": NestParameter("U_m", 1.0, -13.0)},
    fixed={"V_th": PEAK_MV},
)
LEAK_NS = {"iaf_cond_exp": 16.6667, "iaf_cond_alpha": 16.6667, "aeif_cond_exp": 30.0, "aeif_cond_alpha": 30.0}
"""Default leak conductance of models that have one instead of a membrane time constant."""


def _leaky(cell_type: str, parameters: Mapping[str, NestParameter], weight_scale: float = _KILO) -> CellModel:
    """Return a model whose membrane starts at the default E_L, as in NEST, whatever its own E_L is."""
    initial = {"v": NestParameter("V_m", 1.0, parameters["v_rest"].default)}
    return CellModel(cell_type, parameters, weight_scale, leaks=True, initial=initial)


NEST_CELLS: Mapping[str, CellModel] = {
    "iaf_psc_exp": _leaky("IF_curr_exp", {**_lif(), **_synapses(2.0, 2.0)}),
    "iaf_psc_alpha": _leaky("IF_curr_alpha", {**_lif(), **_synapses(2.0, 2.0)}),
    "iaf_psc_delta": _leaky("IF_curr_delta", _lif(), 1.0),
    "iaf_cond_exp": _leaky("IF_cond_exp", _CONDUCTANCE),
    "iaf_cond_alpha": _leaky("IF_cond_alpha", _CONDUCTANCE),
    "aeif_cond_exp": _leaky("EIF_cond_exp_isfa_ista", _ADAPTIVE),
    "aeif_cond_alpha": _leaky("EIF_cond_alpha_isfa_ista", _ADAPTIVE),
    "izhikevich": _IZHIKEVICH,
}
"""NEST's cells by their NEST names."""
