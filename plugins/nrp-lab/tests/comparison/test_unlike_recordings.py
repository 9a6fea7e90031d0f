"""Recordings of networks of different sizes are compared in what they have in common."""

from __future__ import annotations

from pathlib import Path

from nrp_lab.comparison.metric import all_metrics
from nrp_lab.comparison.result import PairDiff

from nrp_core.cli import app

_BRAIN = """import nrp_core.pynn as sim
sim.Population({cells}, sim.IF_curr_exp(i_offset=1.5), label="cells")
sim.Population(3, sim.IF_curr_exp(i_offset={offset}), label="others")
"""
_FILE = """name: cells
duration: 200 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
"""


def _recorded(folder: Path, **values: float) -> Path:
    folder.mkdir()
    (folder / "brain.py").write_text(_BRAIN.format(**values))
    (folder / "experiment.yaml").write_text(_FILE)
    (folder / "room.sdf").write_text('<sdf version="1.9"><world name="room"/></sdf>')
    assert app.run_app(["run", str(folder), "--record", str(folder / "recording")]) == 0
    return folder / "recording"


def test_populations_of_two_sizes_are_left_out_and_named(tmp_path: Path) -> None:
    one = _recorded(tmp_path / "one", cells=2, offset=1.5)
    other = _recorded(tmp_path / "other", cells=5, offset=2.0)
    pair = PairDiff.of(one, other, all_metrics())
    told = "'cells' has 2 neurons in one and 5 in the other: their trains are not compared"
    assert pair.reservations == [told]
    (trains,) = [row for row in pair.measured if row.metric.name == "spike_trains"]
    assert trains.part == "others"
    assert trains.apart
