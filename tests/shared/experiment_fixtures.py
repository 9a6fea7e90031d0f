"""Fixtures for tests: packages installed for one test, and an experiment on two engines without a simulator.

A ``conftest.py`` imports them.
"""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

FAKES = Path(__file__).parent / "fakes"

Install = Callable[..., None]


@pytest.fixture
def site(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for packages that this process and its children import; what they find out is kept apart."""
    folder = tmp_path_factory.mktemp("site")
    for path in (FAKES, folder):
        monkeypatch.syspath_prepend(path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(str, (folder, FAKES))))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
    return folder


@pytest.fixture
def install(site: Path) -> Install:
    """Return a function that installs a package: its entry points, and the source of its one module."""

    def installed(name: str, entry_points: str, source: str | None = None, version: str = "1.0") -> None:
        info = site / f"{name}-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
        (info / "entry_points.txt").write_text(entry_points)
        if source is not None:
            (site / f"{name}.py").write_text(source)

    return installed


@pytest.fixture
def fakes(install: Install) -> None:
    """Install the brain ``counting``, the world ``disc`` and a brain ``broken`` that does not import."""
    install(
        "fakes",
        "[nrp_core.brain]\ncounting = experiment_fakes:CountingBackend\nbroken = no_such_module:Backend\n"
        "[nrp_core.world]\ndisc = experiment_fakes:DiscBackend\n",
    )


@pytest.fixture(scope="session")
def _place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One folder for all tests, and beside it what is found out of its brain once."""
    return tmp_path_factory.mktemp("experiments") / "drive_to_the_wall"


@pytest.fixture
def drive_to_the_wall(_place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a whole experiment: a robot drives to a wall that turns red."""
    shutil.rmtree(_place, ignore_errors=True)
    shutil.copytree(FAKES, _place, ignore=shutil.ignore_patterns("__pycache__", "experiment_fakes.py"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(_place.parent / "cache"))
    return _place


@pytest.fixture
def raising(drive_to_the_wall: Path) -> Callable[[str], str]:
    """Return a function that writes a transfer function which goes wrong after a second.

    It takes what the function does then, and returns the override that uses it.
    """

    def written(body: str) -> str:
        path = drive_to_the_wall / "wrong.py"
        path.write_text(
            "@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))\n"
            f"def wrong(t):\n    if t > 1.0:\n        {body}\n"
        )
        return f"transfer_functions=[{path}]"

    return written
