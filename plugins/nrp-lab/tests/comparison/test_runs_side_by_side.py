"""The runs of a grid that step together are recorded, bit for bit, as those that were made one by one."""

import json
from pathlib import Path
from typing import Any

import pytest
from nrp_lab import copies
from nrp_lab.comparison.divergence import divergence_of
from nrp_lab.comparison.grid import GridCell, RunGrid, record, run_grid
from nrp_lab.comparison.signals import RunSignals

from nrp_core.recording import Recording

FAILING = """
import hbp_nrp_client.tf_framework as nrp
import numpy as np
from sensor_msgs.msg import LaserScan

@nrp.MapRobotSubscriber("scan", nrp.Topic("/pioneer/scan", LaserScan))
@nrp.Robot2Neuron(triggers=["scan"], vectorized=True)
def look(t, scan):
    if t > 0.1 and np.isinf(scan.value.ranges).all(axis=1).any():
        END
"""


@pytest.fixture
def together(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The numbers of runs that took each step together."""
    numbers: list[int] = []

    class Counted(copies.SideBySide):
        def step(self, loops: Any) -> dict[int, Exception]:
            numbers.append(len(loops))
            return super().step(loops)

    monkeypatch.setattr(copies, "SideBySide", Counted)
    return numbers


def result(folder: Path) -> Any:
    """Return the result in a recording, without times."""
    found = json.loads((folder / "run.json").read_text())["result"]
    times = ("wall_time_s", "real_time_factor", "time_share")
    return {key: value for key, value in found.items() if key not in times}


def require_equal_to_those_alone(grid: RunGrid, folder: Path) -> dict[GridCell, Any]:
    found = run_grid(grid, folder / "together", 1, lambda *_: None)
    for cell, signals in found.items():
        alone = grid.folder(folder / "alone", cell)
        record(grid, cell, alone, revise=grid.revise(cell))
        assert divergence_of(signals, RunSignals(Recording(alone))).is_identical
        assert result(grid.folder(folder / "together", cell)) == result(alone)
    return {cell: result(grid.folder(folder / "together", cell)) for cell in found}


def test_seeds_and_controls_step_together(tmp_path: Path, together: list[int]) -> None:
    grid = RunGrid.of("slalom_pioneer", [], [], 2, ["duration=0.4 s"], controls=["silence: feelers"])
    require_equal_to_those_alone(grid, tmp_path)
    assert set(together) == {len(grid.cells)}


def test_a_function_that_fails_in_one_run_leaves_the_others_alone(tmp_path: Path) -> None:
    (tmp_path / "fail.py").write_text(FAILING.replace("END", 'raise ValueError("nothing in sight")'))
    grid = RunGrid(
        "slalom_pioneer", ("event",), ("mujoco",), (1, 2),
        ("duration=0.24 s", "on_error=stop", f"transfer_functions=[{tmp_path / 'fail.py'}]"),
        wirings=("original", "outside"),
        others={"outside": ["world.robots.pioneer.pose=[-200, 0, 0.0975, 0, 0, 0]"]},
    )  # fmt: skip
    results = require_equal_to_those_alone(grid, tmp_path)
    assert {cell.wiring: one["complete"] for cell, one in results.items()} == {
        "original": True,
        "outside": False,
    }


@pytest.mark.heavy
def test_a_run_that_kills_its_process_is_named_and_the_others_are_kept(tmp_path: Path) -> None:
    (tmp_path / "fail.py").write_text(FAILING.replace("END", '__import__("os")._exit(1)'))
    grid = RunGrid(
        "slalom_pioneer", ("event",), ("mujoco",), (1, 2),
        ("duration=0.24 s", f"transfer_functions=[{tmp_path / 'fail.py'}]"),
        wirings=("original", "outside"),
        others={"outside": ["world.robots.pioneer.pose=[-200, 0, 0.0975, 0, 0, 0]"]},
    )  # fmt: skip
    with pytest.raises(copies.NrpError, match="outside"):
        run_grid(grid, tmp_path / "out", 2, lambda *_: None)
