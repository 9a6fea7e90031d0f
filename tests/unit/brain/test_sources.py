"""Devices that drive: statistics, streams by name, and no trace of how a run was divided."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.source_cells import PopulationTrains
from nrp_core.brain.devices.sources import (
    DCSource,
    FixedFrequencySource,
    PoissonSource,
    SourceSpec,
    SpikeInjector,
)  # fmt: skip
from nrp_core.brain.spikes import Spikes
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Population
from nrp_core.network.pynn import builder
from nrp_core.seeds import Seeds

SEEDS = Seeds(7).child("test")
ENDLESS = 1e12
SPIKING = (PoissonSource(rate=700.0, n=2), FixedFrequencySource(rate=90.0, delay=2.5))
cuts = st.lists(st.floats(0.0, 200.0), max_size=8)


def opened(spec: SourceSpec, *neurons: int, name: str = "source", seeds: Seeds = SEEDS) -> Any:
    return spec.open(np.array(neurons or (3,)), seeds, name)


def emitted(port: Any, *times_ms: float) -> list[tuple[float, int]]:
    """Return arrivals and neurons of all windows between the times."""
    seen: list[tuple[float, int]] = []
    for since_ms, until_ms in pairwise(times_ms):
        events = port.events(since_ms, until_ms)
        seen += zip(events.times_ms.tolist(), events.neurons.tolist(), strict=True)
    return seen


def counts(port: Any, windows: int, window_ms: float, neurons: int) -> np.ndarray:
    """Return spike counts, shape ``(windows, neurons)``."""
    rows = (port.events(k * window_ms, (k + 1) * window_ms).neurons for k in range(windows))
    return np.array([np.bincount(row, minlength=neurons) for row in rows])


def test_poisson_counts_have_mean_and_variance_of_their_rate() -> None:
    seen = counts(opened(PoissonSource(rate=200.0), 0, 1, 2, 3), 4000, 20.0, 4)
    assert seen.mean(axis=0) == pytest.approx([4.0] * 4, rel=0.03)
    assert seen.var(axis=0) == pytest.approx([4.0] * 4, rel=0.08)
    assert np.abs(np.corrcoef(seen.T) - np.eye(4)).max() < 0.06
    assert abs(np.corrcoef(seen[:-1, 0], seen[1:, 0])[0, 1]) < 0.06


def test_each_neuron_has_its_own_rate() -> None:
    port = opened(PoissonSource(rate=[0.0, 50.0, 450.0]), 0, 1, 2)
    seen = counts(port, 500, 100.0, 3)
    assert seen[:, 0].sum() == 0
    assert seen.mean(axis=0)[1:] == pytest.approx([5.0, 45.0], rel=0.05)
    assert seen.var(axis=0)[1:] == pytest.approx([5.0, 45.0], rel=0.15)
    assert port.rate.tolist() == [0.0, 50.0, 450.0]


def test_several_generators_add_their_rates() -> None:
    seen = counts(opened(PoissonSource(rate=100.0, n=5), 0), 500, 20.0, 1)
    assert seen.mean() == pytest.approx(10.0, rel=0.05)


@pytest.mark.parametrize("spec", SPIKING)
@given(times_ms=cuts, changes=st.lists(st.sampled_from([0.0, 30.0, 90.0, 700.0, 5000.0]), max_size=3))
def test_splitting_a_run_does_not_change_a_bit(
    spec: SourceSpec, times_ms: list[float], changes: list[float]
) -> None:
    def run(cuts_ms: list[float]) -> list[tuple[float, int]]:
        port, seen = opened(spec, 3, 8), []
        for k, rate in enumerate([port.rate, *changes]):
            port.rate = rate
            inside = [200.0 * k + t for t in cuts_ms]
            seen += emitted(port, 200.0 * k, *inside, 200.0 * (k + 1))
        return seen

    assert run(sorted(times_ms)) == run([])


@pytest.mark.parametrize("spec", SPIKING)
@given(times_ms=cuts)
def test_writing_what_is_already_there_changes_nothing(spec: SourceSpec, times_ms: list[float]) -> None:
    untouched, written = opened(spec, 3, 8), opened(spec, 3, 8)
    seen = []
    for a, b in pairwise([0.0, *sorted(times_ms), 200.0]):
        written.rate = [written.rate] * 2 if int(b) % 2 else written.rate
        written.active = True
        seen += emitted(written, a, b)
    assert seen == emitted(untouched, 0.0, 200.0)


@pytest.mark.parametrize("spec", SPIKING)
@given(cut=st.floats(0.0, 200.0), rate=st.sampled_from([None, 0.0, 333.0]), active=st.booleans())
def test_a_saved_source_goes_on_where_it_was(
    spec: SourceSpec, cut: float, rate: float | None, active: bool
) -> None:
    port, other = opened(spec, 3, 8), opened(spec, 3, 8, seeds=Seeds(99))
    emitted(port, 0.0, cut / 2)
    port.rate = port.rate if rate is None else rate
    emitted(port, cut / 2, cut)
    port.active = active
    other.restore(port.save())
    for each in (port, other):
        assert each.active == active
        each.active = True
    assert emitted(other, cut, 400.0) == emitted(port, cut, 400.0)
    assert other.rate == port.rate


@pytest.mark.parametrize("spec", SPIKING)
def test_a_reset_source_begins_anew_with_its_first_settings(spec: SourceSpec) -> None:
    port, fresh = opened(spec, 3), opened(spec, 3)
    emitted(port, 0.0, 55.0)
    port.rate = 5.0
    emitted(port, 55.0, 99.0)
    port.reset(SEEDS)
    assert port.rate == fresh.rate
    assert emitted(port, 0.0, 100.0) == emitted(fresh, 0.0, 100.0)


def test_a_stream_depends_on_name_and_seed_alone() -> None:
    def train(name: str, seeds: Seeds) -> list[tuple[float, int]]:
        return emitted(opened(PoissonSource(rate=500.0), name=name, seeds=seeds), 0.0, 100.0)

    first = train("left eye", SEEDS)
    assert train("right eye", SEEDS) != first
    assert train("left eye", Seeds(8).child("test")) != first
    assert train("left eye", SEEDS) == first


@pytest.mark.parametrize("spec", SPIKING)
def test_a_silenced_source_keeps_its_settings(spec: SourceSpec) -> None:
    port = opened(spec, 3)
    port.active = False
    assert emitted(port, 0.0, 100.0) == []
    port.active = True
    assert port.rate == spec.rate
    assert all(t > 100.0 for t, _ in emitted(port, 100.0, 200.0))


@pytest.mark.parametrize("make", [PoissonSource, FixedFrequencySource])
def test_a_source_is_silent_outside_its_time(make: Callable[..., SourceSpec]) -> None:
    port = opened(make(rate=1000.0, start=20.5, duration=30.0, delay=0.0))
    times_ms = [t for t, _ in emitted(port, 0.0, 100.0)]
    assert len(times_ms) > 15
    assert min(times_ms) > 20.5
    assert max(times_ms) <= 50.5


def test_a_source_added_late_begins_now() -> None:
    port = opened(PoissonSource(rate=1000.0, delay=0.0))
    times_ms = [t for t, _ in emitted(port, 5000.0, 5100.0)]
    assert 60 < len(times_ms) < 140
    assert min(times_ms) > 5000.0


def test_events_carry_weight_receptor_and_delay() -> None:
    spec = PoissonSource(rate=4000.0, weight=0.25, delay=3.0, receptor_type="inhibitory")
    port, prompt = opened(spec), opened(PoissonSource(rate=4000.0, delay=0.0))
    events = port.events(0.0, 500.0)
    assert len(events) > 1000
    assert set(events.weights.tolist()) == {0.25}
    assert len(events.weights) == len(events)
    assert events.receptor == "inhibitory"
    assert (events.times_ms == prompt.events(0.0, 500.0).times_ms + 3.0).all()


@pytest.mark.parametrize("kind", [PoissonSource, FixedFrequencySource, SpikeInjector])
@pytest.mark.parametrize(
    ("cells", "receptor", "weight", "words"),
    [
        (
            "curr",
            "inhibitory",
            0.1,
            r"0\.1.*'curr'",
        ),
        ("cond", "inhibitory", -0.1, r"-0\.1 uS.*'cond'"),
        ("cond", "excitatory", -0.1, r"-0\.1.*'cond'"),
        ("curr", "inhibitory", -0.1, None),
        ("curr", "excitatory", -0.1, None),
        ("curr", "inhibitory", 0.0, None),
        ("cond", "inhibitory", 0.1, None),
        ("trains", "inhibitory", 0.1, None),
    ],
)
def test_a_weight_does_not_act_against_its_receptor(
    kind: type[Any], cells: str, receptor: str, weight: float, words: str | None, golden: Golden
) -> None:
    sim = builder(1)
    sim.setup(timestep=0.1)
    for label, cell_type in (
        ("curr", sim.IF_curr_exp), ("cond", sim.IF_cond_exp), ("trains", sim.SpikeSourceArray)
    ):  # fmt: skip
        sim.Population(2, cell_type(), label=label)
    network = sim.network()
    port = opened(kind(weight=weight, receptor_type=receptor), int(network.offsets[cells]) + 1)
    if words is None:
        port.start(0.0, network)
    else:
        with golden.raises(ValueError, match=words):
            port.start(0.0, network)


def test_equidistant_spikes_reach_all_neurons_at_once() -> None:
    port = opened(FixedFrequencySource(rate=100.0, delay=0.0, n=2), 4, 6)
    assert emitted(port, 0.0, 20.0) == [(t, k) for t in (10.0, 20.0) for k in (4, 4, 6, 6)]


def test_a_change_of_rate_keeps_the_phase() -> None:
    port = opened(FixedFrequencySource(rate=100.0, delay=0.0))
    assert emitted(port, 0.0, 15.0) == [(10.0, 3)]
    port.rate = 50.0  # half of a period has passed, the other half takes 10 ms now
    assert [t for t, _ in emitted(port, 15.0, 70.0)] == pytest.approx([25.0, 45.0, 65.0])
    port.rate = 0.0
    assert emitted(port, 70.0, ENDLESS) == []


def test_equidistant_spikes_have_one_rate(golden: Golden) -> None:
    port = opened(FixedFrequencySource(rate=100.0), 4, 6)
    with golden.raises(ValueError):
        port.rate = [1.0, 2.0]


def test_a_current_is_a_number_or_one_for_each_neuron() -> None:
    port = opened(DCSource(amplitude=0.5), 4, 6)
    assert port.current_na(0.0).tolist() == [0.5, 0.5]
    port.amplitude = [1.0, -2.0]
    assert port.current_na(0.0).tolist() == port.amplitude.tolist() == [1.0, -2.0]
    state = port.save()
    port.active = False
    assert port.current_na(0.0).tolist() == [0.0, 0.0]
    port.restore(state)
    assert (port.active, port.current_na(0.0).tolist()) == (True, [1.0, -2.0])
    port.reset(SEEDS)
    assert port.amplitude == 0.5
    assert len(port.events(0.0, 100.0)) == 0


@pytest.mark.parametrize(
    "value",
    [
        -1.0,
        1e200,
        [1.0, 1e8],
        np.nan,
        [1.0, np.inf],
        [1.0, 2.0, 3.0],
    ],
)
def test_an_impossible_rate_is_refused_and_the_old_one_stays(value: object, golden: Golden) -> None:
    port = opened(PoissonSource(rate=40.0), 1, 2)
    with golden.raises(ValueError):
        port.rate = value
    assert port.rate == 40.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("weight", np.inf),
        ("delay", -0.1),
        ("delay", np.nan),
        ("n", 0),
        ("start", "5"),
        ("duration", float("nan")),
        ("receptor_type", "exc"),
    ],
)
def test_an_impossible_source_is_refused(name: str, value: object, golden: Golden) -> None:
    with golden.raises(ValueError):
        PoissonSource(**{name: value})


def test_source_cells_emit_their_list_once_whatever_the_windows() -> None:
    cells = Population("a", 2, "SpikeSourceArray", {}, {}, (np.array([0.0, 5.0, 5.0]), np.array([5.0, 9.0])))
    trains = PopulationTrains(cells, np.array([10, 11]), SEEDS)
    windows = [trains.emitted(a, b) for a, b in pairwise([0.0, 4.0, 5.0, 9.0, 20.0])]
    seen = [pair for ids, times in windows for pair in zip(times.tolist(), ids.tolist(), strict=True)]
    assert seen == [(0.0, 10), (5.0, 10), (5.0, 10), (5.0, 11), (9.0, 11)]


def test_poisson_cells_keep_to_their_own_times_and_rates() -> None:
    parameters = {
        "rate": np.array([100.0, 400.0, 100.0]),
        "start": np.array([0.0, 0.0, 500.0]),
        "duration": np.array([np.inf, 1000.0, 250.0]),
    }
    cells = Population("a", 3, "SpikeSourcePoisson", parameters)
    trains = PopulationTrains(cells, np.arange(5, 8), SEEDS)
    state = trains.save()
    ids, times_ms = trains.emitted(0.0, 10_000.0)
    assert (np.diff(times_ms) >= 0).all()
    assert np.bincount(ids)[5:] == pytest.approx([1000, 400, 25], rel=0.3)
    assert times_ms[ids == 6].max() <= 1000.0
    assert 500.0 < times_ms[ids == 7].min() < times_ms[ids == 7].max() <= 750.0
    trains.restore(state)
    assert (trains.emitted(0.0, 10_000.0)[1] == times_ms).all()
    trains.reset(SEEDS)
    assert (trains.emitted(0.0, 10_000.0)[1] == times_ms).all()


@given(
    st.lists(
        st.lists(st.tuples(st.sampled_from([0.0, 0.5, 0.75, 1.0, 2.0, 3.0]), st.integers(0, 3))), max_size=4
    )
)
def test_merged_spikes_ascend_in_time_and_by_neuron_among_equal_times(
    parts: list[list[tuple[float, int]]],
) -> None:
    whole = Spikes.merged(
        [Spikes(np.array([i for _, i in part], int), np.array([t for t, _ in part])) for part in parts]
    )
    found = list(zip(whole.times_ms.tolist(), whole.neurons.tolist(), strict=True))
    assert found == sorted(spike for part in parts for spike in part)


@pytest.mark.parametrize("n", [1, 3, 10, 1250, 49 * 3])
def test_equal_neurons_have_equal_shares_of_all_arrivals(n: int) -> None:
    """Also where the random number is the border between two neurons, or the next number to it."""
    borders = np.arange(n) / n
    below, above = np.nextafter(borders, -1.0)[1:], np.nextafter(borders, 1.0)
    port = opened(PoissonSource(rate=1.0), *range(n))
    for values, last in ((borders, 0), (above, 0), (below, 1)):
        port._set_arrivals(np.append(np.zeros(len(values)), 1e6), np.append(values, 0.0), 1e6)
        assert port.events(0.0, 1.0).neurons.tolist() == list(range(n - last))


def test_unknown_source_cells_are_refused(golden: Golden) -> None:
    with golden.raises(CapabilityError, match="SpikeSourceInhGamma"):
        PopulationTrains(Population("a", 1, "SpikeSourceInhGamma", {}), np.arange(1), SEEDS)
