"""A script that runs by itself is told what is doubtful in its network, as an experiment is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import NetworkError, NrpError
from nrp_core.pynn import new_simulator


def network(**synapse: Any) -> tuple[Any, Any]:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    noise = sim.Population(4, sim.SpikeSourcePoisson(rate=50.0), label="noise")
    cells = sim.Population(4, sim.IF_cond_exp(), label="cells")
    values = {"weight": 0.01, "delay": 1.0, **synapse}
    sim.Projection(noise, cells, sim.AllToAllConnector(), sim.StaticSynapse(**values), label="p")
    return sim, cells


def told(sim: Any, caplog: pytest.LogCaptureFixture) -> list[str]:
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        sim.run(1.0)
        sim.reset()
        sim.run(1.0)
    return [one.getMessage() for one in caplog.records if one.name.startswith("nrp_core.pynn")]


def test_a_correct_script_causes_no_warning(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    sim.DCSource(amplitude=0.5, start=0.2).inject_into(cells)
    assert told(sim, caplog) == []


def test_a_label_that_is_used_twice_is_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    sim, _ = network()
    sim.Population(2, sim.IF_cond_exp(), label="cells")
    assert told(sim, caplog) == ["two populations have the label 'cells'; the later one is called 'cells 2'"]


def test_cells_of_a_network_that_is_gone_record_nothing(golden: Golden) -> None:
    sim, cells = network()
    sim.setup(timestep=0.1)
    with golden.raises(NetworkError, match="'cells'"):
        cells.record("v")


def test_a_current_ends_after_it_begins(golden: Golden) -> None:
    sim, _ = network()
    with golden.raises(ValueError, match="DCSource.*10.*20"):
        sim.DCSource(amplitude=0.5, start=20.0, stop=10.0)
    source = sim.DCSource(amplitude=0.5, start=20.0)
    with golden.raises(ValueError, match="DCSource.*10.*20"):
        source.stop = 10.0


def test_an_instance_of_cells_takes_no_further_parameters(golden: Golden) -> None:
    sim, _ = network()
    with golden.raises(ValueError, match=r"'more'.*IF_cond_exp\(...\)"):
        sim.Population(2, sim.IF_cond_exp(), cellparams={"tau_m": 10.0}, label="more")


def test_missing_recorded_data_are_reported_once(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    cells.record("spikes")
    assert told(sim, caplog) == []
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        for _ in range(2):
            cells.get_data()
            cells.get_spike_counts()
            cells.get_data(["spikes", "v"])
        cells.record("v")
        cells.get_data("v")  # nothing has run since
        sim.run(1.0)
        cells.get_data("v")
    assert [one.getMessage() for one in caplog.records] == [
        "population 'cells': 'v' is not recorded, so there are no data of it: call record('v')",
        "population 'cells': 'v' is recorded from 1 ms on, and nothing has run since: call record() before "
        "run()",
    ]


@pytest.mark.parametrize("variables", ["spikes", ""])
def test_cells_without_a_recording_are_reported(variables: str, caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    if variables:
        cells.record(variables)
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        sim.run(2.0)
        cells.get_data()
    doubt = (
        "population 'cells': nothing is recorded, so there are no data: call record('spikes') before run()"
    )
    assert caplog.messages == ([] if variables else [doubt])


def test_spikes_of_cells_that_are_not_recorded_are_not_counted_in_silence(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sim, cells = network()
    assert told(sim, caplog) == []
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        assert cells.mean_spike_count() == 0.0
    (text,) = (one.getMessage() for one in caplog.records)
    assert "'spikes' is not recorded" in text


@pytest.mark.parametrize(("first_ms", "count"), [(0.5, 0), (2.0, 1)])
def test_sources_that_begin_after_the_run_are_reported_at_its_end(
    first_ms: float, count: int, caplog: pytest.LogCaptureFixture
) -> None:
    sim, cells = network()
    late = sim.Population(2, sim.SpikeSourceArray(spike_times=[first_ms, 3.0]), label="late")
    sim.Projection(late, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=1.0))
    assert told(sim, caplog) == []
    sim.end()
    texts = [one.getMessage() for one in caplog.records if "no cell of 'late' fired" in one.getMessage()]
    assert len(texts) == count
    assert all("begin at 2 ms, and the longest run ended at 1 ms" in text for text in texts)


@pytest.mark.parametrize(("runs_ms", "says"), [((0.2,), True), ((0.2,) * 5, False), ((200.0,), False)])
def test_a_duration_in_seconds_is_reported_at_the_end(
    runs_ms: tuple[float, ...], says: bool, caplog: pytest.LogCaptureFixture
) -> None:
    sim, _ = network()
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        for run_ms in runs_ms:
            sim.run(run_ms)
        sim.end()
    doubt = "the longest run ended at 0.2 ms: times are in ms, is it meant in s?"
    assert caplog.messages == ([doubt] if says else [])


def test_sources_whose_spikes_were_moved_during_a_run_are_not_reported(
    caplog: pytest.LogCaptureFixture,
) -> None:
    sim, cells = network()
    moved = sim.Population(1, sim.SpikeSourceArray(spike_times=[50.0]), label="moved")
    sim.Projection(moved, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.01, delay=1.0))
    sim.run(1.0)
    moved.set(spike_times=[[1.5]])
    sim.run(1.0)
    sim.end()
    assert [one.getMessage() for one in caplog.records] == []


def test_a_misspelt_setting_is_refused_and_those_of_other_simulators_are_not(golden: Golden) -> None:
    sim = new_simulator()
    with golden.raises(NetworkError, match="'sead'.*'seed'"):
        sim.setup(timestep=0.1, sead=3)
    others = {"threads": 2, "rng_seed": 4, "rng_seeds": [4], "spike_precision": "on_grid", "use_cvode": True}
    sim.setup(timestep=0.1, verbosity="error", t_flush=1, time_scale_factor=2, **others)


@pytest.mark.parametrize("answer", [None, 0.0, -1.0])
def test_a_callback_that_names_no_later_time_is_refused(answer: float | None, golden: Golden) -> None:
    sim, _ = network()
    with golden.raises(NetworkError):
        sim.run(1.0, callbacks=[lambda t: answer])


def test_callbacks_with_a_list_of_times_and_without_an_answer_at_the_end_are_fine() -> None:
    sim, _ = network()
    times, called = iter([0.0, 0.2, 0.5, 1.0]), []

    def act(t: float) -> float | None:
        called.append(t)
        return next(times, None)

    sim.run(1.0, callbacks=[act])
    assert called == [0.0, 0.0, 0.2, 0.5, 1.0]


def test_a_sample_larger_than_its_population_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    sim, cells = network()
    assert cells.sample(4).size == 4
    assert cells.sample(9).size == 4
    assert told(sim, caplog) == ["a sample of 9 cells of 'cells' has 4: there are no more"]


def test_a_file_that_cannot_be_written_is_refused_when_it_is_named(tmp_path: Path, golden: Golden) -> None:
    sim, cells = network()
    with golden.raises(NetworkError, match=r"'v\.pki'.*'\.pkl'"):
        cells.record("v", to_file="v.pki")
    cells.record("v", to_file=str(tmp_path / "v.pkl"))
    sim.run(1.0)
    sim.end()
    assert (tmp_path / "v.pkl").exists()


def test_a_misspelt_option_of_the_backend_gets_the_nearest(golden: Golden) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1, options={"tolerence": 1e-6})
    sim.Population(1, sim.IF_curr_exp())
    with golden.raises(NrpError, match="'tolerence'.*'tolerance'"):
        sim.run(1.0)


@pytest.mark.filterwarnings("ignore:connect")
@pytest.mark.parametrize("way", ["Projection", "connect"])
def test_a_delay_that_the_backend_refuses_is_named_at_the_line_of_its_projection(
    way: str, golden: Golden
) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1)
    one, other = sim.Population(2, sim.IF_curr_exp()), sim.Population(2, sim.IF_curr_exp(), label="other")
    sim.Projection(one, other, sim.AllToAllConnector(), sim.StaticSynapse(delay=1.0))
    if way == "connect":
        sim.connect(one, other, weight=0.1, delay=0.0)
    else:
        sim.Projection(one, other, sim.AllToAllConnector(), sim.StaticSynapse(delay=0.0), label="at once")
    lines = Path(__file__).read_text().splitlines()
    with golden.raises(NetworkError) as caught:
        sim.run(1.0)
    assert caught.value.path == Path(__file__)
    assert caught.value.line is not None
    assert "delay=0.0" in lines[caught.value.line - 1]
    assert way in lines[caught.value.line - 1]


@pytest.mark.parametrize(
    ("interval_ms", "resolution", "is_told"), [(0.5, "1 ms", True), (2.0, "1 ms", False), (0.5, None, False)]
)
def test_times_between_the_steps_of_a_brain_are_reported(
    interval_ms: float, resolution: str | None, is_told: bool, caplog: pytest.LogCaptureFixture
) -> None:
    sim = new_simulator()
    sim.setup(timestep=0.1, options={} if resolution is None else {"resolution": resolution})
    cells = sim.Population(1, sim.IF_curr_exp(i_offset=1.0), label="cells")
    cells.record("v", sampling_interval=interval_ms)
    expected = "sampling_interval of 'cells' is 0.5 ms, and there are values every 1 ms: the others are NaN"
    with caplog.at_level("WARNING", "nrp_core.pynn"):
        sim.run(4.0)
    assert [one.getMessage() for one in caplog.records] == [expected] * is_told
    values = cells.get_data("v").segments[0].analogsignals[0].magnitude
    assert bool(np.isnan(values).any()) == is_told
