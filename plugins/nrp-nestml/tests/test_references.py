"""Neurons have the spikes and voltages of NESTML's own Python, within the errors that the docs state."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_core.pynn import new_simulator

from nrp_nestml.cell import cell_of

MODELS = Path(sys.prefix) / "models/neurons"
REFERENCES = Path(__file__).parent / "references"
PAGE = Path(__file__).parents[3] / "docs/reference/nestml-neurons.md"
STEP_MS = 0.1
IN_EACH_RUN = ("iaf_psc_exp", "mat2_psc_exp", "izhikevich", "aeif_cond_exp", "hh_psc_alpha")
"""One for each kind of equations; the others take minutes together."""
LATE = {"grid": 0.0, "crossing": 0.0, "peak": 0.1}
"""Steps between a spike and that of the reference, which sees that a voltage falls when two samples do."""
ROWS = {
    name: (int(spikes), float(error))
    for name, spikes, error in re.findall(
        r"^\| `(\w+)` \|.*\| (\d+) \| (\S+) \|$", PAGE.read_text(), re.MULTILINE
    )
}
CASES = [pytest.param(name, marks=() if name in IN_EACH_RUN else pytest.mark.heavy) for name in sorted(ROWS)]


def of(name: str) -> dict[str, Any]:
    """Return the reference of a neuron."""
    found: dict[str, Any] = json.loads((REFERENCES / f"{name}_neuron.json").read_text())
    return found


def response(cell: dict[str, Any], reference: dict[str, Any]) -> tuple[list[list[int]], Any]:
    """Return the steps of spikes, and the values at the times of the reference, of its cells."""
    sim = new_simulator()
    sim.setup(timestep=STEP_MS)
    cells = sim.Population(len(reference["cells"]), sim.EquationCell(**cell)())
    for k, given in enumerate(reference["cells"]):
        one, current = cells[k : k + 1], given["current"]
        one.set(**given["parameters"])
        if current["pa"]:
            times = {"start": current["start_ms"], "stop": current["stop_ms"]}
            sim.DCSource(amplitude=current["pa"] / 1000.0, **times).inject_into(one)
        for port, train in given["spikes"].items():
            times = [(step - 10) * STEP_MS for step in train["steps"]]
            source = sim.Population(1, sim.SpikeSourceArray(spike_times=times))
            synapse = sim.StaticSynapse(weight=train["weight"], delay=1.0)
            usual = "inhibitory" if port == "inh_spikes" else "excitatory"
            receptor = port if port in cell["receptors"] else usual
            sim.Projection(source, one, sim.OneToOneConnector(), synapse, receptor_type=receptor)
    cells.record(["spikes", "V_m"])
    every = round(reference["every_ms"] / STEP_MS)
    sim.run(len(reference["cells"][0]["values"]) * reference["every_ms"])
    data = cells.get_data().segments[0]
    spikes = [np.rint(np.asarray(train) / STEP_MS).astype(int).tolist() for train in data.spiketrains]
    return spikes, np.asarray(data.filter(name="V_m")[0])[every::every]


def expected(reference: dict[str, Any]) -> tuple[list[list[float]], Any]:
    """Return the times of spikes, in steps, and the values of the reference."""
    fired = [np.round(np.array(each["fired_ms"]) / STEP_MS, 4).tolist() for each in reference["cells"]]
    return fired, np.array([each["values"] for each in reference["cells"]]).T


def are_same(spikes: list[list[int]], theirs: list[list[float]], late: float) -> bool:
    """Return whether spikes are at the next grid points; a reference may be late by so many steps."""
    return list(map(len, spikes)) == list(map(len, theirs)) and all(
        np.ceil(time - late) <= step <= np.ceil(time)
        for train, times in zip(spikes, theirs, strict=True)
        for step, time in zip(train, times, strict=True)
    )


@pytest.mark.parametrize("name", CASES)
def test_a_neuron_is_that_of_nestmls_own_python(name: str) -> None:
    n_spikes, most = ROWS[name]
    reference = of(name)
    cell = cell_of(MODELS / f"{name}_neuron.nestml")
    spikes, values = response(cell, reference)
    their_spikes, theirs = expected(reference)
    assert sum(map(len, their_spikes)) == n_spikes
    assert all(len(train) >= 1 for train in their_spikes)
    assert are_same(spikes, their_spikes, LATE[reference["steps"]])
    assert np.abs(values - theirs).max() <= most
    assert np.ptp(theirs, axis=0).min() > 5.0


@pytest.mark.parametrize("name", CASES)
def test_a_neuron_with_a_parameter_that_is_wrong_by_a_percent_is_found(name: str) -> None:
    reference = of(name)
    cell = cell_of(MODELS / f"{name}_neuron.nestml")
    wrong = next(key for key in ("tau_m", "C_m", "a") if key in cell["parameters"])
    number, _, unit = cell["parameters"][wrong].partition(" ")
    changed = {**cell["parameters"], wrong: f"{1.01 * float(number)!r} {unit}".strip()}
    _, values = response({**cell, "parameters": changed}, reference)
    _, theirs = expected(reference)
    assert np.abs(values - theirs).max() > 10 * ROWS[name][1]
