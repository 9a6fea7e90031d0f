"""What is shipped works where nothing of the repository is: wheels, in an empty environment, elsewhere.

The environment borrows the dependencies from the one that runs the tests, so that no network is needed.
"""

import json
import os
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.registry import OPTIONAL

ROOT = Path(__file__).parents[2]
PLUGINS = ["nrp-brain-minimal", "nrp-world-minimal", *OPTIONAL]
OFFLINE = ["--no-deps", "--no-index", "--disable-pip-version-check", "--quiet"]

Run = Callable[..., subprocess.CompletedProcess[str]]

pytestmark = pytest.mark.slow


def pip(*arguments: object) -> None:
    command = [sys.executable, "-m", "pip", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def wheels_of(folder: Path, *sources: Path) -> list[Path]:
    pip("wheel", *OFFLINE, "--no-build-isolation", "--wheel-dir", folder, *sources)
    return sorted(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheels of the core and of some plugins."""
    folder = tmp_path_factory.mktemp("elsewhere")
    venv.create(folder, with_pip=False, symlinks=True)
    wheels = wheels_of(tmp_path_factory.mktemp("wheels"), ROOT, *(ROOT / "plugins" / p for p in PLUGINS))
    assert len(wheels) == 1 + len(PLUGINS)
    install(folder, *wheels)
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "borrowed.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    return folder


def install(environment: Path, *wheels: Path) -> None:
    pip("--python", environment / "bin" / "python", "install", *OFFLINE, *wheels)


@pytest.fixture
def run(elsewhere: Path, tmp_path: Path) -> Run:
    """Return a function that runs a program of that environment, away from the repository."""
    clean = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "NRP_"))}

    def ran(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [str(elsewhere / "bin" / program), *arguments]
        return subprocess.run(
            command, cwd=tmp_path, env=clean, capture_output=True, text=True, check=False, timeout=300
        )

    return ran


@pytest.mark.heavy
def test_nothing_comes_from_the_repository(run: Run, elsewhere: Path) -> None:
    names = (
        "nrp_core", "nrp_brain_minimal", "nrp_world_minimal", "nrp_experiments", "nrp_brain_event",
        "hbp_nrp_virtual_coach", "nrp_spynnaker",
    )  # fmt: skip
    script = f"import {', '.join(names)}; print(*({'.__file__, '.join(names)}.__file__), sep='\\n')"
    done = run("python", "-c", script)
    assert done.returncode == 0, done.stderr
    assert all(Path(line).is_relative_to(elsewhere) for line in done.stdout.splitlines())


@pytest.mark.heavy
def test_the_main_experiment_passes_on_the_pair_of_minimal_backends(run: Run) -> None:
    pair = "--brain", "minimal", "--world", "minimal"
    early = "-s", "events.left_red.at=1 s", "-s", "duration=12 s"
    done = run("nrp", "run", "braitenberg_husky", *pair, *early, "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert (result["brain"], result["world"], result["passed"]) == ("minimal", "minimal", True)
    assert list(result["events"]) == ["left_red", "right_red", "all_blue"]


@pytest.mark.heavy
def test_the_brain_conforms(run: Run) -> None:
    """The kit for worlds runs in such an environment below; the plugin's own tests are those of the kit."""
    done = run("nrp", "conformance", "brain", "minimal", "--level", "contract", "--json")
    assert done.returncode == 0, done.stdout[-2000:]
    counts = json.loads(done.stdout)["counts"]
    assert counts["passed"] > 20
    assert set(counts) <= {"passed", "skipped"}


@pytest.mark.heavy
def test_a_package_from_nrp_new_installs_and_is_found(run: Run, elsewhere: Path, tmp_path: Path) -> None:
    for subject in ("brain", "world", "experiment"):
        assert run("nrp", "new", subject, "acme").returncode == 0
    install(elsewhere, *wheels_of(tmp_path / "wheels", *sorted(tmp_path.glob("nrp-*-acme"))))
    script = """if True:
        from nrp_core.brain.backends import brains
        from nrp_core.world.backends import worlds
        print(brains().provider('acme'), worlds().provider('acme'))"""
    found = run("python", "-c", script).stdout
    assert found.split()[::3] == ["nrp-brain-acme", "nrp-world-acme"]
    done = run("nrp", "run", "acme", "--until", "1s")
    assert done.returncode == 0, done.stderr
    failing = run("nrp", "conformance", "world", "acme", "--level", "contract")
    assert failing.returncode == 1
    assert "failed with the same error: NotImplementedError: _build: create" in failing.stdout
