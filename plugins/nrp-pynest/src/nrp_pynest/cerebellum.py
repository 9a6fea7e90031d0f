"""Models of the NEST module ``cerebellummodule``, as PyNN finds them, with NEST's names and units.

https://github.com/jgarridoalcazar/SpikingCerebellum; its learning rules are not among them.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

_LEAKY = """
dv/dt = (g_L*(E_L - v) + g_ex*(E_ex - v) + g_in*(E_in - v) + g_{own}*(e_{own} - v) + i_offset)/C_m : mV (unless refractory)
dg_ex/dt = -g_ex/tau_syn_ex : uS
dg_in/dt = -g_in/tau_syn_in : uS
dg_{own}/dt = -g_{own}/tau_syn_{own} : uS
"""  # noqa: E501 - one equation
_VALUES = {
    "C_m": "250 pF", "g_L": "16.6667 nS", "E_L": "-70 mV", "V_th": "-55 mV", "V_reset": "-60 mV",
    "t_ref": "2 ms", "E_ex": "0 mV", "E_in": "-85 mV", "tau_syn_ex": "0.2 ms", "tau_syn_in": "2 ms",
    "i_offset": "0 pA",
}  # fmt: skip
_SIGNALS = {"iaf_cond_exp_cs": ("cs", "COMPLEX_SPIKE"), "iaf_cond_exp_cos": ("ts", "TEACHING_SIGNAL")}
"""The cells with a third receptor: the end of the names of its parameters, and its name."""
_DRIVEN = "cd_poisson_generator"
"""A source whose rate follows the injected current."""
CEREBELLAR = (*_SIGNALS, _DRIVEN)
"""The names of the models."""


def cerebellar_cell(sim: ModuleType, name: str) -> type:
    """Return the PyNN cell type of a model.

    Args:
        sim: the simulator of PyNN.
        name: one of :data:`CEREBELLAR`.
    """
    base: Any = _driven(sim) if name == _DRIVEN else _leaky(sim, name, *_SIGNALS[name])

    def begin(self: Any, **given: Any) -> None:
        base.__init__(self, **{"i_offset" if key == "I_e" else key: value for key, value in given.items()})

    return type(name, (base,), {"__init__": begin})


def _leaky(sim: ModuleType, name: str, own: str, receptor: str) -> type:
    cell: type = sim.EquationCell(
        _LEAKY.format(own=own),
        threshold="v >= V_th", reset="v = V_reset", refractory="t_ref",
        parameters={**_VALUES, f"e_{own}": "0 mV", f"tau_syn_{own}": "5 ms"},
        receptors={"AMPA": "g_ex", "GABA": "g_in", receptor: f"g_{own}"},
        initial={"v": "-70 mV"}, name=name,
    )  # fmt: skip
    return cell


def _driven(sim: ModuleType) -> type:
    cell: type = sim.EquationCell(
        """
        share = clip((i_offset - min_current)/(max_current - min_current), 0, 1) : 1
        rate = min_rate + (max_rate - min_rate)*share : Hz (recorded)
        dx/dt = 0/ms : 1
        """,
        threshold="rand() < -expm1(-rate*dt)",
        parameters={
            "min_rate": "1 Hz", "max_rate": "10 Hz", "min_current": "0 pA", "max_current": "1 pA",
            "i_offset": "0 pA",
        },
        name=_DRIVEN,
    )  # fmt: skip
    return cell
