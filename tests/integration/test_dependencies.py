"""Who may import whom, for people who only run pytest."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SIMULATORS = {"mujoco", "pybullet", "nest", "neuron", "brian2"}
BACKENDS = {"nrp_brain_event", "nrp_brain_spinnaker", "nrp_world_mujoco", "nrp_world_pybullet"}


def modules_after(statement: str) -> set[str]:
    """Return the top-level packages that a fresh interpreter has loaded after a statement."""
    code = f"{statement}\nimport sys\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "statement",
    [
        "import nrp_core.cle",
        "import nrp_core.dsl",
        "import nrp_core.experiment.running.run",
        "import nrp_core.cli",
    ],
)
def test_nothing_in_the_middle_loads_a_simulator_or_a_backend(statement: str) -> None:
    assert not modules_after(statement) & (SIMULATORS | BACKENDS)


def test_the_command_line_starts_without_heavy_packages() -> None:
    heavy = {"numpy", "numba", "pydantic", "pyNN", "cv2", "matplotlib", "rosbags", "mcap"}
    assert not modules_after("import nrp_core.cli") & heavy


@pytest.mark.parametrize("backend", sorted(BACKENDS))
def test_a_backend_is_cheap_to_import(backend: str) -> None:
    assert not modules_after(f"import {backend}") & (SIMULATORS | {"numba", "cv2", "pyNN"})


def test_the_contracts_on_imports_are_kept() -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
