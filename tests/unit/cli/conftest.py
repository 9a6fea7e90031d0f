"""The command line, in this process or in one of its own, with engines that simulate nothing."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from nrp_core.cli import app

FAST = """
from dataclasses import replace

from experiment_fakes import DiscBackend, DiscEngine
from nrp_lab.comparison.metrics.base import ScalarMetric


class FastEngine(DiscEngine):
    def _do_set_drive(self, model, drive, velocity):
        super()._do_set_drive(model, drive, replace(velocity, forward=1.5 * velocity.forward))


class FastBackend(DiscBackend):
    def engine(self, scene, *, seed, options):
        return FastEngine(scene, self.capabilities(options), seed=seed, identity="fast")


class TwinBackend(DiscBackend):
    pass


class Steps(ScalarMetric):
    name, title = "steps", "Steps"

    def values(self, run):
        return {"all": float(run.result["steps"])}
"""
ENTRIES = (
    "[nrp_core.world]\nfast = fast:FastBackend\ntwin = fast:TwinBackend\n"
    "[nrp_core.metrics]\nsteps = fast:Steps\n"
)


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    code: int
    out: str
    err: str


@pytest.fixture
def experiment(fakes: None, drive_to_the_wall: Path) -> Path:
    """A folder with an experiment that passes, and the engines for it."""
    return drive_to_the_wall


@pytest.fixture
def worlds(experiment: Path, install: Callable[..., None]) -> Path:
    """The experiment, a world like its own, one that drives faster, and a metric of somebody else."""
    install("fast", ENTRIES, FAST)
    return experiment


@pytest.fixture
def nrp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Done]:
    """Return a function that runs a command in this process."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: Any) -> Done:
        capsys.readouterr()
        code = app.run_app([str(argument) for argument in arguments])
        return Done(code, *capsys.readouterr())

    return run


@pytest.fixture
def nrp_process() -> Callable[..., Done]:
    """Return a function that runs a command in a process of its own."""

    def run(*arguments: Any) -> Done:
        command = [sys.executable, "-m", "nrp_core", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        return Done(done.returncode, done.stdout, done.stderr)

    return run
