"""What a check doubts is told before anything costly, once in a process, by all that opens experiments."""

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from nrp_lab.benchmark.ladder import Ladder
from nrp_lab.benchmark.tasks import BenchmarkTask
from nrp_lab.evolve import evolve
from nrp_lab.sweep import sweep

import nrp_core
from nrp_core.checks.warnings import announcement, experiment_warnings
from nrp_core.cli import app
from nrp_core.findings import Code

TOO = """

@nrp.Neuron2Robot(nrp.Topic("/husky/cmd_vel", geometry_msgs.msg.Twist))
def drive_too(t):
    return geometry_msgs.msg.Twist()
"""
MARK = """
try:
    with open({!r}, 'a') as file:
        file.write('x')
except PermissionError:  # in a check
    pass
"""
DOUBT = f"[{Code.NRP229.name}]"
"""Two functions command one drive."""
VARY = "vary: {seed: {from: 1, to: 2}, events.red.at: {from: 100 ms, to: 1000 ms, steps: 2}}"
SEARCH = (
    VARY.replace(", steps: 2", "") + "\nobjective: {criterion_distance.stays_near: 1}\n"
    "population: 3\ngenerations: 1\n"
)


@pytest.fixture
def doubtful(fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An experiment in which two functions command one drive, in the current folder."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(drive_to_the_wall, "doubtful")
    with Path("doubtful/drive.py").open("a") as file:
        file.write(TOO)
    with Path("doubtful/brain.py").open("a") as file:
        file.write(MARK.format(str(tmp_path / "executed")))
    experiment = Path("doubtful/experiment.yaml")
    experiment.write_text(experiment.read_text().replace("drive_to_the_wall", f"of {tmp_path.name}"))
    return Path("doubtful")


@pytest.fixture
def nrp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that runs a command in this process, which returns what it says."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: Any) -> str:
        capsys.readouterr()
        assert app.run_app([str(argument) for argument in arguments]) == 0
        return capsys.readouterr().err

    return run


@pytest.mark.one_of(3)
@pytest.mark.parametrize(("command", "file"), [("sweep", VARY), ("evolve", SEARCH)])
def test_a_command_of_many_runs_prints_a_warning_once_before_the_first(
    doubtful: Path, nrp: Callable[..., str], command: str, file: str
) -> None:
    Path("many.yaml").write_text(f"experiment: doubtful\n{file}")
    said = nrp(command, "many.yaml", "--workers", 1)
    assert said.count(DOUBT) == 1
    assert said.index(DOUBT) < said.index("runs: ")


def test_a_sweep_and_a_search_in_python_warn_once_in_a_process(doubtful: Path, tmp_path: Path) -> None:
    Path("many.yaml").write_text(f"experiment: doubtful\n{VARY}")
    Path("search.yaml").write_text(f"experiment: doubtful\n{SEARCH}")
    with pytest.warns(UserWarning, match="nrp validate warns") as told:
        sweep("many.yaml", workers=1)
    assert [str(one.message).count(DOUBT) for one in told] == [1]
    assert told[0].filename == __file__
    evolve("search.yaml", tmp_path / "found", workers=1)


def test_a_benchmark_reports_the_warnings_of_its_tasks_once(doubtful: Path, tmp_path: Path) -> None:
    ladder = Ladder([BenchmarkTask("own", "doubtful", "", ())], ["counting"], ["disc"], 1, tmp_path / "out")
    told: list[str] = []
    ladder.report_warnings(told.append)
    ladder.report_warnings(told.append)
    assert [text.count(DOUBT) for text in told] == [1]


def test_a_run_opened_from_a_file_has_its_warnings_and_executes_the_file_once(
    doubtful: Path, tmp_path: Path
) -> None:
    with nrp_core.open_run(doubtful, (text for text in ["seed=3"])) as run:
        assert Code.NRP229 in {one.code for one in run.problems}
        assert run.seed == 3
    assert (tmp_path / "executed").read_text() == "x"
    with nrp_core.Run(nrp_core.load_experiment(doubtful)) as run:
        assert Code.NRP229 not in {one.code for one in run.problems}


def test_a_correct_experiment_causes_no_warning_at_its_start() -> None:
    assert (
        announcement("sound", experiment_warnings(partial(nrp_core.load_experiment, "braitenberg_husky")))
        == ""
    )
