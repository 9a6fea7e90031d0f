"""A membrane with exponential conductances in the exact mode, against SciPy's method of order 8."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from nrp_core.pynn import new_simulator

CELL = {
    "tau_m": 20.0,
    "cm": 0.2,
    "v_rest": -60.0,
    "v_reset": -60.0,
    "e_rev_E": 0.0,
    "e_rev_I": -80.0,
    "tau_refrac": 5.0,
}
Arrivals = list[tuple[float, float]]


def recorded(
    arrivals: tuple[Arrivals, Arrivals], cell: dict[str, float], end_ms: float
) -> tuple[list[float], list[float]]:
    """Return the spikes of a cell and its voltages at whole ms."""
    sim = new_simulator()
    sim.setup(timestep=1.0)
    target = sim.Population(1, sim.IF_cond_exp(**cell), initial_values={"v": -60.0})
    for receptor, spikes in zip(("excitatory", "inhibitory"), arrivals, strict=True):
        for time, weight in spikes:
            source = sim.Population(1, sim.SpikeSourceArray(spike_times=[time]))
            synapse = sim.StaticSynapse(weight=weight, delay=1.0)
            sim.Projection(source, target, sim.AllToAllConnector(), synapse, receptor_type=receptor)
    target.record(["spikes", "v"])
    sim.run(end_ms)
    segment = target.get_data().segments[0]
    return segment.spiketrains[0].magnitude.tolist(), segment.filter(name="v")[0].magnitude[:, 0].tolist()


def integrated(
    arrivals: tuple[Arrivals, Arrivals], cell: dict[str, float], end_ms: float
) -> tuple[list[float], list[float]]:
    """Return the same from SciPy, by pieces between arrivals, spikes, whole ms and the ends of dead times."""
    events = [(time + 1.0, index, weight) for index, each in enumerate(arrivals) for time, weight in each]
    spikes, voltages, g, v, t, free = [], [], np.zeros(2), -60.0, 0.0, 0.0

    def slope(s: float, y: np.ndarray) -> list[float]:
        left = g * np.exp(-(s - t) / np.array([cell["tau_syn_E"], cell["tau_syn_I"]]))
        current = left @ (np.array([cell["e_rev_E"], cell["e_rev_I"]]) - y[0]) + cell["i_offset"]
        return [(cell["v_rest"] - y[0]) / cell["tau_m"] + current / cell["cm"]]

    def crossing(_: float, y: np.ndarray) -> float:
        return float(y[0] - cell["v_thresh"])

    crossing.terminal, crossing.direction = True, 1.0  # type: ignore[attr-defined]
    marks = sorted({*(time for time, _, _ in events), *np.arange(0.0, end_ms + 1.0).tolist()})
    for mark in marks:
        while t < mark:
            until = min(mark, free) if t < free else mark
            reached = until
            if t >= free:
                found = solve_ivp(slope, (t, until), [v], "DOP853", rtol=1e-13, atol=1e-12, events=crossing)
                v, reached = float(found.y[0, -1]), float(found.t[-1])
            g = g * np.exp(-(reached - t) / np.array([cell["tau_syn_E"], cell["tau_syn_I"]]))
            t = reached
            if v >= cell["v_thresh"] - 1e-9 and t >= free and reached < mark:
                spikes.append(t)
                v, free = cell["v_reset"], t + cell["tau_refrac"]
        for time, index, weight in events:
            if time == mark:
                g[index] += weight
        if mark % 1.0 == 0.0:
            voltages.append(v)
    return spikes, voltages


times = st.floats(0.0, 25.0).map(lambda time: round(time, 2))
spikes_of = st.lists(st.tuples(times, st.sampled_from([0.001, 0.01, 0.05, 0.4])), max_size=6)


@settings(max_examples=15, deadline=None)
@given(
    exc=spikes_of, inh=spikes_of, tau_e=st.sampled_from([0.5, 5.0]), tau_i=st.sampled_from([2.0, 10.0]),
    i_offset=st.sampled_from([0.0, 0.15]), v_thresh=st.sampled_from([-50.0, -10.0]),
)  # fmt: skip
def test_spikes_and_voltages_are_those_of_the_equations(
    exc: Arrivals, inh: Arrivals, tau_e: float, tau_i: float, i_offset: float, v_thresh: float
) -> None:
    cell = {**CELL, "tau_syn_E": tau_e, "tau_syn_I": tau_i, "i_offset": i_offset, "v_thresh": v_thresh}
    spikes, voltages = recorded((exc, inh), cell, 30.0)
    expected, course = integrated((exc, inh), cell, 30.0)
    assert spikes == pytest.approx(expected, abs=1e-6)
    assert voltages == pytest.approx(course, abs=1e-6)


def test_a_voltage_does_not_depend_on_how_often_it_is_read() -> None:
    cell = {**CELL, "tau_syn_E": 5.0, "tau_syn_I": 10.0, "i_offset": 0.1, "v_thresh": -50.0}
    seen = []
    for interval_ms in (0.1, 1.0):
        sim = new_simulator()
        sim.setup(timestep=0.1)
        target = sim.Population(1, sim.IF_cond_exp(**cell))
        source = sim.Population(1, sim.SpikeSourceArray(spike_times=[3.3, 4.7, 8.1]))
        synapse = sim.StaticSynapse(weight=0.02, delay=0.7)
        sim.Projection(source, target, sim.AllToAllConnector(), synapse, receptor_type="excitatory")
        target.record("v", sampling_interval=interval_ms)
        sim.run(20.0)
        values = target.get_data().segments[0].filter(name="v")[0].magnitude[:, 0]
        seen.append(values[:: round(1.0 / interval_ms)].tolist())
    assert seen[0] == seen[1]
