"""PyNN's ``IF_cond_exp_gsfa_grr`` against its equations, integrated in very short steps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import NrpError
from nrp_core.pynn import new_simulator

STEP_MS, FINE_MS, END_MS = 0.1, 0.002, 70.0
PARAMETERS = {
    "v_rest": -66.0, "cm": 0.8, "tau_m": 15.0, "tau_refrac": 2.0, "tau_syn_E": 3.0, "tau_syn_I": 7.0,
    "e_rev_E": 1.0, "e_rev_I": -72.0, "v_thresh": -50.0, "v_reset": -64.0, "i_offset": 2.5, "tau_sfa": 60.0,
    "e_rev_sfa": -77.0, "q_sfa": 9.0, "tau_rr": 4.0, "e_rev_rr": -78.0, "q_rr": 300.0,
}  # fmt: skip
ARRIVALS = {"excitatory": (0.06, [12.0, 30.0, 31.5, 80.0]), "inhibitory": (0.05, [50.0, 55.0])}


def by_formula(p: dict[str, float]) -> tuple[Any, list[float]]:
    """Return rows of v, g_s, g_r at the points of the grid, and the times of spikes.

    Muller et al. (2007): conductances decay, and the cell leaks towards the reversal potential of each.
    """
    v, g_s, g_r, g_e, g_i, rest, rows, spikes = p["v_rest"], 0.0, 0.0, 0.0, 0.0, 0.0, [], []
    decay = [np.exp(-FINE_MS / p[tau]) for tau in ("tau_sfa", "tau_rr", "tau_syn_E", "tau_syn_I")]
    for k in range(round(END_MS / FINE_MS) + 1):
        t = k * FINE_MS
        if k % round(STEP_MS / FINE_MS) == 0:
            g_e += sum(ARRIVALS["excitatory"][0] for at in ARRIVALS["excitatory"][1] if abs(at - t) < 1e-6)
            g_i += sum(ARRIVALS["inhibitory"][0] for at in ARRIVALS["inhibitory"][1] if abs(at - t) < 1e-6)
            rows.append((v, g_s, g_r))
        middle = [g * d**0.5 for g, d in zip((g_s, g_r, g_e, g_i), decay, strict=True)]
        conductance = p["cm"] / p["tau_m"] + sum(middle[:2]) * 1e-3 + sum(middle[2:])
        current = p["v_rest"] * p["cm"] / p["tau_m"] + p["i_offset"] + middle[2] * p["e_rev_E"]
        current += middle[3] * p["e_rev_I"] + 1e-3 * (middle[0] * p["e_rev_sfa"] + middle[1] * p["e_rev_rr"])
        if rest <= 1e-9:
            end = current / conductance
            v = end + (v - end) * np.exp(-FINE_MS * conductance / p["cm"])
        rest -= FINE_MS
        g_s, g_r, g_e, g_i = (g * d for g, d in zip((g_s, g_r, g_e, g_i), decay, strict=True))
        if v > p["v_thresh"]:
            spikes.append(t + FINE_MS)
            v, rest, g_s, g_r = p["v_reset"], p["tau_refrac"], g_s + p["q_sfa"], g_r + p["q_rr"]
    return np.array(rows), spikes


def by_backend(given: dict[str, float]) -> tuple[Any, Any]:
    sim = new_simulator()
    sim.setup(timestep=STEP_MS, options={"resolution": f"{STEP_MS} ms"})
    cells = sim.Population(1, sim.IF_cond_exp_gsfa_grr(**given), initial_values={"v": given["v_rest"]})
    for receptor, (weight, times) in ARRIVALS.items():
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[t - 1.0 for t in times]))
        synapse = sim.StaticSynapse(weight=weight, delay=1.0)
        sim.Projection(source, cells, sim.OneToOneConnector(), synapse, receptor_type=receptor)
    cells.record(["spikes", "v", "g_s", "g_r"])
    sim.run(END_MS)
    data = cells.get_data().segments[0]
    columns = [np.asarray(data.filter(name=name)[0])[:, 0] for name in ("v", "g_s", "g_r")]
    return np.stack(columns, axis=1), np.asarray(data.spiketrains[0])


@pytest.mark.heavy
def test_it_adapts_as_its_equations_say() -> None:
    rows, spikes = by_backend(PARAMETERS)
    expected, times = by_formula(PARAMETERS)
    assert len(spikes) == len(times) > 4
    assert (spikes - times).min() > -0.02  # a spike is at the next point of the grid
    assert (spikes - times).max() < STEP_MS + 0.02
    near = [abs(np.arange(len(rows)) * STEP_MS - t).min() for t in times]
    assert max(near) <= STEP_MS
    far = np.all([abs(np.arange(len(rows)) * STEP_MS - t) > STEP_MS for t in times], axis=0)
    apart = np.abs(rows - expected)[far].max(axis=0)
    assert (apart < (0.05, 0.01, 2.0)).all()
    for name in ("q_sfa", "q_rr", "tau_rr"):  # each of these matters
        other, _ = by_formula({**PARAMETERS, name: 1.1 * PARAMETERS[name]})
        assert (np.abs(rows - other)[far].max(axis=0) > 2 * apart).any()


def test_backends_without_equations_refuse_it_by_name(golden: Golden) -> None:
    sim = new_simulator()
    sim.setup(timestep=STEP_MS, backend="spinnaker")
    sim.Population(1, sim.IF_cond_exp_gsfa_grr(), label="adapting")
    with golden.raises(NrpError):
        sim.run(1.0)
