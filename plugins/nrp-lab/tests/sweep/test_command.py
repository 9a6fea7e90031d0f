"""``nrp sweep`` on engines that simulate nothing: what it makes, keeps, resumes, shows and refuses."""

import csv
import json
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from nrp_lab.sweep.model import read_sweep
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.record import JOURNAL, Journal, Record, read_records
from nrp_lab.sweep.report import without_effect
from nrp_lab.sweep.table import SweepTable

import nrp_core
from nrp_core.cli import app

Sweep = Callable[..., Any]
FILE = """
experiment: drive_to_the_wall
vary:
  events.red.at: {from: 0.4 s, to: 0.8 s, steps: 3}
  seed: {from: 1, to: 4}
"""
RUNS, DONE = 12, 3
PATIENCE_S = 120.0


@pytest.fixture
def here(fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: it has an experiment and the file of a sweep."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(drive_to_the_wall, tmp_path / "drive_to_the_wall")
    Path("sweep.yaml").write_text(FILE)
    return tmp_path


@pytest.fixture
def sweep(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Sweep:
    """Return a function that runs ``nrp sweep`` in this process; it returns the code and both outputs."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: Any) -> tuple[int, str, str]:
        capsys.readouterr()
        code = app.run_app(["sweep", *map(str, arguments)])
        return (code, *capsys.readouterr())

    return run


def table(folder: str = "sweep.sweep") -> list[dict[str, str]]:
    """Return the rows of a table without the columns that differ from one execution to another."""
    with Path(folder, "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [
        {k: v for k, v in row.items() if k not in ("wall_time_s", "elapsed_s", "attempts")} for row in rows
    ]


@pytest.mark.heavy
def test_a_row_has_the_values_of_a_single_run(sweep: Sweep) -> None:
    code, out, err = sweep("sweep.yaml", "--workers", 2)
    assert code == 0, err
    assert "drive_to_the_wall: 12 runs; grid of events.red.at (3) x seed (4)" in err
    assert "expected time: at most about" in err
    assert "criteria" in out
    rows = table()
    assert [int(row["run"]) for row in rows] == list(range(RUNS))
    for row in rows[::5]:
        given = [f"events.red.at={row['events.red.at']}", f"seed={row['seed']}"]
        with nrp_core.Run(nrp_core.load_experiment("drive_to_the_wall", given)) as run:
            run.run()
            result = run.result()
        assert row["trajectory_digest"] == result.trajectory_digest
        assert row["passed"] == ("" if result.passed is None else str(result.passed))
        assert row["complete"] == str(result.complete)
        met = result.criteria["arrives"].passed
        assert row["criteria.arrives"] == ("" if met is None else str(float(met)))
        assert row["problems"].split() == list(dict.fromkeys(one.code.name for one in result.problems))


@pytest.mark.heavy
def test_the_same_table_comes_from_any_number_of_workers(sweep: Sweep) -> None:
    for workers in (1, 2):
        assert sweep("sweep.yaml", "--workers", workers, "--out", f"with_{workers}")[0] == 0
    assert table("with_1") == table("with_2")
    assert len({row["time_to_event.arrives"] for row in table("with_1")}) > 1


KILLED = f"""
import os, signal
from nrp_core.cli.app import run_app
from nrp_lab.sweep.record import Journal
add, added = Journal.add, []
def add_or_die(journal, record):
    add(journal, record)
    added.append(record)
    if len(added) == {DONE}:
        os.kill(os.getpid(), signal.SIGKILL)
Journal.add = add_or_die
run_app(["sweep", "sweep.yaml", "--workers", "1"])
"""


@pytest.mark.heavy
def test_it_is_resumed_after_a_kill_and_a_cut_line(sweep: Sweep, here: Path) -> None:
    journal = here / "sweep.sweep" / JOURNAL
    killed = subprocess.run([sys.executable, "-c", KILLED], capture_output=True, timeout=PATIENCE_S)
    assert killed.returncode == -signal.SIGKILL
    with journal.open("a") as file:
        file.write('{"id":"cut')
    code, _, err = sweep("sweep.yaml", "--workers", 1)
    assert code == 0, err
    assert f"12 runs, {RUNS - DONE} to do" in err
    ids = [json.loads(line)["id"] for line in journal.read_text().splitlines()]
    assert len(ids) == len(set(ids)) == RUNS
    assert len(table()) == RUNS
    assert sweep("sweep.yaml", "--out", "whole", "--workers", 1)[0] == 0
    assert table() == table("whole")


def test_a_sweep_can_be_extended_and_only_some_runs_made(sweep: Sweep, here: Path) -> None:
    assert sweep("sweep.yaml", "--only", "seed=2", "--workers", 1)[0] == 0
    assert [row["seed"] for row in table()] == ["2"] * 3
    Path("sweep.yaml").write_text(FILE.replace("to: 4", "to: 2"))
    code, _, err = sweep("sweep.yaml", "--only", "0..1", "--workers", 1)
    assert (code, "6 runs, 1 to do" in err) == (0, True)
    assert sorted(row["seed"] for row in table()) == ["1", "2", "2", "2"]


@pytest.mark.heavy
def test_failed_runs_are_kept_with_their_error_and_repeated_on_request(sweep: Sweep, here: Path) -> None:
    function = here / "drive_to_the_wall" / "wrong.py"
    body = (
        "from pathlib import Path\n"
        "@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))\n"
        "def wrong(t):\n    if t > 1.0 and Path({0!r}).exists():\n        raise ValueError('no way')\n"
    )
    broken = here / "broken"
    broken.touch()
    function.write_text(body.format(str(broken)))
    Path("sweep.yaml").write_text(FILE.replace("experiment: drive_to_the_wall", "experiment: study.yaml"))
    Path("study.yaml").write_text(
        "extends: drive_to_the_wall/experiment.yaml\ntransfer_functions: [drive_to_the_wall/wrong.py]\n"
    )
    code, out, err = sweep("sweep.yaml", "--workers", 1, "--only", "0..2")
    assert code == 1, err
    assert "3 failed: " in out
    assert all("no way" in row["error"] and row["state"] == "failed" for row in table())
    broken.unlink()
    assert sweep("sweep.yaml", "--workers", 1, "--only", "0..2")[0] == 1
    code, _, err = sweep("sweep.yaml", "--workers", 1, "--only", "0..2", "--retry-failed")
    assert code == 0, err
    assert {row["state"] for row in table()} == {"finished"}


@pytest.mark.heavy
def test_a_full_disk_ends_it_with_one_sentence_and_keeps_what_is_done(sweep: Sweep) -> None:
    assert sweep("sweep.yaml", "--only", "0..3", "--workers", 1)[0] == 0
    journal = Path("sweep.sweep", JOURNAL)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (journal.stat().st_size + 100, hard))
    try:
        code, _, err = sweep("sweep.yaml", "--workers", 1)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert code != 0
    assert "error: " in err
    assert "cannot be written: File too large" in err
    assert len(read_records(Path("sweep.sweep"))) == 4
    assert sweep("sweep.yaml", "--workers", 1)[0] == 0
    assert len(table()) == RUNS


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("text", "arguments", "code", "message"),
    [
        (FILE.replace("red.at", "rad.at"), [], 3, "sweep.yaml:4:18: there is no 'rad' to vary"),
        (FILE.replace("seed", "seeed"), [], 3, "an experiment has no key 'seeed'; did you mean 'seed'?"),
        (
            FILE + "measure: [criterea]\n",
            [],
            3,
            "sweep.yaml:6:10: there is no metric 'criterea'; did you mean",
        ),
        (FILE + "measure: [trajectory]\n", [], 3, "'trajectory' compares two runs"),
        (FILE.replace("to: 4", "to: 1000000000"), [], 3, "the sweep has 3,000,000,000 runs"),
        (
            FILE.replace("  seed:", "  brain.backend: [event, evnt]\n  seed:"),
            [],
            4,
            "sweep.yaml:5:18: no brain backend is called 'evnt'; did you mean 'event'?",
        ),
        (FILE, ["--only", "seed=9"], 3, "--only seed=9: no run has this value"),
        (FILE + "objective: {a.b: 1}\n", [], 3, "this file has an objective: use nrp evolve"),
        ("name: a\nbrain: {}\n", [], 3, "this file is an experiment; a sweep names one under 'experiment'"),
        (FILE, ["--only", "sed=1"], 3, "'sed' does not vary; did you mean 'seed'?"),
        (FILE, ["--on", "dusk"], 3, "there is no executor 'dusk'; did you mean 'dask'?"),
        (FILE, ["--out", "drive_to_the_wall"], 3, "drive_to_the_wall: the folder contains other files"),
        (FILE.replace("drive_to", "drive_too"), [], 3, "there is no experiment or file 'drive_too_the_wall'"),
    ],
)
def test_bad_input_gets_one_error(
    sweep: Sweep, text: str, arguments: list[str], code: int, message: str
) -> None:
    Path("sweep.yaml").write_text(text)
    found, _, err = sweep("sweep.yaml", *arguments)
    assert found == code
    assert err.count("error: ") == 1
    assert message in err


def test_a_folder_of_another_sweep_and_one_in_use_are_refused(sweep: Sweep) -> None:
    assert sweep("sweep.yaml", "--only", "0", "--workers", 1)[0] == 0
    Path("sweep.yaml").write_text(FILE + "until: 1 s\n")
    _, _, err = sweep("sweep.yaml")
    assert "the folder contains another sweep, with different end time" in err
    Path("sweep.yaml").write_text(FILE)
    with Journal(Path("sweep.sweep", JOURNAL)):
        _, _, err = sweep("sweep.yaml", "--workers", 1)
    assert "another process is working on this sweep" in err


def test_the_results_are_shown_as_text_data_and_figures(sweep: Sweep, here: Path) -> None:
    Path("sweep.yaml").write_text(
        FILE.replace("vary:", "vary:\n  timestep: [20 ms, 40 ms]").replace("to: 4", "to: 2")
    )
    assert sweep("sweep.yaml", "--workers", 1)[0] == 0
    code, out, _ = sweep("show", "sweep.sweep", "--json")
    data = json.loads(out)
    assert code == 0
    assert (data["runs"], data["failed"], data["keys"]) == (12, 0, ["timestep", "events.red.at"])
    assert len(data["groups"]) == 6
    rows = [row for row in table() if (row["timestep"], row["events.red.at"]) == ("20 ms", "0.4 s")]
    group = next(g for g in data["groups"] if g["values"] == {"timestep": "20 ms", "events.red.at": "0.4 s"})
    values = [float(row["time_to_event.arrives"]) for row in rows]
    assert group["measured"]["time_to_event.arrives"]["mean"] == pytest.approx(sum(values) / len(values))
    for kind in ("curve", "heat", "parallel"):
        code, _, err = sweep("show", "sweep.sweep", "--plot", f"{kind}.png", "--kind", kind)
        assert code == 0, err
        assert Path(f"{kind}.png").stat().st_size > 5000
    _, _, err = sweep("show", "sweep.sweep", "--plot", "a.png", "--measure", "criteria.arives")
    assert "'criteria.arives' was not measured; did you mean 'criteria.arrives'?" in err
    _, _, err = sweep("show", here)
    assert "the folder does not contain a sweep" in err
    for option in (["--workers", 2], ["--only", 0], ["--plan"], ["--emit", "slurm"], ["--out", "x"]):
        code, _, err = sweep("show", "sweep.sweep", *option)
        assert code == 2
        assert f"{option[0]}: it has no effect with 'show', which makes no run" in " ".join(err.split())
    assert "have no effect without --plot" in sweep("show", "sweep.sweep", "--kind", "heat")[2]
    assert "nrp sweep show DIR" in " ".join(sweep("show")[2].split())
    assert "only 'show' takes a folder" in " ".join(sweep("sweep.yaml", "sweep.sweep")[2].split())


@pytest.mark.one_of(2)
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--kind", "heat"], "a heat map needs 2 varying settings besides the seed; this sweep has 1"),
        (["--kind", "heet"], "there is no figure 'heet'; did you mean 'heat'?"),
        (["--measure", "criteria.arives"], "is not measured; did you mean 'criteria.arrives'?"),
        (["--measure", "distance.car"], "'distance.car' is not measured"),
    ],
)
def test_a_figure_that_the_runs_will_not_give_is_refused_before_them(
    sweep: Sweep, arguments: list[str], message: str
) -> None:
    code, _, err = sweep("sweep.yaml", "--workers", 1, "--plot", "a.png", *arguments)
    assert code == 3
    assert message in err
    assert not Path("sweep.sweep", "results.csv").exists()


@pytest.mark.parametrize(
    ("digests", "measured", "told"),
    [
        ("aabb", "1122", ["'scale' changed nothing: all its values gave the same trajectories and measures"]),
        ("aabc", "1122", []),  # it matters with one seed
        ("aabb", "1123", []),  # the same path, other spikes
    ],
)
def test_a_setting_without_effect_is_reported(digests: str, measured: str, told: list[str]) -> None:
    rows = tuple(
        {"scale": scale, "seed": seed, "trajectory_digest": path, "rate.all": rate, "error": None}
        for (seed, scale), path, rate in zip(((1, 2), (1, 4), (2, 2), (2, 4)), digests, measured, strict=True)
    )
    assert list(without_effect(SweepTable("name", ("scale",), ("rate.all",), rows))) == told
    alone = SweepTable("name", ("scale",), ("rate.all",), rows[::2])  # only one of its values has run
    assert list(without_effect(alone)) == []


@pytest.mark.parametrize(
    ("digests", "told"),
    [
        ("aab", []),
        ("aaa", ["'seed' changed nothing: all its values gave the same trajectories and measures"]),
    ],
)
def test_seeds_without_effect_are_reported(digests: str, told: list[str]) -> None:
    rows = tuple(
        {"seed": seed, "trajectory_digest": path, "error": None} for seed, path in enumerate(digests)
    )
    assert list(without_effect(SweepTable("name", (), (), rows))) == told


def test_a_plan_is_not_asked_for_with_jobs_that_are_only_written(sweep: Sweep) -> None:
    code, _, err = sweep("sweep.yaml", "--plan", "--emit", "slurm")
    assert code == 2
    assert "it has no effect with --emit, which makes no run" in " ".join(err.split())
    code, _, err = sweep("sweep.yaml", "--emit", "slurm", "--on", "dask")
    assert code == 2
    assert "it has no effect with --emit slurm, which makes no run" in " ".join(err.split())


@pytest.mark.heavy
def test_emitted_jobs_are_collected_by_the_same_command(sweep: Sweep) -> None:
    code, out, _ = sweep("sweep.yaml", "--emit", "snakemake", "--workers", 2)
    assert code == 0
    assert "12 runs written to sweep.sweep/Snakefile" in out
    assert "--snakefile sweep.sweep/Snakefile --directory sweep.sweep" in out
    rules = Path("sweep.sweep/Snakefile").read_text()
    shell = rules.split('shell: "')[1].split('"')[0]
    for job in range(2):
        command = shell.format(input=f"jobs/{job}.jsonl", wildcards=SimpleNamespace(job=job))
        done = subprocess.run(command, shell=True, cwd="sweep.sweep", check=False, capture_output=True)
        assert done.returncode == 0, done.stderr
    code, _, err = sweep("sweep.yaml", "--workers", 1)
    assert (code, "12 runs, 0 to do" in err) == (0, True)
    assert sweep("sweep.yaml", "--out", "whole", "--workers", 1)[0] == 0
    assert table() == table("whole")
    code, _, err = sweep("sweep.yaml", "--emit", "slum")
    assert "did you mean 'slurm'?" in err


@pytest.mark.heavy
def test_resuming_ten_thousand_rows_does_nothing_again(sweep: Sweep) -> None:
    Path("sweep.yaml").write_text(FILE.replace("to: 4", "to: 3333"))
    plan = Plan.of(*read_sweep(Path("sweep.yaml")))
    sweep("sweep.yaml", "--only", "0", "--workers", 1)
    (first,) = read_records(Path("sweep.sweep")).values()
    lines = [
        Record(run.task.id, run.task.index, state="finished", depends_on=first.depends_on).to_line()
        for run in plan.runs
    ]
    Path("sweep.sweep", JOURNAL).write_text("".join(lines))
    code, _, err = sweep("sweep.yaml", "--workers", 1)
    assert (code, "9999 runs, 0 to do" in err) == (0, True)
