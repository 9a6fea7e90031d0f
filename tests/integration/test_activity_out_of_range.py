"""A run whose brain is driven out of the range of neurons says so, and an ordinary one does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

_BRAIN = """import nrp_core.pynn as sim
cells = sim.Population(2, sim.{cell}, label="cells")
sim.Projection(cells, cells, sim.AllToAllConnector(), sim.StaticSynapse(weight=0.1, delay=1.0), label="loop")
"""
_FUNCTIONS = """
class Weights(nrp.CustomDevice):
    def apply(self, neurons, brain):
        self._brain = brain

    def set(self, weight):
        self._brain.set_weights("loop", weight)


@nrp.MapSpikeSink("weights", nrp.brain.cells, Weights())
@nrp.Neuron2Robot()
def learn(t, weights):
    weights.set({weight} * t)
"""
_FILE = """name: cells
timestep: 20 ms
duration: 200 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
transfer_functions: [learn.py]
"""
_ROOM = '<sdf version="1.9"><world name="room"/></sdf>'


@pytest.mark.parametrize(
    ("cell", "weight", "words"),
    [
        ("IF_curr_exp(i_offset=3.0, tau_refrac=2.0)", 0.1, []),
        ("IF_curr_exp(i_offset=49.0, tau_refrac=0.01)", 0.1, ["of the population 'cells' fired"]),
    ],
    ids=["ordinary", "fast"],
)
def test_activity_that_no_neuron_has_is_reported_once(
    tmp_path: Path, cell: str, weight: float, words: list[str]
) -> None:
    texts = {
        "brain.py": _BRAIN.format(cell=cell),
        "learn.py": _FUNCTIONS.format(weight=weight),
        "experiment.yaml": _FILE,
        "room.sdf": _ROOM,
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    with Run(load_experiment(str(tmp_path / "experiment.yaml"))) as run:
        run.run()
        found = [str(one) for one in run.problems if "NRP297" in str(one)]
    assert len(found) == len(words)
    assert all(word in one for word, one in zip(words, found, strict=True))
