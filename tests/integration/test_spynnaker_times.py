"""Recordings of scripts of sPyNNaker have the times of a machine.

The expected spikes of the first two tests are those that sPyNNaker's own tests demand of a machine
(``test_set_toffset`` and ``test_one_pop_lif_example`` of its integration tests).
"""

from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from spynnaker_scripts import HEAD, run

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
