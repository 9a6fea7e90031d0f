"""Experiments to be broken: copies of those that ship, with engines that are never started."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import nrp_experiments.bodies
import nrp_experiments.braitenberg_husky
import nrp_experiments.slalom_pioneer
import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

SHIPPED = Path(nrp_experiments.braitenberg_husky.__path__[0])
SLALOM = Path(nrp_experiments.slalom_pioneer.__path__[0])
BODIES = Path(nrp_experiments.bodies.__path__[0])

Broken = Callable[..., list[Finding]]


@pytest.fixture(scope="session")
def _cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def _own_cache(_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep what is found out of networks apart from the user's cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(_cache))


@pytest.fixture(scope="session")
def _place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all tests: its brain is looked at once."""
    return tmp_path_factory.mktemp("experiments") / "husky"


@pytest.fixture
def husky(_place: Path) -> Path:
    """A folder with the experiment that ships, and all its variants."""
    shutil.rmtree(_place, ignore_errors=True)
    shutil.copytree(SHIPPED, _place, ignore=shutil.ignore_patterns("__pycache__"))
    return _place


FLOOR = """\
<sdf version="1.6"><world name="floor"><model name="ground"><static>true</static><link name="link">
  <collision name="all"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>
</link></model></world></sdf>
"""
FUNCTIONS = """\
name: functions
duration: 40 s
brain: {backend: event, model: brain.py, populations: {sensors: "0:5", actors: "6:8"}}
world:
  backend: mujoco
  scene: floor.sdf
  robots: {husky: {model: husky.sdf, pose: [0, 0, 0.2, 0, 0, 0]}}
transfer_functions: [listing1.py, listing2.py]
"""


@pytest.fixture
def functions(husky: Path) -> Path:
    """The file of an experiment with the brain and the robot of ``husky``, for checks of functions alone."""
    (husky / "floor.sdf").write_text(FLOOR)
    path = husky / "functions.yaml"
    path.write_text(FUNCTIONS)
    return path


@pytest.fixture
def broken(husky: Path) -> Broken:
    """Return a function that replaces a text in a file, and gives the errors and warnings of what is left.

    ``experiment`` names the variant that is checked.
    """

    def changed(file: str, *replacements: str, experiment: str = "experiment.yaml") -> list[Finding]:
        path = husky / file
        text = path.read_text("utf-8")
        for old, new in zip(replacements[::2], replacements[1::2], strict=True):
            assert old in text, f"{old!r} is not in {file}"
            text = text.replace(old, new, 1)
        path.write_text(text, "utf-8")
        found = validate_file(husky / experiment)
        return [finding for finding in found if finding.level is not Level.NOTE]

    return changed


@pytest.fixture
def slalom(tmp_path: Path) -> Broken:
    """Return a function that replaces a text in a file of a scanner's experiment and returns the findings."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(SLALOM, tmp_path / "slalom_pioneer", ignore=ignored)
    shutil.copytree(BODIES, tmp_path / "bodies", ignore=ignored)

    def changed(file: str, old: str, new: str) -> list[Finding]:
        path = tmp_path / file
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        return validate_file(tmp_path / "slalom_pioneer/experiment.yaml")

    return changed
