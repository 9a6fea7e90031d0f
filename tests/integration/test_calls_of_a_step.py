"""A step of the loop takes no more Python calls than when a world got an engine; see decision 33."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "calls.py"


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "most"), [("mujoco", (326, 187, 81)), ("pybullet", (389, 213, 144))])
def test_a_step_with_an_image_takes_no_more_calls(engine: str, most: tuple[int, int, int]) -> None:
    if engine == "pybullet":
        pytest.importorskip("pybullet")
    if sys.getprofile() is not None:
        pytest.skip("somebody else profiles")
    counts = runpy.run_path(str(BENCHMARK))["measure"](engine)
    found = counts.calls, counts.changes, counts.world
    assert all(a <= b for a, b in zip(found, most, strict=True)), f"{found}: calls, changes, under World"
