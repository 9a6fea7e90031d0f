"""``nrp benchmark`` on engines that simulate nothing; somebody else's world takes part by its name."""

import csv
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_lab.benchmark import ladder
from nrp_lab.benchmark.ladder import wilson_interval
from nrp_lab.benchmark.tasks import TASKS, BenchmarkTask
from nrp_lab.commands.benchmark import named_or_all
from nrp_lab.comparison.grid import GridCell
from nrp_lab.sweep.table import Row
from scipy.stats import binomtest

from nrp_core.brain.backends import brains
from nrp_core.experiment.reading.find import load_experiment

DRIVE = BenchmarkTask("drive", "", "drive to the wall", ("arrives",), ("stays_near",))
SEEDS = 4


def row(error: str | None = None, **degrees: float | None) -> Row:
    return {"error": error, **{f"degree.{name}": degree for name, degree in degrees.items()}}


@pytest.fixture
def bench(nrp: Any, worlds: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Return a function that runs the benchmark with one task, driving to the wall, in one process."""
    monkeypatch.setitem(TASKS, "drive", BenchmarkTask("drive", str(worlds), *_rest(DRIVE)))

    def run(*options: Any) -> Any:
        where = ("--brains", "counting", "--out", tmp_path / "out", "--workers", 1)
        return nrp("benchmark", "drive", *where, *options)

    return run


def _rest(task: BenchmarkTask) -> tuple[Any, ...]:
    return task.asks, task.goals, task.conditions


@given(st.floats(0, 1), st.floats(0, 1))
def test_the_score_is_the_goal_as_far_as_the_condition_held(goal: float, condition: float) -> None:
    assert DRIVE.score(row(arrives=goal, stays_near=condition)) == pytest.approx(goal * condition)
    assert DRIVE.score(row(arrives=None, stays_near=1.0)) == 0.0, "doing nothing carefully"
    assert DRIVE.score(row("it broke", arrives=1.0, stays_near=1.0)) == 0.0


@given(st.integers(1, 60).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_interval_of_shares_is_that_of_scipy(counts: tuple[int, int]) -> None:
    met, n = counts
    expected = binomtest(met, n).proportion_ci(method="wilson")
    assert wilson_interval(met / n, n) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_every_task_names_criteria_of_its_experiment() -> None:
    for task in TASKS.values():
        criteria = load_experiment(task.experiment).criteria
        assert {*task.goals, *task.conditions} <= criteria.keys()


@pytest.mark.heavy
def test_worlds_are_scored_compared_and_kept(bench: Any, nrp: Any, worlds: Path, tmp_path: Path) -> None:
    asked = ("--worlds", "disc,fast,twin", "--seeds", SEEDS)
    done = bench(*asked)
    assert (done.code, done.err.splitlines()[0]) == (0, f"1 tasks, 12 runs; results in {tmp_path / 'out'}")
    with (tmp_path / "out" / "benchmark.csv").open(newline="") as file:
        rows = {one["world"]: one for one in csv.DictReader(file)}
    assert [float(rows[name]["score"]) for name in ("disc", "twin")] == [1.0, 1.0]
    assert float(rows["disc"]["score_low"]) < 0.6, "four runs prove little"
    again = json.loads(bench(*asked, "--json").out)
    assert [one["world"] for one in again["standings"]] == ["disc", "fast", "twin"]
    compared = nrp("diff", worlds, *asked, "--jobs", 1, "--results", tmp_path / "diff", "--json")
    assert again["standings"][0]["agreement"] == json.loads(compared.out)["answer"]


@pytest.mark.heavy
def test_wrong_agreements_are_seen(bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A comparison that takes every world for the first one finds that they agree."""

    def of_the_first(row: Row) -> GridCell:
        return GridCell("counting", "disc", row["seed"])

    asked = ("--worlds", "disc,fast", "--seeds", SEEDS, "--json")
    right = json.loads(bench(*asked).out)["standings"][0]["agreement"]
    monkeypatch.setattr(ladder, "cell_of", of_the_first)
    assert json.loads(bench(*asked).out)["standings"][0]["agreement"] != right


def test_a_pair_that_cannot_begin_is_named_and_the_others_run(
    bench: Any, worlds: Path, install: Callable[..., None]
) -> None:
    source = (
        "from experiment_fakes import DiscBackend\nfrom nrp_core.errors import SceneError\n"
        "class Backend(DiscBackend):\n    def engine(self, scene, *, seed, options):\n"
        "        raise SceneError('this engine has no walls')\n"
    )
    install("wall", "[nrp_core.world]\nwall = wall:Backend\n", source)
    done = bench("--worlds", "disc,wall", "--seeds", 1)
    assert "1 pair of backends: this engine has no walls" in done.out
    assert "cannot run" in done.out
    assert "one pair of backends, nothing to compare" in done.out
    assert done.code == 0


MISTAKES: Mapping[tuple[str, ...], str] = {
    ("walkin",): "there is no task 'walkin'; did you mean 'walking'?",
    ("drive", "drive"): "the task 'drive' is given twice",
    ("drive", "--worlds", "dics"): "no world backend is called 'dics'; did you mean 'disc'?",
    ("drive", "--worlds", "disc,disc"): "world 'disc' is given twice",
}


@pytest.mark.parametrize("arguments", MISTAKES)
def test_bad_input_gets_one_error(bench: Any, nrp: Any, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    done = nrp("benchmark", *arguments, "--brains", "counting", "--out", tmp_path / "out")
    assert MISTAKES[arguments] in done.err
    assert done.err.count("error: ") == 1
    assert not (tmp_path / "out").exists()


def test_a_brain_that_does_not_load_is_left_out_with_a_note(
    fakes: None, capsys: pytest.CaptureFixture[str]
) -> None:
    assert {"counting", "broken"} & {*named_or_all("", brains())} == {"counting"}
    assert "note: left out: brain backend 'broken'" in capsys.readouterr().err
