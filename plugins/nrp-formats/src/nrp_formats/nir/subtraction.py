"""Cells that subtract a voltage when they fire, in place of those that go to their reset voltage.

They are cells in equations, for backends that have them. Between spikes they are ``IF_curr_delta`` and
``IF_curr_exp``.
"""

from __future__ import annotations

from typing import Any, Final, Literal

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_formats.nir.neurons import Cells

Reset = Literal["value", "subtract", "subtract_next"]
DOWN: Final = "step_down"
_DELTA: Final = "dv/dt = (v_rest - v)/tau_m + i_offset/cm : mV (unless refractory)"
_EXPONENTIAL: Final = """
dv/dt = (v_rest - v)/tau_m + (isyn_exc + i_offset)/cm : mV (unless refractory)
disyn_exc/dt = -isyn_exc/tau_syn_E : nA
"""
_EQUATIONS: Final = {"IF_curr_delta": (_DELTA, "v"), "IF_curr_exp": (_EXPONENTIAL, "isyn_exc")}
_UNITS: Final = {
    "v_rest": "mV", "v_thresh": "mV", DOWN: "mV", "tau_m": "ms", "tau_refrac": "ms", "tau_syn_E": "ms",
    "cm": "nF", "i_offset": "nA",
}  # fmt: skip


def step_down(cells: Cells, threshold: FloatArray, h_ms: float, reset: Reset) -> FloatArray:
    """Return the voltage that cells subtract when they fire.

    Args:
        cells: the cells.
        threshold: their thresholds in the file.
        h_ms: the step of the network.
        reset: ``subtract_next`` if the threshold is subtracted after the decay of the next step, as in
            snnTorch, else before it.
    """
    if reset == "subtract":
        return threshold
    return np.asarray(threshold * np.exp(h_ms / cells.parameters["tau_m"]))


def subtracting(sim: Any, cells: Cells, down: FloatArray) -> Any:
    """Return the cell type of cells that subtract, with their parameters."""
    equations, target = _EQUATIONS[cells.cell_type]
    values = {name: value for name, value in cells.parameters.items() if name in _used(equations)}
    kind = sim.EquationCell(
        equations, threshold="v >= v_thresh", reset=f"v -= {DOWN}", refractory="tau_refrac",
        receptors=dict.fromkeys(("excitatory", "inhibitory"), f"{target} += weight"),
        parameters={name: f"1 {_UNITS[name]}" for name in (*values, DOWN)},
        name=f"{cells.cell_type} that subtracts",
    )  # fmt: skip
    return kind(**{name: value.tolist() for name, value in {**values, DOWN: down}.items()})


def _used(equations: str) -> list[str]:
    return [name for name in _UNITS if name in equations or name in {"v_thresh", "tau_refrac"}]
