"""Recordings of scripts of sPyNNaker have the times of a machine.

The expected spikes of the first two tests are those that sPyNNaker's own tests demand of a machine
(``test_set_toffset`` and ``test_one_pop_lif_example`` of its integration tests).
"""

from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from spynnaker_scripts import HEAD, refused, run

MEMBRANE = "cm=0.25, tau_m=20.0, tau_refrac=2.0, v_rest=-65.0, v_reset=-70.0, v_thresh=-50.0"


def trains(population: Any) -> list[list[float]]:
    return [train.magnitude.tolist() for train in population.get_data("spikes").segments[0].spiketrains]


def test_cells_fire_at_the_times_of_a_machine(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + f"cells = p.Population(6, p.IF_curr_exp(i_offset=0.0, {MEMBRANE}))\ncells.record('spikes')\n"
        "p.run(100)\ncells.set(i_offset=1)\np.run(100)\ncells.set(i_offset=2)\np.run(100)\n",
    )
    assert trains(script.cells) == [[*range(104, 200, 8), *range(200, 300, 5)]] * 6


def test_initial_voltages_lead_to_the_spikes_of_a_machine(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "v = [0.0, 0.0146789550781, 0.029296875, 0.0438842773438, 0.0584106445312]\n"
        "cells = p.Population(5, p.IF_curr_exp, {'tau_m': 333.33, 'cm': 208.33, 'v': v, 'v_rest': 0.1,\n"
        "    'v_reset': 0.0, 'v_thresh': 1.0, 'tau_syn_E': 1, 'tau_syn_I': 2, 'tau_refrac': 2.5,\n"
        "    'i_offset': 3.0})\n"
        "cells.record('spikes')\np.run(100)\n",
    )  # fmt: skip
    assert trains(script.cells) == [[76.0], [75.0], [74.0], [73.0], [72.0]]


def test_a_run_is_rounded_up_to_whole_steps(tmp_path: Path) -> None:
    """As ``AbstractSpinnakerBase.__timesteps`` does."""
    lines = "p.Population(1, p.IF_curr_exp())\nends = [p.run(5.7), p.run(1.0000001), p.run_until(9.2)]\n"
    assert run(tmp_path, HEAD + lines).ends == [6.0, 7.0, 10.0]


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        (
            "i_offset=1.0",
            [-65.0, -64.024658203125, -63.09686279296875, -62.214324951171875, -61.37481689453125],
        ),
        (
            "i_offset=1.0, v=-60.0",
            [-60.0, -59.26849365234375, -58.5726318359375, -57.91070556640625, -57.28106689453125],
        ),
    ],
)
def test_voltages_are_those_of_a_machine_in_every_bit_after_a_reset_too(
    tmp_path: Path, setting: str, expected: list[float]
) -> None:
    """The values are those of ``test_no_change`` of sPyNNaker's integration tests."""
    script = run(
        tmp_path,
        HEAD + f"cells = p.Population(1, p.IF_curr_exp, {{}})\ncells.set({setting})\ncells.record('v')\n"
        "p.run(2)\ncells.set(tau_syn_E=1)\np.run(3)\nfirst = cells.spinnaker_get_data('v')\n"
        "p.reset()\ncells.set(tau_syn_E=1)\np.run(5)\nsecond = cells.spinnaker_get_data('v')\n",
    )
    assert script.first[:, 2].tolist() == script.second[:, 2].tolist() == expected


def test_a_synfire_chain_fires_as_often_as_on_a_machine(tmp_path: Path) -> None:
    """A ring of 200 cells with delays of 17 ms; a spike goes round in 200 (17 + 2) ms."""
    script = run(
        tmp_path,
        HEAD + "n = 200\nring = [(i, (i + 1) % n, 2.0, 17) for i in range(n)]\n"
        f"cells = p.Population(n, p.IF_curr_exp({MEMBRANE}))\n"
        "first = p.Population(1, p.SpikeSourceArray([[0]]))\n"
        "p.Projection(cells, cells, p.FromListConnector(ring), p.StaticSynapse())\n"
        "p.Projection(first, cells, p.FromListConnector([(0, 0)]), p.StaticSynapse(weight=2.0, delay=1))\n"
        "cells.record('spikes')\np.run(5000)\n",
    )
    spikes = trains(script.cells)
    assert sum(map(len, spikes)) == 263  # of sPyNNaker's tests of synfire chains
    assert spikes[0] == [3.0, 3803.0]


CHAIN = """
inputs = p.Population(2, p.SpikeSourceArray([[0.0, 10.0], [4.3]]))
cells = p.Population(2, p.IF_curr_exp(tau_syn_E=5.0))
p.Projection(inputs, cells, p.OneToOneConnector(), p.StaticSynapse(weight=1.0, delay=3.0))
inputs.record("spikes")
cells.record(["v", "gsyn_exc"], sampling_interval={interval})
"""


def test_a_run_has_a_sample_for_each_step_and_an_input_is_in_that_of_its_arrival(tmp_path: Path) -> None:
    script = run(tmp_path, HEAD + CHAIN.format(interval=1) + "p.run(6)\np.run(4)\n")
    signals = {one.name: one.magnitude for one in script.cells.get_data().segments[0].analogsignals}
    input_na = 5.0 * (1.0 - exp(-1 / 5.0))  # the mean of an exponential over its first step
    decays = [input_na * exp(-k / 5.0) for k in range(7)]
    assert signals["gsyn_exc"][:, 0] == pytest.approx([0.0] * 3 + decays, abs=3e-4)
    assert signals["gsyn_exc"][:, 1] == pytest.approx([0.0] * 8 + decays[:2], abs=3e-4)
    assert (signals["v"] > -65.0).argmax(axis=0).tolist() == [4, 9]
    assert signals["v"].shape == (10, 2)


def test_sources_fire_at_the_beginning_of_a_step(tmp_path: Path) -> None:
    script = run(tmp_path, HEAD + CHAIN.format(interval=1) + "p.run(10)\n")
    assert trains(script.inputs) == [[0.0], [5.0]]  # the spike at 10 ms is of the next step
    script = run(tmp_path, HEAD + CHAIN.format(interval=1) + "p.run(11)\n")
    assert trains(script.inputs) == [[0.0, 10.0], [5.0]]


@pytest.mark.parametrize(
    "times",
    ["[9, 2, 5]", "[[9, 2, 5], [9.0, 5, 2]]", "[np.array([9, 2, 5]), (2, 5, 9)]", "np.array([9, 2, 5])"],
)
def test_spike_times_need_no_order(tmp_path: Path, times: str) -> None:
    script = run(
        tmp_path,
        HEAD
        + f"import numpy as np\nsources = p.Population(2, p.SpikeSourceArray, {{'spike_times': {times}}})\n"
        "sources.record('spikes')\np.run(10)\nfirst = sources.get_data('spikes').segments[0].spiketrains\n"
        f"p.reset()\nsources.set(spike_times=[3, 1])\np.run(10)\n",
    )
    assert [train.magnitude.tolist() for train in script.first] == [[2.0, 5.0, 9.0]] * 2
    second = script.sources.get_data("spikes").segments[1].spiketrains
    assert [train.magnitude.tolist() for train in second] == [[1.0, 3.0]] * 2


VARIABLE = "p.extra_models.SpikeSourcePoissonVariable"


@pytest.mark.parametrize("shared", [False, True])
def test_rates_change_at_their_times(tmp_path: Path, caplog: pytest.LogCaptureFixture, shared: bool) -> None:
    lists = [[100.0, 0.0, 400.0], [100.0, 300.0, 700.0], [500.0, 400.0, 200.0]]  # the first is cut at 300 ms
    rates, starts, durations = lists if shared else ([each] * 200 for each in lists)
    script = run(
        tmp_path,
        HEAD + f"noise = p.Population(200, {VARIABLE}, {{'rates': {rates}, 'starts': {starts},\n"
        f"    'durations': {durations}}}, additional_parameters={{'seed': 24534}})\n"
        "noise.record('spikes')\np.run(1000)\n",
    )
    times = np.concatenate(trains(script.noise))
    counts, _ = np.histogram(times, [0, 101, 301, 701, 901, 1000])
    expected = np.array([0.0, 200 * 0.2 * 100.0, 0.0, 200 * 0.2 * 400.0, 0.0])
    assert (abs(counts - expected) <= 4.0 * np.sqrt(expected)).all()
    assert not any("between time steps" in text for text in caplog.messages)


def test_the_last_rate_stays_without_durations(tmp_path: Path) -> None:
    """As ``test_variable_rate.py`` of sPyNNaker, whose sources of 7.4.1 have no durations by default."""
    script = run(
        tmp_path,
        HEAD + f"noise = p.Population(200, {VARIABLE}(rates=[100.0, 10.0, 50.0], starts=[0, 500, 1000]))\n"
        "noise.record('spikes')\np.run(700)\np.run(2500)\np.reset()\np.run(300)\n",
    )
    first, again = (part.spiketrains for part in script.noise.get_data("spikes").segments)
    times = np.concatenate([train.magnitude for train in first])
    counts, _ = np.histogram(times, [0, 500.5, 1000.5, 2000.5, 3200])
    expected = 200 * np.array([0.5 * 100.0, 0.5 * 10.0, 50.0, 1.2 * 50.0])
    assert (abs(counts - expected) <= 4.0 * np.sqrt(expected)).all()
    assert [t.tolist() for t in again] == [train[train.magnitude < 300.0].tolist() for train in first]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("[[5.0], [6.0]], [0.0], [9.0]", "rates has 2 lists for 3 cells"),
        ("[5.0, 6.0], [0.0], [9.0]", "rates, starts and durations of a cell must be of one length"),
        ("[-5.0], [0.0], [9.0]", "rates has a value that is not a number of 0 or more"),
    ],
)
def test_rates_of_other_lengths_are_refused(tmp_path: Path, given: str, expected: str) -> None:
    assert expected in str(refused(tmp_path, f"p.Population(3, {VARIABLE}({given}))"))


def test_noise_is_on_the_steps_and_acts_there(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + "noise = p.Population(20, p.SpikeSourcePoisson(rate=50.0))\n"
        "cells = p.Population(20, p.IF_curr_exp())\n"
        "p.Projection(noise, cells, p.OneToOneConnector(), p.StaticSynapse(weight=0.5, delay=1.0))\n"
        "noise.record('spikes')\ncells.record('gsyn_exc')\np.run(200)\n",
    )  # fmt: skip
    current = script.cells.get_data().segments[0].analogsignals[0].magnitude
    for cell, times in enumerate(trains(script.noise)):
        rises = np.flatnonzero(np.diff(current[:, cell]) > 0.0) + 1
        assert sorted({int(time) + 1 for time in times if time < 199}) == rises.tolist()


def test_samples_at_longer_intervals_begin_with_a_run(tmp_path: Path) -> None:
    script = run(
        tmp_path,
        HEAD + CHAIN.format(interval=3) + "p.run(10)\nfirst = cells.get_data(clear=True)\np.run(9)\n",
    )
    assert [one.shape for one in script.first.segments[0].analogsignals] == [(4, 2)] * 2  # 0, 3, 6, 9 ms
    assert [one.shape for one in script.cells.get_data().segments[0].analogsignals] == [(3, 2)] * 2


def test_data_name_their_cells_as_those_of_a_machine(tmp_path: Path) -> None:
    """``source_id`` and ``source_ids`` as in ``neo_csv.py`` of sPyNNaker 7.4.1, and in PyNN until 0.9."""
    lines = "p.Population(3, p.IF_curr_exp())\ncells = p.Population(2, p.IF_curr_exp())\n"
    script = run(tmp_path, f"{HEAD}{lines}cells.record(['spikes', 'v'])\np.run(2)\ndata = cells.get_data()\n")
    segment, first = script.data.segments[0], int(script.cells.first_id)
    assert [train.annotations["source_id"] - first for train in segment.spiketrains] == [0, 1]
    assert (segment.analogsignals[0].annotations["source_ids"] - first).tolist() == [0, 1]
