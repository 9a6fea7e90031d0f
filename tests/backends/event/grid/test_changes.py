"""What changes while a grid runs, against the exact mode within the grid's resolution."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend

from nrp_core.brain import builder
from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import from_milliseconds
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM

Cells = Callable[..., Population]
Open = Callable[..., Brain]
FINE = {"resolution": "0.002 ms"}
STEP_MS = 0.002
PLASTICITY = {"timing": "SpikePairRule", "weight": "AdditiveWeightDependence"}
RULE = {"A_plus": 0.02, "A_minus": 0.015, "tau_plus": 20.0, "tau_minus": 15.0, "w_min": 0.0, "w_max": 2.0}


def run(brain: Brain, until_ms: float) -> None:
    brain.run_until(from_milliseconds(until_ms))


def alike(exact: Spikes, grid: Spikes, within_ms: float) -> None:
    for neuron in np.union1d(exact.neurons, grid.neurons):
        times, others = (s.times_ms[s.neurons == neuron] for s in (exact, grid))
        assert len(times) == len(others), neuron
        np.testing.assert_allclose(times, others, atol=within_ms, rtol=0.0)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("cell_type", "drive", "weight", "changes"),
    [
        ("IF_curr_exp", 1.1, 1.0, {"tau_m": 12.0, "v_rest": -63.0, "tau_syn_E": 2.0, "cm": 0.7}),
        ("IF_curr_alpha", 1.1, 1.0, {"tau_syn_E": 2.0, "v_thresh": -51.0, "v_reset": -60.0}),
        ("IF_curr_delta", 1.1, 2.0, {"i_offset": 1.5, "tau_refrac": 7.0}),
        ("IF_cond_exp", 1.1, 0.02, {"e_rev_E": -20.0, "tau_m": 15.0, "tau_syn_E": 9.0}),
        ("IF_cond_alpha", 1.1, 0.02, {"tau_syn_E": 2.0, "i_offset": 1.3}),
        ("Izhikevich", 0.012, 3.0, {"d": 4.0, "i_offset": 0.015}),
        ("EIF_cond_exp_isfa_ista", 0.9, 0.01, {"b": 0.02, "tau_syn_E": 2.0}),
    ],
)
def test_parameters_change_as_in_the_exact_mode(
    cell_type: str, drive: float, weight: float, changes: dict[str, float],
    cells: Cells, spike_source: Cells, connect: Callable[..., Projection], open_brain: Open,
) -> None:  # fmt: skip
    parts = (
        cells("cells", cell_type, 4, i_offset=drive * np.array([1.0, 1.02, 1.04, 1.06])),
        spike_source("in", [12.0, 39.0, 39.7, 61.0]),
        connect("in", "cells", weight, [0.5, 1.0, 1.5, 2.0], pairs=[(0, i) for i in range(4)]),
    )
    seen = []
    for options in ({}, FINE):
        brain = open_brain(*parts, **options)
        recorder = brain.add_sink(SpikeRecorder(), np.arange(4), name="spikes")
        run(brain, 40.0)
        brain.set_parameters([1, 3], changes)
        voltages = [brain.read_state("v", [0, 1, 2, 3])]
        run(brain, 43.0)
        voltages.append(brain.read_state("v", [0, 1, 2, 3]))
        run(brain, 80.0)
        seen.append((recorder.spikes(), np.array(voltages)))
    (exact, exact_v), (grid, grid_v) = seen
    alike(exact, grid, 30 * STEP_MS)  # each spike is late by up to a step, which adds up
    assert len(exact) > 3
    np.testing.assert_allclose(exact_v, grid_v, atol=0.1 if cell_type == "Izhikevich" else 0.02)


@pytest.mark.one_of(3)
@pytest.mark.parametrize(("before", "after"), [(20.0, 3.0), (3.0, 20.0)])
def test_waiting_cells_keep_their_refractory_time_and_later_spikes_get_the_new_one(
    before: float, after: float, cells: Cells, open_brain: Open
) -> None:
    part = cells("cells", "IF_curr_exp", 40, tau_refrac=before, i_offset=np.linspace(2.0, 6.0, 40))
    seen = []
    for options in ({}, FINE):
        brain = open_brain(part, **options)
        recorder = brain.add_sink(SpikeRecorder(), np.arange(40), name="spikes")
        run(brain, 9.0)  # some have fired, some will soon
        assert 5 < len(recorder.spikes()) < 80
        brain.set_parameters(np.arange(40), {"tau_refrac": after})
        run(brain, 60.0)
        seen.append(recorder.spikes())
    alike(*seen, within_ms=20 * STEP_MS)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("kind", ["equal", "own", "tsodyks_markram"])
def test_weights_change_for_later_spikes_only(
    kind: str, cells: Cells, spike_source: Cells, connect: Callable[..., Projection], open_brain: Open
) -> None:
    """Spikes on their way, of one delay each, keep the weights with which they passed."""
    plastic = {"kind": TSODYKS_MARKRAM, "U": [0.5, 0.4, 0.3, 0.6], "tau_rec": 60.0, "tau_facil": 20.0}
    parts = (
        cells("cells", "IF_curr_exp", 2),
        spike_source("in", [5.0, 9.5, 12.0, 21.0], [9.0, 9.9, 25.0]),
        connect(
            "in", "cells", 0.2 if kind == "equal" else [0.2, 0.3, 0.1, 0.4], [6.0, 1.014, 1.008, 2.0],
            label="p", pairs=[(0, 0), (0, 1), (0, 0), (1, 1)], **(plastic if kind == TSODYKS_MARKRAM else {}),
        ),
        connect("in", "cells", 0.2, 3.0, pairs=[(1, 0), (0, 1)], label="other"),
    )  # fmt: skip
    seen = []
    for options in ({}, FINE):
        brain = open_brain(*parts, **options)
        voltages = []
        for t_ms in range(1, 40):
            run(brain, float(t_ms))
            voltages.append(brain.read_state("v", [0, 1]))
            if t_ms == 10:
                brain.set_weights("p", [0.5, 0.0, 0.6, 0.1])
                assert brain.read_weights("p").tolist() == [0.5, 0.0, 0.6, 0.1]
        seen.append(np.array(voltages))
    np.testing.assert_allclose(*seen, atol=2e-3)
    assert np.ptp(seen[0]) > 0.5


@pytest.mark.one_of(3)
@pytest.mark.parametrize("resolution", ["0.1 ms", "1 ms"])
def test_a_snapshot_keeps_changes_and_a_reset_undoes_them(
    resolution: str, cells: Cells, connect: Callable[..., Projection], open_brain: Open
) -> None:
    rng = np.random.default_rng(3)
    pairs = [(int(i), int(j)) for i, j in rng.integers(0, 30, (300, 2))]
    part = cells("cells", "IF_curr_exp", 30, i_offset=rng.uniform(0.9, 1.6, 30))
    delays = rng.integers(1, 8, 300).astype(float)
    projections = (
        connect("cells", "cells", 0.1, delays, pairs=pairs, label="static"),
        connect("cells", "cells", 0.4, delays, pairs=pairs, kind=TSODYKS_MARKRAM, label="dynamic",
                U=0.4, tau_rec=50.0, tau_facil=5.0),
        connect("cells", "cells", 0.3, delays, pairs=pairs, kind=STDP, label="plastic", plasticity=PLASTICITY,
                dendritic_delay_fraction=0.5, **RULE),
    )  # fmt: skip
    brain = open_brain(part, *projections, resolution=resolution)

    recorder = brain.add_sink(SpikeRecorder(), np.arange(30), name="spikes")

    def go(until_ms: float) -> tuple[Any, ...]:
        run(brain, until_ms)
        spikes = recorder.spikes()
        state = brain.read_state("v", np.arange(30)), brain.read_weights("plastic")
        return spikes.neurons.tolist(), spikes.times_ms.tolist(), *(values.tolist() for values in state)

    first = go(60.0)
    brain.set_parameters([0, 4, 5], {"tau_m": [10.0, 12.0, 14.0], "tau_refrac": 3.0, "tau_syn_E": 2.0})
    brain.set_weights("static", rng.uniform(0.0, 0.2, 300))
    brain.set_weights("plastic", brain.read_weights("plastic") * 1.1)
    run(brain, 90.0)
    snapshot = brain.snapshot()
    following = go(150.0)
    assert len(following[0]) > 30
    weights = brain.read_weights("static")
    brain.reset()
    assert (brain.read_weights("static") == 0.1).all()
    assert go(60.0) == first
    brain.restore(snapshot)
    assert (brain.read_weights("static") == weights).all()
    assert go(150.0) == following


def test_poisson_cells_drawn_as_counts_do_not_change(
    cells: Cells, connect: Callable[..., Projection], open_brain: Open, golden: Golden
) -> None:
    rate = {"rate": np.full(3, 50.0), "start": np.zeros(3), "duration": np.full(3, 1e9)}
    noise = Population("noise", 3, "SpikeSourcePoisson", rate)
    brain = open_brain(
        cells("cells", "IF_curr_exp", 3), noise,
        connect("noise", "cells", 0.1, pairs=[(i, i) for i in range(3)]), resolution="0.1 ms", poisson="grid",
    )  # fmt: skip
    with golden.raises(CapabilityError, match="'noise'"):
        brain.set_parameters(brain.network.ids_of("noise"), {"rate": 70.0})


def test_synapses_of_one_step_keep_their_own_short_term_plasticity(
    cells: Cells, spike_source: Cells, connect: Callable[..., Projection], open_brain: Open
) -> None:
    """Delays that round to one step, in another order than the targets."""
    parts = (
        cells("cells", "IF_curr_exp", 3),
        spike_source("in", [5.0, 9.0, 14.0]),
        connect(
            "in", "cells", 0.2, [1.004, 1.002, 0.998], pairs=[(0, 0), (0, 1), (0, 2)],
            kind=TSODYKS_MARKRAM, U=[0.9, 0.5, 0.1], tau_rec=[300.0, 100.0, 10.0], tau_facil=0.0,
        ),
    )  # fmt: skip
    exact, grid = (open_brain(*parts, **options) for options in ({}, FINE))
    for brain in (exact, grid):
        run(brain, 17.0)
    np.testing.assert_allclose(*(brain.read_state("v", [0, 1, 2]) for brain in (exact, grid)), atol=1e-3)


def test_spikes_on_the_way_to_plastic_synapses_survive_a_snapshot_after_a_change_of_weights() -> None:
    sim = builder()
    sim.setup(timestep=0.1)
    sources = sim.Population(2, sim.SpikeSourceArray(spike_times=[1.0, 2.0, 5.0]))
    cells = sim.Population(2, sim.IF_curr_exp())
    learning = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(A_plus=0.01, A_minus=0.01),
        weight_dependence=sim.AdditiveWeightDependence(w_max=9.0),
        dendritic_delay_fraction=0.0, weight=1.0, delay=4.0,
    )  # fmt: skip
    sim.Projection(sources, cells, sim.AllToAllConnector(), learning, label="p")
    network, backend = sim.network(), EventBackend()
    options = backend.options(resolution="0.1 ms", lazy="never")
    with (
        backend.open(network, seed=1, options=options) as one,
        backend.open(network, seed=1, options=options) as other,
    ):
        one.run_until(3_000_000)
        one.set_weights("p", np.full(4, 2.0))
        other.restore(one.snapshot())
        one.run_until(20_000_000)
        other.run_until(20_000_000)
        assert one.read_state("v", [2, 3]).tolist() == other.read_state("v", [2, 3]).tolist()
        assert (one.read_state("v", [2, 3]) > -64.0).all()
