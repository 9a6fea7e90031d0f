"""Ticks and time: windows, delays, devices, splitting, reset, snapshots."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from golden import Golden
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.errors import CapabilityError, NetworkError, SimulationError, TimestepError
from nrp_core.network.data import Origin, Population, Projection
from nrp_core.network.synapses import STDP, TSODYKS_MARKRAM

MS = 1_000_000
Maker = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]


def record(brain: Brain, until_ms: float) -> Spikes:
    recorder = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="all")
    brain.run_until(round(until_ms * MS))
    return recorder.spikes()


def events(times_ms: list[float], weight: float, neuron: int = 0) -> SynapticEvents:
    n = len(times_ms)
    return SynapticEvents(np.full(n, neuron), np.array(times_ms), np.full(n, weight))


@pytest.fixture
def busy(cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open) -> Callable[..., Brain]:
    """Open a network with every kind of synapse, sources of its own and devices."""
    pairs = [(i, j) for i in range(4) for j in range(4)]

    def make(**options: object) -> Brain:
        rates = {"rate": [5.0, 80.0, 2000.0, 0.0], "start": [0.0] * 4, "duration": [np.inf] * 4}
        poisson = Population("p", 4, "SpikeSourcePoisson", {k: np.array(v) for k, v in rates.items()})
        rule = {"t": "SpikePairRule", "w": "AdditiveWeightDependence"}
        brain = open_brain(
            spike_source("s", *[[2.0, 9.5, 30.0]] * 4), poisson,
            cells("a", "IF_curr_exp", 4, i_offset=0.6), cells("b", "IF_cond_alpha", 4),
            connect("s", "a", 3.0, 2.0, pairs=pairs),
            connect("p", "b", 0.002, 1.0, pairs=pairs, kind=TSODYKS_MARKRAM,
                    U=0.5, tau_rec=50.0, tau_facil=20.0),
            connect("a", "b", 0.02, np.linspace(1, 9, 16), pairs=pairs),
            connect("p", "a", 0.5, 3.0, pairs=pairs, kind=STDP, plasticity=rule, label="plastic",
                    tau_plus=20.0, tau_minus=20.0, A_plus=0.1, A_minus=0.1, w_min=0.0, w_max=1.0),
            **options,
        )  # fmt: skip
        brain.add_source(PoissonSource(rate=300.0, weight=0.01), [12, 13], name="device")
        brain.add_source(DCSource(amplitude=0.2), [8], name="current")
        return brain

    return make


def test_a_crossing_in_the_first_tick_is_reported_at_its_end(cells: Maker, open_brain: Open) -> None:
    spikes = record(open_brain(cells("n", "IF_curr_exp", v0=-40.0)), 5)
    assert spikes.times_ms.tolist() == [1.0]


def test_a_device_event_on_the_grid_acts_within_the_next_step(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"))
    brain._do_inject(events([3.0], 20.0))
    assert record(brain, 10).times_ms.tolist() == [4.0]


def test_a_device_event_off_the_grid_waits_for_the_next_tick(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"))
    brain._do_inject(events([2.1, 7.999], 20.0))
    assert record(brain, 12).times_ms.tolist() == [4.0, 9.0]


def test_a_float_error_of_an_arrival_time_does_not_cost_a_tick(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"))
    brain._do_inject(events([1.9 + 0.1 + 4e-16], 20.0))
    assert record(brain, 5).times_ms.tolist() == [3.0]


def test_device_events_of_one_tick_add_up(cells: Maker, open_brain: Open) -> None:
    one, many = (open_brain(cells("n", "IF_curr_exp")) for _ in range(2))
    one._do_inject(events([3.0], 0.5))
    many._do_inject(events([2.2, 2.7], 0.125))
    many._do_inject(events([3.0], 0.25))
    for brain in (one, many):
        brain.run_until(6 * MS)
    assert one.read_state("v", [0]) == many.read_state("v", [0]) > -65.0


def test_device_events_far_ahead_wait_across_windows(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"))
    brain._do_inject(events([95.0], 20.0))
    brain.run_until(50 * MS)
    assert record(brain, 100).times_ms.tolist() == [96.0]


@pytest.mark.parametrize("delay", [1.0, 4.0, 200.0])
def test_a_spike_acts_its_delay_after_its_label(
    delay: float, cells: Maker, connect: Connect, open_brain: Open
) -> None:
    pair = cells("pre", "IF_curr_exp", v0=-40.0), cells("post", "IF_curr_delta")
    spikes = record(open_brain(*pair, connect("pre", "post", 20.0, delay)), delay + 5)
    # labelled 0 and reported at 1 ms; its input acts in tick `delay` and is reported at that tick's end
    assert spikes.times_ms.tolist() == [1.0, delay + 1.0]


def test_a_source_spike_acts_its_delay_after_it(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open
) -> None:
    parts = spike_source("s", [0.0, 20.0]), cells("post", "IF_curr_delta"), connect("s", "post", 20.0, 2.0)
    spikes = record(open_brain(*parts), 30)
    assert spikes.times_ms[spikes.neurons == 1].tolist() == [3.0, 23.0]


def test_delays_below_the_grid_become_one_step_with_one_warning(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    parts = spike_source("s", [5.0]), cells("a", "IF_curr_delta"), cells("b", "IF_curr_delta")
    brain = open_brain(*parts, connect("s", "a", 20.0, 0.1), connect("s", "b", 20.0, 0.3))
    (warning,) = brain.warnings
    golden(str(warning))
    assert "'s-a-excitatory', 's-b-excitatory'" in str(warning)
    assert record(brain, 9).times_ms.tolist() == [5.0, 7.0, 7.0]


def test_a_finer_grid_takes_shorter_delays_as_they_are(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open
) -> None:
    parts = spike_source("s", [5.0]), cells("a", "IF_curr_delta"), connect("s", "a", 20.0, 0.3)
    brain = open_brain(*parts, timestep="0.1 ms")
    assert not brain.warnings
    assert record(brain, 9).times_ms.tolist() == [5.0, pytest.approx(5.4)]


def test_a_delay_beyond_the_machines_reach_is_refused(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    parts = spike_source("s", [5.0]), cells("a", "IF_curr_delta", 256), connect("s", "a", 20.0, 289.0)
    with golden.raises(NetworkError, match="'s-a-excitatory'.*289.*288"):
        open_brain(*parts)


def test_running_off_the_grid_is_refused(cells: Maker, open_brain: Open, golden: Golden) -> None:
    with golden.raises(TimestepError, match=r"2\.5"):
        open_brain(cells("n", "IF_curr_exp")).run_until(2_500_000)


def test_a_current_acts_from_the_moment_it_is_set(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_exp"))
    port = brain.add_source(DCSource(amplitude=0.0), [0], name="dc")
    brain.run_until(3 * MS)
    port.amplitude = 1.0
    brain.run_until(4 * MS)
    assert brain.read_state("v", [0])[0] == pytest.approx(-65 + 20 * (1 - np.exp(-1 / 20)), abs=1e-3)


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.integers(1, 119), max_size=8), st.sampled_from(["core", "machine"]))
def test_how_a_run_is_split_does_not_show(busy: Callable[..., Brain], cuts: list[int], poisson: str) -> None:
    whole, parted = busy(poisson=poisson), busy(poisson=poisson)
    recorder = parted.add_sink(SpikeRecorder(), np.arange(parted.network.size), name="all")
    for cut in sorted({*cuts, 120}):
        parted.run_until(cut * MS)
    expected = record(whole, 120)
    assert len(expected) > 50
    assert recorder.spikes().times_ms.tolist() == expected.times_ms.tolist()
    assert recorder.spikes().neurons.tolist() == expected.neurons.tolist()
    neurons = np.arange(8, 16)
    assert (whole.read_state("v", neurons) == parted.read_state("v", neurons)).all()


@pytest.mark.parametrize("poisson", ["core", "machine"])
def test_reset_is_as_good_as_new(busy: Callable[..., Brain], poisson: str) -> None:
    brain, fresh = busy(poisson=poisson), busy(poisson=poisson)
    brain.run_until(77 * MS)
    brain.reset()
    again, expected = record(brain, 90), record(fresh, 90)
    assert again.times_ms.tolist() == expected.times_ms.tolist()
    assert again.neurons.tolist() == expected.neurons.tolist()


@pytest.mark.parametrize("poisson", ["core", "machine"])
@pytest.mark.parametrize("at_ms", [0, 9, 40])
def test_a_restored_snapshot_continues_as_if_uninterrupted(
    busy: Callable[..., Brain], poisson: str, at_ms: int
) -> None:
    brain = busy(poisson=poisson)
    recorder = brain.add_sink(SpikeRecorder(), np.arange(16), name="all")
    brain._do_inject(SynapticEvents(np.array([8]), np.array([60.0]), np.array([9.0])))
    brain.run_until(at_ms * MS)
    snapshot = brain.snapshot()
    ends = []
    for _ in range(2):
        brain.run_until(100 * MS)
        ends.append((recorder.spikes().times_ms.tolist(), brain.read_state("v", np.arange(8, 16)).tolist()))
        brain.restore(snapshot)
    assert ends[0] == ends[1]


def test_another_seed_gives_other_machine_spikes(busy: Callable[..., Brain]) -> None:
    brain = busy(poisson="machine")
    first = record(brain, 100).times_ms.tolist()
    brain.reset(seed=2)
    assert record(brain, 100).times_ms.tolist() != first


def test_a_removed_device_has_no_effect(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_delta"))
    port = brain.add_source(FixedFrequencySource(rate=100.0, weight=20.0, delay=1.0), [0], name="beat")
    assert record(brain, 35).times_ms.tolist() == [12.0, 22.0, 32.0]
    brain.remove(port)
    brain.run_until(80 * MS)
    assert record(brain, 90).times_ms.tolist() == []


def test_a_device_leaves_the_networks_shifts_alone(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open
) -> None:
    parts = spike_source("s", [5.0]), cells("a", "IF_curr_exp"), connect("s", "a", 0.001, 1.0)
    plain, with_device = open_brain(*parts), open_brain(*parts)
    with_device._do_inject(events([50.0], 30000.0, neuron=1))
    for brain in (plain, with_device):
        brain.run_until(12 * MS)
    assert plain.read_state("v", [1]) == with_device.read_state("v", [1]) > -65


def test_a_device_weight_below_the_resolution_is_reported(cells: Maker, open_brain: Open) -> None:
    brain = open_brain(cells("n", "IF_curr_exp"))
    brain._do_inject(events([2.0, 3.0], 1e-6))
    brain.run_until(5 * MS)
    assert brain.warnings.messages == ["a device's weight is below the machine's resolution and was lost"]


def test_a_device_weight_beyond_the_machines_numbers_is_refused(
    cells: Maker, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(cells("n", "IF_cond_exp"))
    brain._do_inject(events([2.0], 100.0))
    with golden.raises(CapabilityError, match="102400"):
        brain.run_until(5 * MS)


def test_a_device_on_a_source_cell_is_refused(
    spike_source: Maker, cells: Maker, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(spike_source("s", [1.0]), cells("n", "IF_curr_exp"))
    brain._do_inject(events([2.0], 1.0))
    with golden.raises(CapabilityError):
        brain.run_until(5 * MS)


def test_lost_input_is_counted_and_reported_once(
    spike_source: Maker, cells: Maker, connect: Connect, open_brain: Open
) -> None:
    source = spike_source("s", *[[5.0] * 20, [5.0, 15.0]])
    brain = open_brain(source, cells("n", "IF_curr_exp"), connect("s", "n", 1.5, pairs=[(0, 0), (1, 0)]))
    brain.run_until(20 * MS)
    assert brain.saturations == {"n": (16, 0)}
    brain.run_until(40 * MS)
    assert brain.warnings.messages == ["input beyond the 16 bits of a ring buffer was lost: population 'n'"]


def test_weights_that_do_not_survive_are_reported_at_once(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    parts = spike_source("s", [5.0]), cells("n", "IF_curr_exp")
    brain = open_brain(*parts, connect("s", "n", 900.0), connect("s", "n", 1e-3, label="weak"))
    (warning,) = brain.warnings
    assert warning.message.startswith("projection 'weak': 1 of 1 weights become 0 (in steps of 0.0312)")


def test_a_weight_beyond_what_its_distribution_promised_wraps_with_a_warning(
    cells: Maker, spike_source: Maker, connect: Connect, open_brain: Open
) -> None:
    drawn = connect("s", "n", [1.0, 40.0], pairs=[(0, 0), (0, 0)], label="wild")
    origin = Origin("AllToAllConnector", {}, "uniform(low=0, high=2)", 1.0)
    brain = open_brain(spike_source("s", [5.0]), cells("n", "IF_curr_exp"), replace(drawn, origin=origin))
    (warning,) = brain.warnings
    assert warning.message.startswith("projection 'wild': 1 of 2 weights wrap around")


def test_a_current_that_does_not_fit_the_machine_is_an_error(
    cells: Maker, open_brain: Open, golden: Golden
) -> None:
    brain = open_brain(cells("n", "IF_curr_exp"))
    brain.add_source(DCSource(amplitude=1e6), [0], name="dc")
    with golden.raises(SimulationError, match="nA.*1e"):
        brain.run_until(MS)


@pytest.mark.parametrize(
    ("times_ms", "refractory_ms", "step", "told"),
    [
        ([3.0, 7.0], 2.0, "1 ms", []),
        ([0.3, 0.7], 0.1, "0.1 ms", []),  # 0.3 / 0.1 is not 3 in floating point
        ([3.0], 0.1, "1 ms", []),  # PyNN's default period, less than a step
        ([3.0, 3.5], 2.0, "1 ms", ["spikes between time steps of 1 ms come at the next: 's' (3.5 -> 4 ms)"]),
        ([3.0], 2.5, "1 ms", ["refractory periods become whole time steps: 'n' (2.5 -> 3 ms)"]),
        ([3.0], 2.0, "0.05 ms", ["a time step of 0.05 ms is below 0.1 ms, the shortest that a machine keeps "
                                 "up with; a real one needs a time_scale_factor"]),
    ],
)  # fmt: skip
def test_times_between_steps_are_reported(
    times_ms: list[float], refractory_ms: float, step: str, told: list[str], cells: Maker,
    spike_source: Maker, connect: Connect, open_brain: Open,
) -> None:  # fmt: skip
    """A spike has the tick ceil(t / step) in sPyNNaker, and a refractory period ceil(tau_refrac / step)."""
    target = cells("n", "IF_curr_exp", tau_refrac=refractory_ms, i_offset=9.0)
    brain = open_brain(spike_source("s", times_ms), target, connect("s", "n", 1.0, 1.0), timestep=step)
    assert list(brain.warnings.messages) == told
