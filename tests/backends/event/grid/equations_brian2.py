"""Makes ``equations_brian2.json``: cells that Brian2 integrates in steps of 5 us by fourth-order Runge-Kutta.

Run it with the environment of the plugin: ``.venv/plugins/brian2/bin/python equations_brian2.py``. The texts
of equations, threshold, reset and refractoriness are given to Brian2 as they are.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import brian2 as b2
import numpy as np

CELLS: dict[str, dict[str, Any]] = {
    "Hodgkin-Huxley": {
        "equations": """
dv/dt = (g_l*(E_l - v) + g_na*m**3*h*(E_na - v) + g_k*n**4*(E_k - v) + i_offset)/C_m : volt
dm/dt = alpha_m*(1 - m) - beta_m*m : 1
dn/dt = alpha_n*(1 - n) - beta_n*n : 1
dh/dt = alpha_h*(1 - h) - beta_h*h : 1
alpha_m = 0.32/mV*4*mV/exprel((13*mV - v + VT)/(4*mV))/ms : Hz
beta_m = 0.28/mV*5*mV/exprel((v - VT - 40*mV)/(5*mV))/ms : Hz
alpha_h = 0.128*exp((17*mV - v + VT)/(18*mV))/ms : Hz
beta_h = 4/(1 + exp((40*mV - v + VT)/(5*mV)))/ms : Hz
alpha_n = 0.032/mV*5*mV/exprel((15*mV - v + VT)/(5*mV))/ms : Hz
beta_n = 0.5*exp((10*mV - v + VT)/(40*mV))/ms : Hz
""",
        "threshold": "v > -20*mV",
        "refractory": "v > -20*mV",
        "parameters": {
            "C_m": "200 pF", "g_l": "10 nS", "g_na": "20 uS", "g_k": "6 uS", "E_l": "-60 mV", "E_na": "50 mV",
            "E_k": "-90 mV", "VT": "-63 mV", "i_offset": "0.5 nA",
        },
        "initial": {"v": "-65 mV", "m": "0.02", "n": "0.1", "h": "0.9"},
    },
    "adaptive exponential": {
        "equations": """
leak = g_L*(E_L - v) : amp
dv/dt = (leak + g_L*D_T*exp(clip((v - V_T)/D_T, -50, 50)) - w + i_offset)/C : volt (unless refractory)
dw/dt = (a*(v - E_L) - w)/tau_w : amp
""",
        "threshold": "v > V_T + 5*D_T",
        "reset": "v = V_r; w += b",
        "refractory": "t_ref",
        "parameters": {
            "C": "281 pF", "g_L": "30 nS", "E_L": "-70.6 mV", "V_T": "-50.4 mV", "D_T": "2 mV", "a": "4 nS",
            "tau_w": "144 ms", "b": "0.0805 nA", "V_r": "-60 mV", "t_ref": "2 ms", "i_offset": "1 nA",
        },
        "initial": {"v": "-70.6 mV"},
    },
}  # fmt: skip
UNTIL_MS, SAMPLE_MS, STEP_US = 80.0, 0.5, 5.0


def value(text: str) -> Any:
    """Return a quantity of Brian2."""
    number, _, unit = text.partition(" ")
    return float(number) * (getattr(b2, unit) if unit else 1.0)


def reference(cell: dict[str, Any]) -> dict[str, Any]:
    """Return spikes and sampled state variables of a cell, in the units of the equations."""
    b2.start_scope()
    b2.defaultclock.dt = STEP_US * b2.us
    refractory = cell.get("refractory", "0 ms")
    refractory = value(refractory) if refractory[0].isdigit() else refractory
    names = {name: value(text) for name, text in cell["parameters"].items()}
    group = b2.NeuronGroup(
        1, cell["equations"], threshold=cell["threshold"], reset=cell.get("reset"),
        refractory=names.get(refractory, refractory) if isinstance(refractory, str) else refractory,
        method="rk4", namespace=names,
    )  # fmt: skip
    for name, text in cell.get("initial", {}).items():
        setattr(group, name, value(text))
    states = sorted(group.equations.diff_eq_names)
    spikes = b2.SpikeMonitor(group)
    samples = b2.StateMonitor(group, states, record=True, dt=SAMPLE_MS * b2.ms)
    network = b2.Network(group, spikes, samples)
    network.run(UNTIL_MS * b2.ms, namespace={})
    return {
        "cell": cell,
        "until_ms": UNTIL_MS,
        "spikes_ms": (np.asarray(spikes.t / b2.ms) + STEP_US * 1e-3).round(6).tolist(),
        "states": {
            name: [float(f"{x:.7g}") for x in np.asarray(getattr(samples, name))[0]] for name in states
        },
    }


if __name__ == "__main__":
    b2.prefs.codegen.target = "numpy"
    found = {name: reference(cell) for name, cell in CELLS.items()}
    target = Path(__file__).with_name("equations_brian2.json")
    target.write_text(json.dumps(found, indent=1) + "\n")
