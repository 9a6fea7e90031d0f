"""``import nrp_core.pynn as sim`` is a PyNN simulator on any brain backend."""

from math import log
from pathlib import Path
from types import ModuleType
from typing import Any

import neo
import numpy as np
import pytest
from golden import Golden
from pyNN.space import Line

import nrp_core.pynn
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    LifecycleError,
    NetworkError,
    UnknownBackendError,
)
from nrp_core.pynn import new_simulator


@pytest.fixture
def sim() -> ModuleType:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    return sim


def driven(sim: ModuleType, n: int = 1, current: Any = 1.0) -> Any:
    """Return cells that fire regularly under a constant current (nA)."""
    cells = sim.Population(n, sim.IF_curr_exp(tau_m=20.0, tau_refrac=2.0, i_offset=current), label="cells")
    cells.record(["spikes", "v"])
    return cells


def trains(cells: Any, segment: int = 0) -> list[list[float]]:
    return [train.magnitude.tolist() for train in cells.get_data("spikes").segments[segment].spiketrains]


def voltage(cells: Any, segment: int = 0) -> Any:
    return cells.get_data("v").segments[segment].analogsignals[0]


def test_spikes_are_where_the_equation_of_the_cell_puts_them(sim: ModuleType) -> None:
    cells = driven(sim, 2, [1.0, 0.5])
    sim.run(100.0)
    first = 20.0 * log(20.0 / 5.0)  # 1 nA drives 1 nF with 20 ms towards 20 mV, 15 mV is the threshold
    expected = [first + k * (first + 2.0) for k in range(4)]
    assert trains(cells)[0] == pytest.approx([t for t in expected if t <= 100.0], abs=1e-6)
    assert trains(cells)[1] == []
    assert cells.get_spike_counts() == {0: len(trains(cells)[0]), 1: 0}
    assert cells.mean_spike_count() == len(trains(cells)[0]) / 2


def test_the_message_on_an_unknown_name_suggests_a_similar_one(golden: Golden) -> None:
    with golden.raises(AttributeError, match="'IF_cond_expo'.*'IF_cond_exp'"):
        nrp_core.pynn.IF_cond_expo  # noqa: B018


def test_state_is_sampled_from_the_start_to_the_end(sim: ModuleType) -> None:
    cells = sim.Population(2, sim.IF_curr_exp(i_offset=0.5))
    cells.record("v", sampling_interval=0.5)
    sim.run(10.0)
    signal = voltage(cells)
    assert signal.shape == (21, 2)
    assert float(signal.sampling_period) == 0.5
    assert signal.magnitude[:, 0] == pytest.approx(
        -65.0 + 10.0 * (1 - np.exp(-signal.times.magnitude / 20.0))
    )


def test_samples_are_where_their_times_say_however_long_the_runs_are(sim: ModuleType) -> None:
    cells = sim.Population(1, sim.IF_curr_exp(i_offset=0.5))
    cells.record("v", sampling_interval=2.0)
    begins = []
    for duration, clear in ((3.0, False), (20.5, True), (2.0, True), (1.5, True), (0.0, True)):
        sim.run(duration)
        times = (signal := voltage(cells)).times.magnitude
        assert signal.magnitude[:, 0] == pytest.approx(-65.0 + 10.0 * (1 - np.exp(-times / 20.0)))
        assert sim.get_current_time() - 2.0 < times[-1] <= sim.get_current_time()
        begins.append(times[0])
        cells.get_data(clear=clear)
    assert begins == [0.0, 0.0, 23.5, 25.5, 27.0]


@pytest.mark.parametrize("interval", [0.0, -1.0, 1e-9, float("nan"), float("inf")])
def test_an_impossible_sampling_interval_is_refused(sim: ModuleType, interval: float, golden: Golden) -> None:
    cells = driven(sim)
    with golden.raises(NetworkError, match="'cells': sampling_interval"):
        cells.record("v", sampling_interval=interval)
    sim.run(1.0)
    assert voltage(cells).shape == (11, 1)


def test_a_run_has_an_end_and_does_not_go_on_after_it(sim: ModuleType, golden: Golden) -> None:
    cells = driven(sim)
    with golden.raises(NetworkError):
        sim.run(float("inf"))
    sim.run(50.0)
    sim.end()
    with golden.raises(LifecycleError):
        sim.run(50.0)
    assert len(trains(cells)[0]) == 1
    assert len(voltage(cells)) == 501
    cells.get_data(clear=True)


def test_before_a_run_there_are_no_data(sim: ModuleType, golden: Golden) -> None:
    cells = driven(sim, 1, 1.0)
    with golden.raises(NetworkError, match="'cells'"):
        cells.get_data()


def test_cells_built_before_the_last_setup_are_not_part_of_the_new_network(sim: ModuleType) -> None:
    def network() -> Any:
        cells = driven(sim, 2, 0.0)
        stdp = sim.STDPMechanism(sim.SpikePairRule(), sim.AdditiveWeightDependence(), weight=0.01, delay=1.0)
        return cells, sim.Projection(cells, cells, sim.AllToAllConnector(), stdp)

    old, wires = network()
    sim.setup(timestep=0.1)
    new, _ = network()
    forgotten = r"'cells' was built before the last setup\(\), which forgets everything"
    for _ in range(2):
        old.set(i_offset=5.0)
        wires.set(weight=9.0)
        with pytest.raises(NetworkError, match=forgotten):
            sim.DCSource(amplitude=5.0).inject_into(old[1:])
        with pytest.raises(NetworkError, match=forgotten):
            sim.Projection(new, old, sim.AllToAllConnector())
        sim.run(50.0)
    assert wires.get("weight", "list", with_address=False) == [9.0] * 4
    assert new.get_spike_counts() == {0: 0, 1: 0}


BACKENDS = {
    "exact": {"backend": "event"},
    "grid": {"backend": "event", "options": {"resolution": "1 ms"}},
    "spinnaker": {"backend": "spinnaker"},
}


@pytest.mark.parametrize("setup", BACKENDS.values(), ids=BACKENDS)
def test_some_cells_of_a_population_that_has_places_change(setup: dict[str, Any]) -> None:
    sim = new_simulator()
    sim.setup(timestep=1.0, **setup)
    cells = sim.Population(3, sim.IF_curr_exp(), structure=Line())
    cells.record("spikes")
    sim.run(10.0)
    cells[1:].set(i_offset=2.0)
    sim.run(90.0)
    counts = cells.get_spike_counts()
    assert counts[0] == 0
    assert counts[1] == counts[2] > 3


def test_deviations_of_a_backend_are_reported(caplog: pytest.LogCaptureFixture) -> None:
    sim = new_simulator()
    sim.setup(timestep=1.0, backend="spinnaker")
    cells = sim.Population(1, sim.IF_curr_exp())
    for weight in (1e-9, 20.0):
        sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=weight, delay=1.0))
    sim.run(1.0)
    sim.reset()
    cells.set(i_offset=0.1)
    sim.run(1.0)
    said = [record.getMessage() for record in caplog.records if record.name == "nrp_core.pynn.running"]
    (told,) = (one for one in said if one.startswith("spinnaker: "))
    assert told.startswith("spinnaker: projection 'population0→population0': 1 of 1 weights become 0")


def test_an_impossible_rate_is_refused_without_side_effects(sim: ModuleType, golden: Golden) -> None:
    source = sim.Population(1, sim.SpikeSourcePoisson(rate=100.0), label="source")
    source.record("spikes")
    sim.run(50.0)
    with golden.raises(NetworkError, match=r"'source'.*1e\+09.*1e\+07"):
        source.set(rate=1e9)
    sim.run(50.0)
    assert source.mean_spike_count() > 0


def test_a_parameter_that_synapses_do_not_have_is_named(sim: ModuleType, golden: Golden) -> None:
    cells = driven(sim, 2)
    wires = sim.Projection(cells, cells, sim.AllToAllConnector())
    with golden.raises(NetworkError, match="StaticSynapse.*'wieght'.*'weight'"):
        wires.get(["delay", "wieght"], format="array")


def test_as_many_weights_as_synapses_are_set(sim: ModuleType, golden: Golden) -> None:
    cells = driven(sim, 2)
    wires = sim.Projection(cells, cells, sim.AllToAllConnector(), label="wires")
    with golden.raises(NetworkError, match="'wires'"):
        wires.set(weight=[1.0, 2.0, 3.0])
    wires.set(weight=[1.0, 2.0, 3.0, 4.0])
    assert wires.get("weight", format="array").tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize("backend", ["event", "spinnaker"])
def test_running_in_parts_is_running_at_once(backend: str) -> None:
    found = []
    for parts in ([60.0], [1.0, 29.0, 30.0]):
        sim = new_simulator()
        sim.setup(timestep=1.0, backend=backend)
        source = sim.Population(1, sim.SpikeSourcePoisson(rate=200.0))
        cells = driven(sim, 3, [1.0, 0.9, 0.0])
        sim.Projection(source, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.5, delay=2.0))
        for part in parts:
            sim.run(part)
        assert sim.get_current_time() == 60.0
        found.append((trains(cells), voltage(cells).magnitude.tolist()))
    assert found[0] == found[1]
    assert found[0][0][0]


def test_a_reset_gives_a_new_segment_and_the_same_again(sim: ModuleType) -> None:
    cells = driven(sim)
    for _ in range(3):
        sim.run(50.0)
        sim.reset()
        assert sim.get_current_time() == 0.0
    assert trains(cells, 0) == trains(cells, 1) == trains(cells, 2)
    assert trains(cells, 0)[0]


def test_segments_before_a_reset_have_the_variables_that_are_asked_for(sim: ModuleType) -> None:
    cells = driven(sim)
    for _ in range(2):
        sim.run(50.0)
        sim.reset(annotations={"trial": "done"})
    sim.run(50.0)
    for asked, names, has_spikes in (
        ("v", ["v"], False),
        ("spikes", [], True),
        (["spikes", "v"], ["v"], True),
    ):
        segments = cells.get_data(asked).segments
        assert [[signal.name for signal in each.analogsignals] for each in segments] == [names] * 3
        assert [len(each.spiketrains) > 0 for each in segments] == [has_spikes] * 3
        assert [each.annotations for each in segments] == [{"trial": "done"}] * 2 + [{}]
    whole = cells.get_data()  # nothing was lost by asking for less
    assert (whole.segments[0].analogsignals[0] == cells.get_data("v").segments[1].analogsignals[0]).all()
    assert trains(cells, 0) == [train.magnitude.tolist() for train in whole.segments[1].spiketrains]


def test_data_can_be_taken_away_while_running(sim: ModuleType) -> None:
    cells = driven(sim)
    sim.run(40.0)
    before = cells.get_data(clear=True).segments[0]
    sim.run(40.0)
    after = cells.get_data().segments[0]
    assert before.spiketrains[0].magnitude.max() < 40.0 < after.spiketrains[0].magnitude.min()
    assert float(after.analogsignals[0].t_start) == 40.0
    assert after.analogsignals[0][0] == before.analogsignals[0][-1]
    cells.record(None)
    cells[0:1].record("spikes")
    sim.run(40.0)
    (train,) = cells.get_data().segments[0].spiketrains
    assert train.magnitude.min() > 80.0


def test_callbacks_are_called_when_they_want_to_be(sim: ModuleType) -> None:
    driven(sim)
    called: list[float] = []

    def every_7_ms(t: float) -> float:
        called.append(t)
        return t + 7.0

    sim.run(20.0, callbacks=[every_7_ms])
    assert called == [0.0, 7.0, 14.0, 20.0]


def test_currents_act_while_they_are_on(sim: ModuleType) -> None:
    cells = driven(sim, 3, 0.0)
    step = sim.StepCurrentSource(times=[10.0, 30.0], amplitudes=[1.0, 0.0])
    step.inject_into(cells[0:1])
    pulse = sim.DCSource(amplitude=1.0, start=10.0, stop=30.0)
    cells[1].inject(pulse)
    step.record()
    sim.run(50.0)
    v = voltage(cells).magnitude
    assert v[100].tolist() == [-65.0, -65.0, -65.0]
    assert v[300] == pytest.approx([-65.0 + 20.0 * (1 - np.exp(-1.0))] * 2 + [-65.0])
    assert v[:, 0].tolist() == v[:, 1].tolist()
    assert step.get_data().magnitude[[0, 99, 100, 299, 300], 0].tolist() == [0.0, 0.0, 1.0, 1.0, 0.0]


def test_one_noisy_current_is_the_same_for_all_its_cells(sim: ModuleType) -> None:
    cells = driven(sim, 2, 0.0)
    noise = sim.NoisyCurrentSource(mean=0.2, stdev=0.1, stop=20.0)
    noise.inject_into(cells[0:1])
    cells[1].inject(noise)
    sim.run(30.0)
    v = voltage(cells).magnitude
    assert v[:, 0].tolist() == v[:, 1].tolist()
    current = noise.get_data().magnitude[:, 0]
    assert (len(set(current[:200])), set(current[200:])) == (200, {0.0})


def test_a_current_can_be_changed_between_runs(sim: ModuleType) -> None:
    cells = driven(sim, 1, 0.0)
    source = sim.DCSource(amplitude=0.0)
    source.inject_into(cells)
    sim.run(20.0)
    source.amplitude = 0.5
    sim.run(20.0)
    v = voltage(cells).magnitude[:, 0]
    assert v[200] == -65.0
    assert v[400] == pytest.approx(-65.0 + 10.0 * (1 - np.exp(-1.0)))


def test_the_network_may_change_before_it_runs_and_after_a_reset_but_not_while_it_runs(
    sim: ModuleType,
    golden: Golden,
) -> None:
    cells = driven(sim)
    sim.run(30.0)
    more = driven(sim, current=2.0)
    more.set(tau_refrac=3.0)
    with golden.raises(CapabilityError, match="30.*'event'"):
        sim.run(30.0)
    before = trains(cells)[0]
    sim.reset()
    sim.run(30.0)
    assert len(trains(more, 1)[0]) > len(trains(cells, 1)[0]) > 0
    assert trains(cells, 1)[0] == before


def test_two_simulators_run_side_by_side(sim: ModuleType) -> None:
    other = new_simulator()
    other.setup(timestep=1.0, backend="spinnaker")
    first, second = driven(sim), driven(other, 2)
    sim.run(50.0)
    other.run(30.0)
    assert (sim.get_current_time(), other.get_current_time()) == (50.0, 30.0)
    assert (len(trains(first)), len(trains(second))) == (1, 2)
    assert set(trains(second)[0]) <= set(range(31))


def test_a_seed_decides_what_the_script_does_not(sim: ModuleType) -> None:
    def spikes(seed: int) -> list[list[float]]:
        sim.setup(timestep=0.1, seed=seed)
        source = sim.Population(2, sim.SpikeSourcePoisson(rate=100.0))
        source.record("spikes")
        sim.run(100.0)
        return trains(source)

    assert spikes(1) == spikes(1)
    assert spikes(1) != spikes(2)


def test_data_that_were_asked_for_as_a_file_are_written_at_the_end(sim: ModuleType, tmp_path: Path) -> None:
    cells = driven(sim)
    cells.record("v", to_file=str(tmp_path / "v.pkl"))
    sim.run(10.0)
    sim.end()
    (segment,) = neo.io.PickleIO(str(tmp_path / "v.pkl")).read_block().segments
    assert segment.analogsignals[0].shape == (101, 1)


def test_the_old_names_of_record_write_no_file(sim: ModuleType) -> None:
    cells = driven(sim)
    for whole in (cells, sim.Assembly(cells)):
        with pytest.warns(DeprecationWarning, match="record_v"):
            whole.record_v()
    sim.run(10.0)
    sim.end()
    assert cells.get_data().segments[0].filter(name="v")[0].shape == (101, 1)


def test_a_segment_without_signals_says_what_was_recorded(sim: ModuleType) -> None:
    cells = driven(sim)
    sim.run(1.0)
    (segment,) = cells.get_data("spikes").segments
    assert segment.description.endswith("There are no signals here; recorded: spikes, v.")
    assert "no signals" not in cells.get_data().segments[0].description


def test_the_module_itself_is_a_simulator_and_gives_its_network() -> None:
    sim = nrp_core.pynn
    sim.setup(timestep=0.1)
    sim.Population(4, sim.IF_cond_exp(), label="cells")
    assert list(sim.network().populations) == ["cells"]
    assert sim.run(5.0) == 5.0
    sim.end()


def test_a_wrong_backend_or_option_is_named(sim: ModuleType, golden: Golden) -> None:
    with golden.raises(UnknownBackendError, match="'event'"):
        sim.setup(backend="evnt")
    sim.setup(backend="event", options={"resolutoin": "1 ms"})
    driven(sim)
    with golden.raises(
        ExperimentError,
        match="'event': 'resolutoin'.*'resolution'",
    ):
        sim.run(1.0)


@pytest.mark.parametrize(("given", "step_ms"), [({}, 0.1), ({"timestep": "1 ms"}, 1.0)])
def test_the_step_of_the_machine_is_that_of_setup_unless_its_option_says_another(
    given: dict[str, str], step_ms: float
) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1, backend="spinnaker", options=given)
    cells = driven(sim)
    sim.run(60.0)
    (first, *_) = trains(cells)[0]
    assert sim.state.brain.capabilities.resolution_ns == round(step_ms * 1e6)
    assert first == pytest.approx(20.0 * log(20.0 / 5.0), abs=1.5 * step_ms)


def test_a_step_that_the_machine_cannot_have_is_an_error_that_names_its_option(golden: Golden) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.0005, backend="spinnaker")
    driven(sim)
    with golden.raises(ExperimentError, match="'spinnaker'"):
        sim.run(1.0)


def test_equal_initial_values_are_one_number(sim: ModuleType) -> None:
    cells = sim.Population(3, sim.IF_curr_exp(), initial_values={"v": -60.0})
    assert cells.initial_values["v"].evaluate(simplify=True) == -60.0
    assert cells.initial_values["v"].evaluate(simplify=False).tolist() == [-60.0] * 3
    cells[1:2].initialize(v=-50.0)
    assert cells.initial_values["v"].evaluate(simplify=True).tolist() == [-60.0, -50.0, -60.0]
