"""How a run is divided leaves no trace; saved states, resets and delays are exact."""

import signal
from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha, PopulationRate, SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import TSODYKS_MARKRAM

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]
Run = Callable[..., Spikes]

END_NS = 60 * NS_PER_MS
few_runs = settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
DRIVEN = {
    "IF_curr_exp": 0.5, "IF_curr_alpha": 0.5, "IF_curr_delta": 2.0, "IF_cond_exp": 0.02,
    "IF_cond_alpha": 0.02, "EIF_cond_exp_isfa_ista": 0.03, "EIF_cond_alpha_isfa_ista": 0.03,
    "Izhikevich": 6.0, "HH_cond_exp": 0.05,
}  # fmt: skip
"""All cell types with the weight of a strong input."""


@pytest.fixture
def crowd(cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open) -> Callable[[], Brain]:
    """Open a brain with every cell type, recurrent connections of all delays and kinds, and devices."""
    rng = np.random.default_rng(11)
    parts: list[Population | Projection] = [spike_source("array", [0.0, 0.5, 12.25, 12.25, 40.0], [7.1])]
    poisson = {"rate": [300.0, 30.0], "start": [5.0, 0.0], "duration": [20.0, inf]}
    parts.append(cells("poisson", "SpikeSourcePoisson", 2, **poisson))
    for cell_type, weight in DRIVEN.items():
        parts.append(cells(cell_type, cell_type, 2))
        for source in ("array", "poisson", *DRIVEN):
            sign = -1.0 if cell_type.startswith("IF_curr") else 1.0
            delays = rng.choice([0.1, 0.35, 1.0, 3.7, 22.0, 80.0], 3)
            parts.append(connect(source, cell_type, weight, delays, pairs=[(0, 0), (1, 0), (0, 1)]))
            facilitating = {"U": 0.4, "tau_rec": 30.0, "tau_facil": 20.0, "kind": TSODYKS_MARKRAM}
            if cell_type != "Izhikevich":
                parts.append(
                    connect(
                        source, cell_type, sign * weight / 2, delays[0], receptor="inhibitory", **facilitating
                    )
                )

    def make() -> Brain:
        brain = open_brain(*parts, seed=5)
        everyone = np.arange(4, brain.network.size)
        for k, (cell_type, weight) in enumerate(DRIVEN.items()):
            source = PoissonSource(rate=400.0, weight=weight, delay=0.1 + k)
            brain.add_source(source, brain.network.neurons(cell_type), name=cell_type)
        brain.add_source(FixedFrequencySource(rate=130.0, weight=0.01, delay=0.0), [5, 9], name="clock")
        brain.add_source(DCSource(amplitude=0.004), everyone, name="current")
        brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="spikes")
        brain.add_sink(LeakyIntegratorAlpha(), everyone, name="integrator")
        brain.add_sink(PopulationRate(), everyone, name="rate")
        return brain

    return make


def seen(brain: Brain) -> tuple[list[float], ...]:
    """Return all that can be seen of a crowd now."""
    *_, recorder, integrator, rate = brain.devices
    spikes = recorder.spikes()
    voltages = brain.read_state("v", np.arange(4, brain.network.size))
    readings = [integrator.voltage, rate.rate]
    return spikes.neurons.tolist(), spikes.times_ms.tolist(), voltages.tolist(), readings


def drive(brain: Brain, t_ns: int) -> None:
    """Change a rate and a current at fixed times on the way to ``t_ns``."""
    for at_ns, rate, amplitude in ((17 * NS_PER_MS, 900.0, 0.006), (33_333_333, 0.0, -0.002)):
        if brain.now_ns <= at_ns < t_ns:
            brain.run_until(at_ns)
            brain.devices[0].rate = rate
            brain.devices[10].amplitude = amplitude
    brain.run_until(t_ns)


@given(cuts=st.lists(st.integers(0, END_NS), max_size=12))
@few_runs
def test_splitting_a_run_does_not_change_a_bit(cuts: list[int], crowd: Callable[[], Brain]) -> None:
    whole, split = crowd(), crowd()
    drive(whole, END_NS)
    for cut in sorted(cuts):
        drive(split, max(cut, split.now_ns))
        split.read_state("v", [4])
    drive(split, END_NS)
    assert len(seen(whole)[0]) > 200
    assert seen(split) == seen(whole)


@given(cut=st.integers(0, END_NS))
@few_runs
def test_a_restored_state_continues_as_if_uninterrupted(cut: int, crowd: Callable[[], Brain]) -> None:
    brain, other = crowd(), crowd()
    drive(brain, cut)
    snapshot = brain.snapshot()
    drive(brain, END_NS)
    first = seen(brain)
    brain.restore(snapshot)
    drive(brain, END_NS)
    other.restore(snapshot)
    drive(other, END_NS)
    assert seen(brain) == first
    assert seen(other) == first


def test_a_reset_brain_is_like_a_fresh_one(crowd: Callable[[], Brain]) -> None:
    fresh, used = crowd(), crowd()
    drive(fresh, END_NS)
    drive(used, END_NS // 3)
    used.reset()
    drive(used, END_NS)
    assert seen(used) == seen(fresh)


def test_two_brains_in_one_process_do_not_see_each_other(crowd: Callable[[], Brain]) -> None:
    alone, one, two = crowd(), crowd(), crowd()
    drive(alone, END_NS)
    for t_ns in range(0, END_NS + 1, 5 * NS_PER_MS):
        drive(one, t_ns)
        drive(two, t_ns // 2)
    assert seen(one) == seen(alone)


@pytest.mark.parametrize("delay_ms", [1e-6, 0.01, 0.1, 0.3, 1.0, 7.31, 300.0])
def test_a_spike_arrives_after_exactly_its_delay(
    delay_ms: float, cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open, spikes_of: Run
) -> None:
    chain = connect("relay", "relay", 100.0, delay_ms, pairs=[(0, 1), (1, 2)])
    brain = open_brain(
        spike_source("source", [0.25]),
        cells("relay", "IF_curr_delta", 3),
        connect("source", "relay", 100.0, 0.0),
        chain,
    )
    spikes = spikes_of(brain, 0.3 + 2 * delay_ms)
    assert spikes.neurons.tolist() == [0, 1, 2, 3]
    assert spikes.times_ms.tolist() == [0.25, 0.25, 0.25 + delay_ms, 0.25 + delay_ms + delay_ms]


def test_events_far_ahead_arrive_in_their_time(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open, spikes_of: Run
) -> None:
    brain = open_brain(
        spike_source("source", [1.0]),
        cells("relay", "IF_curr_delta", 50),
        *(
            replace(connect("source", "relay", 100.0, 0.1 + 97.3 * k, pairs=[(0, k)]), label=f"{k}")
            for k in range(50)
        ),
        connect("relay", "relay", 0.0, 0.1, pairs=[(0, 1)]),
    )
    times_ms = spikes_of(brain, 5000.0).times_ms
    assert times_ms.tolist() == [1.0, *(1.0 + (0.1 + 97.3 * k) for k in range(50))]


def test_a_spike_reaches_each_target_after_its_own_delay_with_its_own_weight(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open
) -> None:
    rng, n = np.random.default_rng(3), 40
    post, delays = rng.integers(0, n, 300), rng.choice([0.5, 2.0, 2.75], 300)
    weights = rng.uniform(-0.1, 0.1, 300)
    synapses = connect("source", "a", weights, delays, pairs=[(0, k) for k in post])
    brain = open_brain(spike_source("source", [1.0]), cells("a", "IF_curr_delta", n), synapses)
    brain.run_until(5 * NS_PER_MS)
    expected = np.full(n, -65.0)
    np.add.at(expected, post, weights * np.exp((1.0 + delays - 5.0) / 20.0))
    assert brain.read_state("v", np.arange(1, n + 1)) == pytest.approx(expected, abs=1e-12)


def test_spikes_in_transit_to_many_targets_keep_their_weights(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open
) -> None:
    n = 3000  # more than there is room for at first

    def voltages(change: bool) -> np.ndarray:
        brain = open_brain(
            spike_source("source", [1.0, 4.5]),
            cells("a", "IF_curr_exp", n),
            connect(
                "source", "a", np.linspace(0.0, 0.1, n), 3.0, pairs=[(0, k) for k in range(n)], label="p"
            ),
        )
        brain.run_until(3 * NS_PER_MS)
        if change:
            brain.set_weights("p", 0.0)
        brain.run_until(7 * NS_PER_MS)
        before = brain.read_state("v", np.arange(1, n + 1))
        brain.run_until(9 * NS_PER_MS)
        return np.stack([before, brain.read_state("v", np.arange(1, n + 1))])

    changed, kept = voltages(True), voltages(False)
    assert (changed[0] == kept[0]).all()
    assert (changed[0, 1:] > -65.0).all()
    assert (changed[1, 1:] < kept[1, 1:]).all()


def test_a_spike_at_the_end_of_a_window_belongs_to_it(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open
) -> None:
    relay = connect("source", "relay", 100.0, 0.0)
    brain = open_brain(spike_source("source", [20.0]), cells("relay", "IF_curr_delta"), relay)
    recorder = brain.add_sink(SpikeRecorder(), [1], name="relay")
    brain.run_until(20 * NS_PER_MS - 1)
    assert len(recorder.spikes()) == 0
    brain.run_until(20 * NS_PER_MS)
    assert recorder.spikes().times_ms.tolist() == [20.0]


def test_a_long_run_can_be_interrupted(cells: Cells, open_brain: Open) -> None:
    brain = open_brain(cells("a", "HH_cond_exp", 200, i_offset=1.0))

    def interrupt(signum: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            brain.run_until(20_000 * NS_PER_MS)
    finally:
        signal.signal(signal.SIGALRM, before)


def test_more_events_and_spikes_than_there_was_room_for_are_all_there(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open, spikes_of: Run
) -> None:
    n = 3000
    brain = open_brain(
        spike_source("source", [1.0, 2.0]),
        cells("relay", "IF_curr_delta", n, tau_refrac=0.0),
        connect("source", "relay", 100.0, 0.5, pairs=[(0, k) for k in range(n)]),
        connect("relay", "relay", 100.0, 5.0, pairs=[(0, k) for k in range(n)]),
    )
    spikes = spikes_of(brain, 8.0)
    assert np.bincount(spikes.neurons).tolist() == [2, *[4] * n]
    assert set(spikes.times_ms.tolist()) == {1.0, 2.0, 1.5, 2.5, 6.5, 7.5}


@pytest.mark.parametrize("cell_type", DRIVEN)
def test_a_cell_at_rest_waits_for_nothing(
    cell_type: str, cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open
) -> None:
    """Silent neurons cost nothing: they are in no list of things to do."""
    weight = DRIVEN[cell_type] / 100
    brain = open_brain(
        cells("a", cell_type), spike_source("b", [1.0]), connect("b", "a", weight), connect("a", "a", 0.0)
    )
    brain.run_until(8000 * NS_PER_MS)
    modes, records = brain._engine.modes, brain._engine.cells
    assert np.where(modes["kind"] < 0, records["wake"], modes["wake"]).tolist() == [inf]
    assert (brain._engine.cell_slots == -1).all()


@pytest.mark.parametrize("cell_type", ["IF_curr_exp", "IF_cond_exp"])
def test_a_spike_of_a_source_may_arrive_at_once(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open, cell_type: str
) -> None:
    """All depends on the time of arrival, so that a later spike without a delay has the same effect."""
    found = []
    for emitted, delay in ((7.0, 0.0), (4.75, 2.25)):
        source = spike_source("s", [emitted])
        brain = open_brain(source, cells("n", cell_type, 1), connect("s", "n", 60 * DRIVEN[cell_type], delay))
        heard = brain.add_sink(SpikeRecorder(), [1], name="heard")
        brain.run_until(END_NS)
        found.append(heard.spikes().times_ms.tolist())
    assert found[0]
    assert found[0] == pytest.approx(found[1], abs=1e-9)


@pytest.mark.parametrize("lazy", ["never", "always"])
@pytest.mark.parametrize("pre", ["s", "a"])
def test_on_a_grid_a_delay_of_0_is_one_step_and_is_reported(
    cells: Cells, spike_source: Cells, connect: Connect, open_brain: Open, pre: str, lazy: str
) -> None:
    found = []
    for delay in (0.1, 0.0):
        population = [spike_source("s", [4.0]), cells("a", "IF_curr_exp", 1), cells("n", "IF_curr_exp", 1)]
        synapses = [connect("s", "a", 50.0, 1.0), replace(connect(pre, "n", 50.0, delay), label="short")]
        brain = open_brain(*population, *synapses, resolution="0.1 ms", lazy=lazy)
        heard = brain.add_sink(SpikeRecorder(), [2], name="heard")
        brain.run_until(END_NS)
        found.append(heard.spikes().times_ms.tolist())
        told = [one.message for one in brain.warnings if "to at least one step" in one.message]
        assert bool(told) == (delay == 0.0)
    assert found[0]
    assert found[0] == found[1]


@pytest.mark.parametrize("changed_ms", [0.7, 1.5, 2.6, 4.0])
def test_a_spike_in_transit_keeps_the_weights_of_all_its_delays(
    changed_ms: float, cells: Cells, connect: Connect, spike_source: Cells, open_brain: Open
) -> None:
    own = cells("cells", "IF_curr_delta", tau_m=1e12, v_rest=0.0, v_thresh=100.0, initial={"v": 0.0})
    delays, weights = np.array([3.0, 1.0, 2.0, 4.5, 2.0, 2.75]), 2.0 ** np.arange(6)
    wires = connect("source", "cells", weights, delays, pairs=[(0, 0)] * 6, label="p")
    brain = open_brain(spike_source("source", [0.5]), own, wires)
    for at_ms in (changed_ms, 4.2, 4.8, 6.0):
        brain.run_until(round(at_ms * NS_PER_MS))
        brain.set_weights("p", 0.0)
        arrived = weights[delays + 0.5 <= at_ms].sum()
        assert brain.read_state("v", brain.network.ids_of("cells")) == pytest.approx([arrived], abs=1e-9)
