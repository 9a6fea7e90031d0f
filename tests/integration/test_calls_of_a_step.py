"""A step of the loop takes few Python calls.

The bounds are those of a world with an engine (decision 33). The digest of a trajectory, the search for
joints that diverge, and the looks between two steps share what they read.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "calls.py"


@pytest.mark.one_of(3)
@pytest.mark.parametrize(
    ("engine", "calls", "changes", "world"), [("mujoco", 304, 178, 73), ("pybullet", 369, 206, 129)]
)
def test_a_step_with_an_image_takes_no_more_calls(engine: str, calls: int, changes: int, world: int) -> None:
    """In a process of its own: Python 3.11 may not come back from code that it has specialized before."""
    if engine == "pybullet":
        pytest.importorskip("pybullet")
    command = [sys.executable, str(BENCHMARK), "--json", "--world", engine]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    found = json.loads(done.stdout)[engine]
    most = {"calls": calls, "changes": changes, "world": world}
    assert all(found[name] <= most[name] for name in most), found
