"""The cost of cells given as equations, against the built-in cells with the same equations, on the grid.

    python benchmarks/equation_cells.py
    python benchmarks/equation_cells.py iaf_psc_exp_neuron.nestml    # also a neuron of NESTML's own files

Both run in turn, in one process: cells that differ in their current, with Poisson input. Beside the neuron
of NESTML, which fires the same spikes, all cells have one current; it needs the distribution nrp-nestml. Last
come large networks that are mostly silent, as a fly's brain, on the lazy grid: the built-in cell of such a
brain against its equations, and against these with adaptation.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

from conditions import conditions

from nrp_core.pynn import new_simulator

N_SOURCES, N_CELLS, RATE_HZ, RUN_MS, ROUNDS = 200, 4000, 20.0, 2000.0, 5
_CURRENT: Final = """
dv/dt = (v_rest - v)/tau_m + (isyn_exc + isyn_inh + i_offset)/cm : mV (unless refractory)
disyn_exc/dt = -isyn_exc/tau_syn_E : nA
disyn_inh/dt = -isyn_inh/tau_syn_I : nA
"""
_CONDUCTANCES: Final = """
dgsyn_exc/dt = -gsyn_exc/tau_syn_E : uS
dgsyn_inh/dt = -gsyn_inh/tau_syn_I : uS
isyn = gsyn_exc*(e_rev_E - v) + gsyn_inh*(e_rev_I - v) : nA
"""
_ADAPTIVE: Final = """
upstroke = delta_T*exp(min((v - v_thresh)/delta_T, 200)) : mV
dv/dt = (v_rest - v + upstroke)/tau_m + (isyn + i_offset - w)/cm : mV (unless refractory)
dw/dt = (a*(v - v_rest) - w)/tau_w : nA
"""
_LEAKY: Final = "dv/dt = (v_rest - v)/tau_m + (isyn + i_offset)/cm : mV (unless refractory)"
_RESET: Final = {"reset": "v = v_reset", "refractory": "tau_refrac"}
CELLS: Final[dict[str, dict[str, Any]]] = {
    "IF_curr_exp": {
        "equations": _CURRENT, "threshold": "v >= v_thresh", **_RESET,
        "receptors": {"excitatory": "isyn_exc", "inhibitory": "isyn_inh"},
    },
    "IF_cond_exp": {
        "equations": _LEAKY + _CONDUCTANCES, "threshold": "v >= v_thresh", **_RESET,
        "receptors": {"excitatory": "gsyn_exc", "inhibitory": "gsyn_inh"},
    },
    "EIF_cond_exp_isfa_ista": {
        "equations": _ADAPTIVE + _CONDUCTANCES, "threshold": "v > v_spike", "reset": "v = v_reset; w += b",
        "refractory": "tau_refrac", "receptors": {"excitatory": "gsyn_exc", "inhibitory": "gsyn_inh"},
    },
}  # fmt: skip
"""Equations of built-in cells."""
_NESTML: Final = {
    "C_m": 1000.0, "tau_m": 20.0, "tau_syn_exc": 5.0, "tau_syn_inh": 5.0, "refr_T": 0.1, "E_L": -65.0,
    "V_reset": -65.0, "V_th": -50.0, "I_e": 800.0,
}  # fmt: skip
"""With these NESTML's iaf_psc_exp_neuron is the default IF_curr_exp with a current of 0.8 nA."""
N_SPARSE, N_SYNAPSES, N_DRIVEN, UNIT_MV = 20_000, 2_200_000, 20, 0.275
_FLY: Final = {
    "v_rest": -52.0, "v_reset": -52.0, "v_thresh": -45.0, "tau_m": 20.0, "cm": 0.02, "tau_refrac": 2.2,
    "tau_syn_E": 5.0, "tau_syn_I": 5.0,
}  # fmt: skip
_FROZEN: Final = """
dv/dt = (v_rest - v + g - R*w)/tau_m : mV (unless refractory)
dg/dt = -g/tau_syn_E : mV (unless refractory)
"""
_ADAPTATION: Final[dict[str, tuple[str, str, dict[str, str]]]] = {
    "without adaptation": (_FROZEN.replace(" - R*w", ""), "", {}),
    "with adaptation": (
        _FROZEN + "dw/dt = (a*(v - v_rest) - w)/tau_w : nA", "; w += b",
        {"R": "1000 Mohm", "a": "0.2 nS", "b": "0.0005 nA", "tau_w": "100 ms"},
    ),
}  # fmt: skip
"""Equations, what a spike does besides, and parameters, of cells like those of a fly's brain."""


def equation_cell(sim: Any, name: str) -> Any:
    """Return a built-in cell as equations, with the same parameters and initial values."""
    kind = getattr(sim, name)
    parameters = {key: f"{value!r} {kind.units[key]}" for key, value in kind.default_parameters.items()}
    initial = {
        key: f"{value!r} {kind.units[key]}"
        for key, value in kind.default_initial_values.items()
        if f"d{key}/dt" in CELLS[name]["equations"]
    }
    return sim.EquationCell(**CELLS[name], parameters=parameters, initial=initial)


def cost(name: str, *, own: bool, nestml: str = "") -> tuple[float, int]:
    """Return the CPU time (s) of a run, and the number of spikes of the cells."""
    sim = new_simulator()
    sim.setup(timestep=0.1, seed=3, options={"resolution": "0.1 ms"})
    noise = sim.Population(N_SOURCES, sim.SpikeSourcePoisson(rate=RATE_HZ))
    currents = 0.8 if nestml else sim.RandomDistribution("uniform", (0.4, 0.8))
    kind, weight = getattr(sim, name), 0.05 if "_curr_" in name else 0.001
    if own and nestml:  # in pA and pF
        cells = sim.Population(N_CELLS, sim.nestml_cell(nestml)(**_NESTML))
        cells.initialize(V_m=_NESTML["E_L"])  # else the resting potential of the file
        weight *= 1000.0
    else:
        cells = sim.Population(N_CELLS, (equation_cell(sim, name) if own else kind)(i_offset=currents))
    synapse = sim.StaticSynapse(weight=weight, delay=1.0)
    sim.Projection(noise, cells, sim.FixedProbabilityConnector(0.05), synapse)
    return _run(sim, cells)


def adapting_cell(sim: Any, which: str) -> Any:
    """Return the cell of a fly's brain as equations; a step less refractory, as the built-in one."""
    equations, more, parameters = _ADAPTATION[which]
    units = {name: "nF" if name == "cm" else "ms" if "tau" in name else "mV" for name in _FLY}
    known = {name: f"{value!r} {units[name]}" for name, value in {**_FLY, "tau_refrac": 2.1}.items()}
    return sim.EquationCell(
        equations, "v > v_thresh", f"v = v_reset; g = 0*mV{more}", "tau_refrac",
        receptors={"excitatory": "g", "inhibitory": "g"}, parameters={**known, **parameters},
    )()  # fmt: skip


def sparse_cost(which: str, *, own: bool) -> tuple[float, int]:
    """Return the CPU time (s) of a run of cells that are mostly silent, and the number of their spikes."""
    sim = new_simulator()
    sim.setup(timestep=0.1, seed=3, options={"resolution": "0.1 ms"})
    kind = adapting_cell(sim, which) if own else sim.IF_curr_exp_frozen(**_FLY)
    cells = sim.Population(N_SPARSE, kind, initial_values={"v": _FLY["v_rest"]})
    kicks = sim.Population(N_DRIVEN, sim.SpikeSourcePoisson(rate=150.0))
    sim.Projection(kicks, cells, sim.OneToOneConnector(), sim.StaticSynapse(weight=20_000.0, delay=0.1))
    for receptor, share, sign in (("excitatory", 0.65, 1.0), ("inhibitory", 0.35, -1.0)):
        weights = sim.RandomDistribution("uniform", sorted((0.0, 6.0 * sign * UNIT_MV)))
        synapse = sim.StaticSynapse(weight=weights, delay=1.8)
        connector = sim.FixedTotalNumberConnector(int(share * N_SYNAPSES))
        sim.Projection(cells, cells, connector, synapse, receptor_type=receptor)
    return _run(sim, cells)


def _run(sim: Any, cells: Any) -> tuple[float, int]:
    """Return the CPU time (s) of a run after the first step, and the number of spikes of the cells."""
    cells.record("spikes")
    sim.run(1.0)
    began = time.process_time()
    sim.run(RUN_MS)
    taken = time.process_time() - began
    n_spikes = int(cells.get_data().segments[0].spiketrains.multiplexed[1].size)
    sim.end()
    return taken, n_spikes


def print_ratios(name: str, measure: Callable[..., tuple[float, int]]) -> None:
    """Print rounds in which what is built in and the same as equations run in turn.

    Args:
        name: what is compared.
        measure: returns CPU time (s) and number of spikes, for ``own=False`` and ``own=True``.
    """
    ratios = []
    for k in range(ROUNDS + 1):
        built_in, n_built_in = measure(own=False)
        own, n_own = measure(own=True)
        if k == 0:  # compiles
            continue
        ratios.append(own / built_in)
        print(
            f"{name}: {built_in:.3f} s and {n_built_in} spikes built in, "
            f"{own:.3f} s and {n_own} spikes as equations, ratio {ratios[-1]:.2f}", flush=True,
        )  # fmt: skip
    print(f"{name}: median {statistics.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")


def main() -> None:
    """Print all rounds, and the ratio of each pair."""
    parser = argparse.ArgumentParser(description="Compare cells in equations with built-in ones.")
    parser.add_argument("nestml", nargs="?", help="iaf_psc_exp_neuron.nestml")
    nestml = parser.parse_args().nestml
    print(conditions())
    for name in CELLS:
        print_ratios(name, partial(cost, name))
    if nestml:
        print_ratios("NESTML's iaf_psc_exp", partial(cost, "IF_curr_exp", nestml=nestml))
    for which in _ADAPTATION:
        print_ratios(f"mostly silent, {which}", partial(sparse_cost, which))


if __name__ == "__main__":
    main()
