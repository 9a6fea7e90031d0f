"""Real Gazebos for the tests, and their processes."""

import os
import tempfile
import time
from pathlib import Path
from shutil import rmtree, which

import pytest


@pytest.fixture(scope="session")
def gazebo():
    """Gazebo, which few systems have; ``scripts/gazebo test`` runs the tests that need it."""
    if not (os.environ.get("NRP_GAZEBO_ROOT") or which("gzserver")):
        pytest.skip("there is no Gazebo here")


@pytest.fixture
def temporary(monkeypatch):
    """The folder for temporary files of this test, with a short name."""
    folder = Path(tempfile.mkdtemp(prefix="gz", dir="/tmp"))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield folder
    rmtree(folder)


@pytest.fixture
def servers(temporary):
    """Return the processes of Gazebos that this test has started."""

    def found() -> list[int]:
        numbers = []
        for process in Path("/proc").glob("[0-9]*"):
            try:
                words = (process / "cmdline").read_bytes().split(b"\0")
            except OSError:  # it has just ended
                continue
            if words[0].endswith(b"gzserver") and any(word.startswith(bytes(temporary)) for word in words):
                numbers.append(int(process.name))
        return numbers

    return found


@pytest.fixture
def until():
    """Wait for a condition; return whether it came true."""

    def waited(condition, within_s: float = 20.0) -> bool:
        end = time.monotonic() + within_s
        while not condition():
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True

    return waited
