"""PyNN's current sources are constant between times that are known in advance."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.clock import NS_PER_MS
from nrp_core.network.pynn import builder
from nrp_core.pynn import new_simulator
from nrp_core.pynn.currents import Waveform


def waveform(kind: str, **parameters: Any) -> Waveform:
    sim = builder()
    sim.setup(timestep=0.1)
    return Waveform(getattr(sim, kind)(**parameters), np.random.RandomState(1), 0.1)


def values(wave: Waveform, *times_ms: float) -> list[float]:
    return wave.amplitudes_na(np.array([round(t_ms * NS_PER_MS) for t_ms in times_ms])).tolist()


def changes_ms(wave: Waveform, since_ms: float, until_ms: float) -> list[float]:
    return (wave.changes_ns(round(since_ms * NS_PER_MS), round(until_ms * NS_PER_MS)) / NS_PER_MS).tolist()


def test_a_pulse_is_on_from_its_start_up_to_its_stop() -> None:
    wave = waveform("DCSource", amplitude=0.5, start=10.0, stop=20.0)
    assert values(wave, 0.0, 9.9, 10.0, 19.9, 20.0) == [0.0, 0.0, 0.5, 0.5, 0.0]
    assert changes_ms(wave, 0.0, 100.0) == [10.0, 20.0]
    assert changes_ms(wave, 10.0, 20.0) == [20.0]


def test_a_pulse_without_end_changes_once() -> None:
    wave = waveform("DCSource", amplitude=0.5, start=10.0)
    assert changes_ms(wave, 0.0, 1e6) == [10.0]


def test_steps_hold_until_the_next() -> None:
    wave = waveform("StepCurrentSource", times=[10.0, 20.0, 30.0], amplitudes=[0.5, -0.5, 0.25])
    assert values(wave, 9.9, 10.0, 25.0, 30.0, 1000.0) == [0.0, 0.5, -0.5, 0.25, 0.25]
    assert changes_ms(wave, 0.0, 1000.0) == [10.0, 20.0, 30.0]


def test_on_a_grid_steps_move_to_its_points_and_the_last_of_several_stays() -> None:
    wave = waveform("StepCurrentSource", times=[0.41, 0.42, 0.86], amplitudes=[0.5, -0.5, 0.25])
    assert changes_ms(wave, 0.0, 1000.0) == [0.41, 0.42, 0.86]
    wave.grid_ns = 100_000
    assert changes_ms(wave, 0.0, 1000.0) == [0.4, 0.9]
    assert values(wave, 0.45, 0.95) == [-0.5, 0.25]


@pytest.mark.parametrize("times", [[0.4, -0.6], [0.4, 0.2], [0.4]])
def test_steps_that_do_not_ascend_are_refused(times: list[float], golden: Golden) -> None:
    with golden.raises(ValueError):
        waveform("StepCurrentSource", times=times, amplitudes=[0.5, -0.5])


def test_noise_changes_with_the_time_step_at_most() -> None:
    fast, slow = (waveform("NoisyCurrentSource", dt=dt_ms) for dt_ms in (0.01, 0.2))
    assert changes_ms(fast, 0.0, 0.5) == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert changes_ms(slow, 0.0, 0.5) == pytest.approx([0.2, 0.4])


def test_a_sinusoidal_current_starts_at_its_phase_and_changes_every_time_step() -> None:
    wave = waveform("ACSource", amplitude=2.0, offset=0.5, frequency=100.0, phase=90.0, start=5.0, stop=15.0)
    assert values(wave, 4.9, 5.0, 7.5, 10.0, 15.0) == pytest.approx([0.0, 2.5, 0.5, -1.5, 0.0])
    assert changes_ms(wave, 0.0, 5.25) == pytest.approx([5.0, 5.1, 5.2])
    assert changes_ms(wave, 14.75, 20.0) == pytest.approx([14.8, 14.9, 15.0])


def test_noise_has_the_mean_and_deviation_asked_for_and_holds_for_its_interval() -> None:
    wave = waveform("NoisyCurrentSource", mean=1.0, stdev=0.5, dt=1.0, start=2.0, stop=10002.0)
    drawn = values(wave, *(2.0 + np.arange(10000.0)))
    assert np.mean(drawn) == pytest.approx(1.0, abs=0.02)
    assert np.std(drawn) == pytest.approx(0.5, abs=0.02)
    assert changes_ms(wave, 0.0, 4.5) == [2.0, 3.0, 4.0]
    assert values(wave, 0.0, 3.0, 5.0) == [0.0, drawn[1], drawn[3]]


@settings(max_examples=50, deadline=None)
@given(
    kind=st.sampled_from(["ACSource", "NoisyCurrentSource", "DCSource"]),
    start=st.floats(0.0, 5.0), length=st.floats(0.0, 5.0), cuts=st.lists(st.floats(0.0, 12.0), max_size=4),
)  # fmt: skip
def test_how_time_is_split_does_not_change_the_changes(
    kind: str, start: float, length: float, cuts: list[float]
) -> None:
    wave = waveform(kind, start=start, stop=start + length)
    bounds = [0.0, *sorted(cuts), 12.0]
    parts = [changes_ms(wave, a, b) for a, b in pairwise(bounds)]
    assert sorted({t for part in parts for t in part}) == sorted(set(changes_ms(wave, 0.0, 12.0)))


def test_a_current_names_which_of_its_lists_is_wrong(golden: Golden) -> None:
    with golden.raises(ValueError):
        waveform("StepCurrentSource", times=[0.0, 10.0, 20.0], amplitudes=[0.0, 1.0])
    with golden.raises(ValueError):
        waveform("StepCurrentSource", times=[0.0, 20.0, 10.0], amplitudes=[0.0, 1.0, 0.0])


def test_a_list_of_views_is_not_a_target_of_a_current(golden: Golden) -> None:
    sim = builder()
    cells = sim.Population(2, sim.IF_curr_exp(), label="cells")
    source = sim.DCSource(amplitude=0.5)
    source.inject_into(cells[0:1])
    with golden.raises(TypeError):
        source.inject_into([cells[0:1]])


def test_noise_that_begins_later_is_zero_before() -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    cells = sim.Population(1, sim.IF_curr_exp())
    noise = sim.NoisyCurrentSource(mean=0.5, stdev=0.2, start=5.0, stop=8.0, dt=0.1)
    cells.inject(noise)
    sim.run(2.0)
    sim.run(8.0)
    _, amplitudes = noise._get_data()
    assert amplitudes[[0, 20, 49, 80, 100]].tolist() == [0.0] * 5
    assert len(set(amplitudes[50:80])) == 30


def test_currents_into_one_cell_add_up_whatever_their_steps() -> None:
    """C dV/dt = I while tau_m is long: the voltage rises by the integral of the sum of all currents."""
    sim = new_simulator()
    sim.setup(timestep=0.1)
    cells = sim.Population(3, sim.IF_curr_exp(tau_m=1e9, cm=1.0, v_thresh=1e6))
    for start in range(50):
        cells[0:2].inject(sim.DCSource(amplitude=0.1, start=float(start)))
    cells[1:3].inject(sim.StepCurrentSource(times=[10.0, 20.0], amplitudes=[1.0, -1.0]))
    cells.record("v", sampling_interval=10.0)
    sim.run(30.0)
    late = sim.DCSource(amplitude=2.0, start=40.0, stop=45.0)
    cells[2:3].inject(late)
    sim.run(30.0)
    v = np.asarray(cells.get_data("v").segments[0].analogsignals[0])[[0, 3, 6]] + 65.0
    pulses = 0.1 * sum(np.maximum(0.0, np.array([0.0, 30.0, 60.0]) - start) for start in range(50))
    steps, late_mv = np.array([0.0, 10.0 - 10.0, 10.0 - 40.0]), np.array([0.0, 0.0, 10.0])
    assert v == pytest.approx(np.array([pulses, pulses + steps, steps + late_mv]).T, abs=1e-5)
    _, amplitudes = late._get_data()
    assert amplitudes[[0, 399, 400, 449, 450]].tolist() == [0.0, 0.0, 2.0, 2.0, 0.0]


def test_a_thousand_noisy_currents_are_set_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step takes a call for all of them, not one for each; the script of Joglekar et al. has 2000."""
    calls = []
    known = Waveform.amplitudes_na

    def counted(self: Waveform, times_ns: Any) -> Any:
        calls.append(len(times_ns))
        return known(self, times_ns)

    monkeypatch.setattr(Waveform, "amplitudes_na", counted)
    sim = new_simulator()
    sim.setup(timestep=0.1)
    cells = sim.Population(1000, sim.IF_curr_exp())
    for cell in cells:
        cell.inject(sim.NoisyCurrentSource(stdev=0.1, stop=20.0))
    sim.run(20.0)
    assert len(calls) == 2 * len(cells)  # at the beginning, and for all 200 steps
