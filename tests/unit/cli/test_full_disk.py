"""A disk that takes no more: one sentence that names the file, and nothing half made in its place."""

import errno
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core._support.files import writing
from nrp_core.errors import ExperimentError
from nrp_core.recording.layout import MCAP_NAME
from nrp_core.recording.recording import Recording
from nrp_core.recording.writing.writer import McapFile

Nrp = Callable[..., Any]
FULL = "cannot be written: File too large"


@contextmanager
def room(size: int) -> Iterator[None]:
    """Let no file become larger."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def recorded(nrp: Nrp, experiment: Path, tmp_path: Path) -> Path:
    assert nrp("run", experiment, "--until", "1s", "--record", tmp_path / "recorded").code == 0
    return tmp_path / "recorded"


def test_the_reason_is_the_systems_also_from_libraries_that_bury_it(tmp_path: Path, golden: Golden) -> None:
    buried = OSError(errno.ENOSPC, "Unable to create file (file write failed: time = Fri, errno = 28, ...)")
    for error in (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), buried):
        with golden.raises(ExperimentError):  # noqa: SIM117
            with writing(tmp_path / "out"):
                raise error
    with golden.raises(ExperimentError), writing(tmp_path / "out"):
        raise OSError("odd")


@pytest.mark.one_of(3)
@pytest.mark.parametrize("kind", ["csv", "nwb", "sonata"])
def test_an_export_ends_with_its_name_and_leaves_nothing(
    nrp_process: Nrp, recorded: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    before = set(tmp_path.iterdir())
    with room(100):
        done = nrp_process("export", recorded, "-f", kind)  # to its very end, where HDF5 likes to crash
    assert (done.code, done.out) == (3, "")
    assert done.err.endswith(f"{FULL}\n")
    assert len(done.err.splitlines()) == 1
    assert set(tmp_path.iterdir()) == before


def test_a_plot_ends_with_its_name(nrp: Nrp, recorded: Path, tmp_path: Path) -> None:
    with room(100):
        done = nrp("plot", recorded, "-o", tmp_path / "a.png")
    assert (done.code, done.err) == (3, f"error: {tmp_path / 'a.png'}: {FULL}\n")


def test_a_network_file_ends_with_its_name_and_leaves_nothing(tmp_path: Path) -> None:
    script = f"""
from pathlib import Path
from nrp_core.network.files.network_file import save_network
from nrp_core.network.data import Network
from nrp_core.errors import NetworkError
try:
    save_network(Network({{}}, ()), Path({str(tmp_path / "a.nrpnet")!r}))
except NetworkError as error:
    print(error)
"""
    with room(100):
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("File too large\n")
    assert list(tmp_path.iterdir()) == []


def test_a_recovery_leaves_what_was_there_and_nothing_else(nrp: Nrp, recorded: Path) -> None:
    file = recorded / MCAP_NAME
    file.write_bytes(file.read_bytes()[:-1])
    before = {path.name: path.stat().st_size for path in recorded.iterdir()}
    with room(2000):
        done = nrp("recover", recorded)
    assert done.code == 3
    assert done.err.endswith(f"{FULL}\n")
    assert {path.name: path.stat().st_size for path in recorded.iterdir()} == before


def test_a_new_distribution_is_named(nrp: Nrp, tmp_path: Path) -> None:
    with room(100):
        done = nrp("new", "brain", "acme", "-o", tmp_path / "acme")
    assert (done.code, done.err) == (3, f"error: {tmp_path / 'acme'}: {FULL}\n")


def test_a_replay_that_cannot_be_recorded_fails_and_does_not_become_another_run(
    nrp: Nrp, recorded: Path, tmp_path: Path
) -> None:
    with room(20_000):
        done = nrp("replay", recorded, "--record", tmp_path / "again")
    assert done.code == 1
    assert "error: the recording cannot be " in done.err
    assert done.err.endswith("File too large\n")


def test_a_run_whose_end_cannot_be_recorded_has_no_whole_recording(
    nrp: Nrp, experiment: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(McapFile, "is_due", lambda *_: False)  # all is written when the file is closed
    with room(20_000):
        done = nrp("run", experiment, "--record", tmp_path / "cut")
    assert done.code == 1
    assert "error: the recording cannot be " in done.err
    assert "passed" not in done.out
    assert done.out.splitlines()[-1].startswith("failed at ")
    assert Recording(tmp_path / "cut").run["state"] == "interrupted"


def test_a_run_of_a_grid_that_cannot_be_recorded_is_run_again_when_there_is_room(
    nrp: Nrp, experiment: Path, tmp_path: Path, install: Callable[..., None]
) -> None:
    install(
        "twins",
        "[nrp_core.world]\ntwin = twins:TwinBackend\n",
        "from experiment_fakes import DiscBackend\n\n\nclass TwinBackend(DiscBackend):\n    pass\n",
    )
    asked = (
        "diff",
        experiment,
        "--worlds",
        "disc,twin",
        "--seeds",
        1,
        "--jobs",
        1,
        "--results",
        tmp_path / "r",
    )
    with room(20_000):
        full = nrp(*asked)
    assert full.code == 1
    assert "the recording cannot be " in full.err
    again = nrp(*asked)
    assert "failed" not in again.out
    assert "the same to the last bit in 151 steps" in again.out
