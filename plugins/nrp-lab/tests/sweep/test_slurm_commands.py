"""What goes wrong with SLURM, by commands of its names; the jobs that they start are real ones."""

import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.cli import app

Sweep = Callable[..., tuple[int, str]]
AT_ONCE = """
for script; do true; done
first=$(sed -n 's/^#SBATCH --array=\\([0-9]*\\)-.*/\\1/p' "$script")
SLURM_ARRAY_TASK_ID=$first PYTHONPATH="$OTHER$PYTHONPATH" \\
    sh "$script" > "$(dirname "$script")/$first.log" 2>&1
echo 7
"""


@pytest.fixture
def sweep(
    fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Sweep:  # fmt: skip
    """Return a function that makes the runs of a sweep on SLURM, given the texts of its commands."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(settings: str = "", **commands: str) -> tuple[int, str]:
        Path("sweep.yaml").write_text(
            f"experiment: {drive_to_the_wall}\nvary: {{seed: [1]}}\nsettings: {{{settings}}}\n"
        )
        for name in ("sh", "sed", "dirname"):
            _command(tmp_path / "bin" / name, f'exec {shutil.which(name, path=os.defpath)} "$@"')
        for name, text in commands.items():
            _command(tmp_path / "bin" / name, text)
        monkeypatch.setenv("PATH", str(tmp_path / "bin"))
        capsys.readouterr()
        code = app.run_app(["sweep", "sweep.yaml", "--on", "slurm", "--workers", "1"])
        return code, capsys.readouterr().err

    return run


def _command(path: Path, text: str) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


def test_a_machine_without_slurm_is_named(sweep: Sweep) -> None:
    code, err = sweep()
    assert (code, err.count("error: ")) == (4, 1)
    assert "sbatch was not found: the executor 'slurm' needs SLURM's commands" in err


def test_a_controller_that_does_not_answer_is_quoted(sweep: Sweep) -> None:
    message = "slurm_load_jobs error: Unable to contact slurm controller (connect failure)"
    code, err = sweep(sbatch="exit 1", squeue=f"echo '{message}' >&2; exit 1")
    assert code == 4
    assert f"squeue of SLURM failed: {message}" in err


@pytest.mark.one_of(3)
@pytest.mark.parametrize("is_other", [False, True])
def test_jobs_of_another_version_end_it_at_the_first_attempt(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_other: bool
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (fakes,) = [path for path in map(Path, sys.path) if (path / "experiment_fakes.py").is_file()]
    source = (fakes / "experiment_fakes.py").read_text()
    (other / "experiment_fakes.py").write_text(source + "\n# changed\n" * is_other)
    monkeypatch.setenv("OTHER", f"{other}:")
    code, err = sweep(sbatch=AT_ONCE, squeue="true")
    assert code == (4 if is_other else 0)
    assert ("has a different version of 'experiment_fakes' from the process that began" in err) is is_other
    assert len([*Path("sweep.sweep", "jobs").glob("*.log")]) == 1


def test_jobs_that_never_begin_end_the_sweep_but_no_run_fails(sweep: Sweep) -> None:
    code, err = sweep(sbatch="echo 7", squeue="true")
    assert (code, err.count("error: ")) == (4, 1)
    assert "workers die before a run begins (see " in err
    assert not Path("sweep.sweep", "journal.jsonl").read_text()


@pytest.mark.heavy
def test_a_run_that_ends_its_job_each_time_is_given_up(sweep: Sweep, raising: Callable[[str], str]) -> None:
    override = raising("__import__('os').kill(__import__('os').getpid(), 9)")
    code, _ = sweep(settings=override.replace("=", ": "), sbatch=AT_ONCE, squeue="true")
    assert code == 1
    assert "its worker died in each of 5 attempts" in Path("sweep.sweep", "journal.jsonl").read_text()
