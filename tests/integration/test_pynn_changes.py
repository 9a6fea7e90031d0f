"""What a PyNN script changes between two runs: parameters, spike times, rates, weights."""

import subprocess
from math import exp
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from golden import Golden
from pyNN.parameters import Sequence

from nrp_core.errors import CapabilityError, NetworkError
from nrp_core.pynn import new_simulator


@pytest.fixture(params=["event", "spinnaker"])
def sim(request: pytest.FixtureRequest) -> ModuleType:
    sim = new_simulator()
    sim.setup(timestep=1.0, backend=request.param)
    return sim


def cells_of(sim: ModuleType, n: int, **parameters: Any) -> Any:
    """Return cells that a strong input makes fire once."""
    cells = sim.Population(n, sim.IF_curr_exp(cm=0.25, tau_refrac=20.0, **parameters))
    cells.initialize(v=-65.0)
    cells.record("spikes")
    return cells


def counts(cells: Any) -> list[int]:
    return list(cells.get_spike_counts().values())


def test_parameters_of_populations_views_and_cells_change_between_runs(sim: ModuleType) -> None:
    cells = cells_of(sim, 4)
    sim.run(50.0)
    assert counts(cells) == [0, 0, 0, 0]
    cells[1:3].set(i_offset=1.0)
    cells[3].i_offset = 2.0
    sim.run(50.0)
    assert counts(cells)[0] == 0
    assert counts(cells)[1] == counts(cells)[2] > 0
    assert counts(cells)[3] > counts(cells)[2]
    cells.set(i_offset=[0.0, 0.5, 0.0, 0.0])
    before = counts(cells)
    sim.run(100.0)
    assert [b - a for a, b in zip(before, counts(cells), strict=True)][2:] == [0, 0]
    assert cells.get("i_offset").tolist() == [0.0, 0.5, 0.0, 0.0]


def test_a_reset_keeps_changed_parameters(sim: ModuleType) -> None:
    cells = cells_of(sim, 1)
    sim.run(30.0)
    cells.set(i_offset=1.0)
    sim.run(30.0)
    sim.reset()
    sim.run(60.0)
    first, second = cells.get_data().segments
    assert second.spiketrains[0][0] < first.spiketrains[0][0]
    assert len(second.spiketrains[0]) > len(first.spiketrains[0])


def test_spikes_of_a_source_are_replaced_while_it_runs(sim: ModuleType) -> None:
    sources = sim.Population(3, sim.SpikeSourceArray(spike_times=[4.0, 30.0]))
    sources.record("spikes")
    sim.run(10.0)
    sources[0:2].set(spike_times=[Sequence([12.0, 15.0]), Sequence([])])
    sources[2].spike_times = [25.0]
    sim.run(30.0)
    trains = [train.magnitude.tolist() for train in sources.get_data().segments[0].spiketrains]
    assert trains == [[4.0, 12.0, 15.0], [4.0], [4.0, 25.0]]


def test_a_callback_changes_the_rate_of_a_source(sim: ModuleType) -> None:
    sources = sim.Population(40, sim.SpikeSourcePoisson(rate=0.0))
    sources.record("spikes")

    def faster(t: float) -> float:
        sources.set(rate=t / 2)
        return t + 200.0

    sim.run(600.0, callbacks=[faster])
    trains = sources.get_data().segments[0].spiketrains
    times = np.concatenate([train.magnitude for train in trains])
    found = np.histogram(times, [0.0, 200.0, 400.0, 600.0])[0]
    assert found[0] == 0
    assert found[1:] == pytest.approx([800, 1600], rel=0.15)


def test_weights_change_between_runs(sim: ModuleType) -> None:
    sources = sim.Population(2, sim.SpikeSourceArray(spike_times=[5.0, 35.0, 65.0]))
    cells = cells_of(sim, 2)
    synapse = sim.StaticSynapse(weight=5.0, delay=1.0)
    projection = sim.Projection(sources, cells, sim.OneToOneConnector(), synapse)
    sim.run(30.0)
    projection.set(weight=0.0)
    sim.run(30.0)
    projection[1].weight = 5.0
    sim.run(30.0)
    trains = [train.magnitude.tolist() for train in cells.get_data().segments[0].spiketrains]
    assert [len(train) for train in trains] == [1, 2]
    assert trains[1][1] > 65.0
    assert [w for *_, w in projection.get("weight", format="list")] == [0.0, 5.0]


def test_weights_between_assemblies_change_between_runs(sim: ModuleType) -> None:
    sources = [sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0, 35.0])) for _ in range(2)]
    targets = [cells_of(sim, 2), cells_of(sim, 1)]
    pre, post = sources[0] + sources[1], targets[0] + targets[1]
    projection = sim.Projection(pre, post, sim.AllToAllConnector(), sim.StaticSynapse(weight=5.0, delay=1.0))
    sim.run(30.0)
    projection.set(weight=np.array([[0.0, 0.0, 5.0], [0.0, 5.0, 0.0]]))
    sim.run(30.0)
    assert [*counts(targets[0]), *counts(targets[1])] == [1, 2, 2]


def test_plastic_weights_are_read_as_they_are(sim: ModuleType) -> None:
    sources = sim.Population(2, sim.SpikeSourceArray(spike_times=[Sequence([20.0, 80.0]), Sequence([28.0])]))
    cells = cells_of(sim, 1)
    stdp = sim.STDPMechanism(
        timing_dependence=sim.SpikePairRule(A_plus=0.2, A_minus=0.2),
        weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=0.1),
        weight=0.05, delay=1.0,
    )  # fmt: skip
    plastic = sim.Projection(sources[0:1], cells, sim.AllToAllConnector(), stdp)
    sim.Projection(sources[1:2], cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=5.0, delay=1.0))
    assert plastic.get("weight", format="array") == pytest.approx(0.05)
    sim.run(90.0)
    fired = cells.get_data().segments[0].spiketrains[0].magnitude[0]
    change = 0.1 * 0.2 * (exp(-(fired + 1.0 - 20.0) / 20.0) - exp(-(80.0 - fired - 1.0) / 20.0))
    assert plastic.get("weight", format="array")[0, 0] == pytest.approx(0.05 + change, abs=0.0015)
    plastic.set(weight=0.08)
    assert plastic.get("weight", format="array")[0, 0] == pytest.approx(0.08, rel=0.01)


def test_an_attribute_that_is_fixed_during_a_run_keeps_its_value(sim: ModuleType, golden: Golden) -> None:
    sources = sim.Population(1, sim.SpikeSourceArray(spike_times=[5.0]))
    cells = cells_of(sim, 1)
    synapse = sim.StaticSynapse(weight=1.0, delay=2.0)
    projection = sim.Projection(sources, cells, sim.AllToAllConnector(), synapse, label="wire")
    sim.run(10.0)
    with golden.raises(CapabilityError, match="'wire'.*10"):
        projection.set(delay=3.0)
    with golden.raises(NetworkError, match="tau_m.*-1"):
        cells.set(tau_m=-1.0)
    assert projection.get("delay", format="array") == 2.0
    assert cells.get("tau_m") == 20.0
    sim.reset()
    projection.set(delay=3.0)
    sim.run(10.0)
    assert projection.get("delay", format="array") == 3.0


def test_a_script_that_asks_for_its_simulator_by_name_gets_it(warm: Path, tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "from pyNN.utility import get_simulator\n"
        "sim, options = get_simulator(('--current', 'nA', {'type': float}))\n"
        "sim.setup()\n"
        "cell = sim.Population(1, sim.IF_curr_exp(i_offset=options.current))\n"
        "cell.record('spikes')\n"
        "sim.run(100.0)\n"
        "print(options.simulator, cell.get_spike_counts())\n"
    )
    command = [warm / "python", "-m", "nrp_core.pynn", str(script), "nrp", "--current", "1.5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert not done.stderr
    name, count = done.stdout.split(maxsplit=1)
    assert name == "nrp"
    assert count.strip() != "{0: 0}"


SCRIPT = """\
import {simulator} as sim
from parts import SIZE

sim.setup(timestep=0.1, threads=2)
cells = sim.Population(SIZE, sim.IF_curr_exp(i_offset=1.5), label="cells")
cells.record("spikes")
sim.run(100.0)
print(__name__, sum(cells.get_spike_counts().values()) > 0)
"""


@pytest.mark.parametrize(
    ("simulator", "output", "told"),
    [
        ("pyNN.nest", "__main__ True\n", "note: pyNN.nest is nrp_core.pynn here, which runs the network in"),
        ("nrp_core.pynn", "__main__ True\n", ""),
        ("pyNN.spiNNaker", "", "script.py:1: imports 'pyNN.spiNNaker', so it is run with `--as spinnaker`"),
    ],
)
def test_a_script_of_another_simulator_runs_with_one_note(
    simulator: str, output: str, told: str, warm: Path, tmp_path: Path
) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.format(simulator=simulator))
    (tmp_path / "parts.py").write_text(f"import {simulator}\n\nSIZE = 2\n")
    command = [warm / "python", "-m", "nrp_core.pynn", str(script)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout == output
    assert [line.count(told) for line in done.stderr.splitlines()] == ([1] if told else [])
    assert done.returncode == (0 if output else 1)
