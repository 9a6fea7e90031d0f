"""``nrp evolve`` on engines that simulate nothing: what it finds, resumes, writes and refuses."""

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_lab.evolve import evolve
from nrp_lab.evolve.history import History
from nrp_lab.evolve.optimisers import CmaOptimiser
from nrp_lab.sweep.record import JOURNAL
from nrp_lab.sweep.running import Progress

import nrp_core
from nrp_core.cli import app

pytestmark = pytest.mark.filterwarnings("ignore:nrp validate warns")
Evolve = Callable[..., Any]
FILE = """
experiment: drive_to_the_wall
settings: {duration: 1.6 s}
vary:
  events.go.publish.value: {from: 0.1, to: 2.0}
  events.red.at: {from: 100 ms, to: 1000 ms}
  seed: {from: 1, to: 2}
objective: {criterion_distance.stays_near: 1, time_to_event.arrives: -1}
missing: {time_to_event.arrives: 2}
population: 3
generations: 3
"""
RUNS = 18
MISSING = "missing: {time_to_event.arrives: 2}\n"


@pytest.fixture
def here(fakes: None, drive_to_the_wall: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: it has an experiment and the file of a search."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(drive_to_the_wall, tmp_path / "drive_to_the_wall")
    Path("search.yaml").write_text(FILE)
    return tmp_path


@pytest.fixture
def command(here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Evolve:
    """Return a function that runs ``nrp evolve`` in this process; it returns the code and both outputs."""
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def run(*arguments: Any) -> tuple[int, str, str]:
        capsys.readouterr()
        code = app.run_app(["evolve", *map(str, arguments)])
        return (code, *capsys.readouterr())

    return run


def candidates(folder: str) -> list[tuple[str, ...]]:
    """Return the settings and measures of all runs, in their order."""
    with Path(folder, "results.csv").open(newline="") as file:
        names = ("events.go.publish.value", "events.red.at", "seed", "trajectory_digest")
        return [tuple(row[name] for name in names) for row in csv.DictReader(file)]


def stop_after(runs: int) -> Callable[[Progress], None]:
    def on_progress(progress: Progress) -> None:
        if progress.done >= runs:
            raise KeyboardInterrupt

    return on_progress


def interrupted(folder: str) -> None:
    for runs in (2, 13):
        with pytest.raises(KeyboardInterrupt):
            evolve("search.yaml", folder, workers=1, on_progress=stop_after(runs))


@pytest.mark.heavy
@pytest.mark.parametrize(
    "optimiser", ["cma", *(pytest.param(name, marks=pytest.mark.heavy) for name in ("tpe", "nsga2"))]
)
def test_a_search_that_was_stopped_goes_on_with_the_same_candidates(here: Path, optimiser: str) -> None:
    Path("search.yaml").write_text(FILE + f"optimiser: {optimiser}\n")
    whole = evolve("search.yaml", "whole", workers=1)
    assert len(candidates("whole")) == RUNS
    interrupted("parts")
    again = evolve("search.yaml", "parts", workers=1)
    assert candidates("parts") == candidates("whole")
    ids = [json.loads(line)["id"] for line in Path("parts", JOURNAL).read_text().splitlines()]
    assert len(ids) == len(set(ids)) == len(set(candidates("whole")))
    assert (again.best, again.value) == (whole.best, whole.value)
    assert Path("parts/generations.csv").read_text() == Path("whole/generations.csv").read_text()


@pytest.mark.heavy
def test_an_optimiser_that_draws_other_numbers_when_it_resumes_is_noticed(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin, entropy = CmaOptimiser.begin, np.random.default_rng(0)

    def begin_with_other_numbers(optimiser: CmaOptimiser, space: Any) -> None:
        begin(optimiser, space)
        optimiser._search.opts["randn"] = optimiser._search.sm.randn = lambda *shape: entropy.standard_normal(
            shape
        )

    evolve("search.yaml", "whole", workers=1)
    monkeypatch.setattr(CmaOptimiser, "begin", begin_with_other_numbers)
    interrupted("parts")
    evolve("search.yaml", "parts", workers=1)
    assert candidates("parts") != candidates("whole")


@pytest.mark.heavy
def test_the_best_candidate_is_an_experiment_with_the_run_of_its_row(command: Evolve) -> None:
    code, out, err = command("search.yaml", "--workers", 1, "--json")
    assert code == 0, err
    assert "drive_to_the_wall: cma over 2 settings; 3 generations of 3 candidates, 2 runs each" in err
    data = json.loads(out)
    (best,) = data["best"]
    values = np.array(data["values"])
    assert values.shape == (3, 3, 1)
    assert best["values"] == [values.max()]
    rows = candidates("search.evolve")[2 * best["candidate"] :][:2]
    for go, red, seed, digest in rows:
        assert best["settings"] == {"events.go.publish.value": float(go), "events.red.at": red}
        result = nrp_core.run(data["files"][0], [f"seed={seed}"])
        assert result.trajectory_digest == digest
        took_s = result.criteria["arrives"].took_s if result.criteria["arrives"].passed else 2.0
        distance = result.criteria["stays_near"].distance
        assert distance is not None
        assert took_s is not None
        assert best["values"][0] == pytest.approx(distance - took_s)


@pytest.mark.heavy
def test_a_search_comes_closer_to_the_best_of_all_settings_and_ends_at_its_goal(here: Path) -> None:
    text = FILE.replace("generations: 3", "generations: 30\ngoal: 1.9").replace("seed: {from: 1, to: 2}", "")
    text = text.replace(MISSING, "").replace("time_to_event.arrives: -1", "criteria.arrives: 0.001")
    Path("search.yaml").write_text(text)
    found = evolve("search.yaml", "found", workers=1)
    first = found.history.generations[0].max()
    Path("search.yaml").write_text(text.replace("generations: 30", "generations: 1").replace("1.9", "99"))
    missed = evolve("search.yaml", "missed", workers=1)
    assert missed.ended == f"the goal 99 is not reached; the best is {missed.value:.5g}"
    best = nrp_core.run(found.files[0]).criteria
    assert best["stays_near"].distance is not None
    assert found.value > max(1.9, first)
    assert found.value == best["stays_near"].distance + 0.001 * bool(best["arrives"].passed)
    assert found.ended == "the goal 1.9 is reached"
    assert len(found.history) < 30


def test_identical_candidates_are_reported(here: Path) -> None:
    """Until 0.1 s nobody arrives, whatever the speed."""
    text = FILE.replace(
        "{criterion_distance.stays_near: 1, time_to_event.arrives: -1}", "{criteria.arrives: 1}"
    )
    Path("search.yaml").write_text(
        text.replace(MISSING, "").replace("generations: 3", "until: 100 ms\ngenerations: 2")
    )
    found = evolve("search.yaml", "alike", workers=1)
    assert found.ended.startswith("all ")
    assert "candidates have the value 0: nothing that was searched changes it" in found.ended


@pytest.mark.heavy
def test_several_objectives_give_the_candidates_that_none_surpasses(command: Evolve) -> None:
    several = "[{criterion_distance.stays_near: 1}, {criterion_distance.arrives: 1}]"
    Path("search.yaml").write_text(
        FILE.replace("{criterion_distance.stays_near: 1, time_to_event.arrives: -1}", several).replace(
            MISSING, ""
        )
        + "optimiser: nsga2\n"
    )
    code, out, err = command("search.yaml", "--workers", 1, "--plot", "front.png")
    assert code == 0, err
    assert Path("front.png").stat().st_size > 5000
    history = History.read(Path("search.evolve"))
    front = {tuple(history.values[one]) for one in history.best}
    pairs = {tuple(pair) for pair in history.values}
    assert front == {
        pair for pair in pairs if not any(a >= pair[0] and b >= pair[1] and (a, b) != pair for a, b in pairs)
    }
    assert out.count("run it with: nrp run search.evolve/best_") == len(front) > 1


def test_a_hopeless_run_stops_as_soon_as_its_criterion_is_not_met(command: Evolve) -> None:
    hopeless = FILE.replace("settings: {", "settings: {criteria.stays_near.stays_within.distance: 0.3 m, ")
    Path("search.yaml").write_text(hopeless + "stop_when_failed: [stays_near]\n")
    assert command("search.yaml", "--workers", 1)[0] == 0
    with Path("search.evolve/results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    stopped = [row for row in rows if row["criteria.stays_near"] == "0.0"]
    assert len(stopped) > 3
    for row in stopped:
        assert float(row["criterion_distance.stays_near"]) == pytest.approx(0.3, abs=0.05)
        assert float(row["sim_time_s"]) < 1.6
        assert row["passed"] == "False"


@pytest.mark.heavy
def test_the_results_are_shown_and_drawn(command: Evolve, here: Path) -> None:
    assert command("search.yaml", "--workers", 1)[0] == 0
    code, out, err = command("show", "search.evolve", "--plot", "course.png")
    assert code == 0, err
    assert "generation 2: best" in out
    assert "run it with: nrp run search.evolve/best.yaml" in out
    assert Path("course.png").stat().st_size > 5000
    code, _, err = command("show", "search.evolve", "--workers", 2)
    assert (code, "it has no effect with 'show'" in err) == (2, True)
    _, _, err = command("show", here)
    assert "the folder does not contain a sweep" in err


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("red.at", "rad.at", "search.yaml:6:18: there is no 'rad' to vary"),
        ("from: 0.1, to: 2.0", "from: 2.0, to: 0.1", "search.yaml:5:28: vary.events.go.publish.value: 'to'"),
        (
            "{from: 0.1, to: 2.0}",
            "[1, 2]",
            "search.yaml:5:28: vary.events.go.publish.value: a search needs a r",
        ),
        (
            "population: 3",
            "population: 3\noptimizer: cma",
            "a search has no key 'optimizer'; did you mean 'o",
        ),
        ("population: 3", "population: 2", "population: 'cma' needs at least 3, not 2"),
        (
            "population: 3",
            "population: 3\noptimiser: cna",
            "no optimiser is called 'cna'; did you mean 'cma'?",
        ),
        (
            "stays_near: 1,",
            "stays_nearer: 1,",
            "search.yaml:8:46: objective: 'criterion_distance.stays_nearer' is not measured; did you mean",
        ),
        (
            "missing: {time_to_event.arrives",
            "missing: {time_to_event.arives",
            "is not in the objective; did you",
        ),
        ("{criterion_distance.stays_near: 1", "{criterion: 1", "a measure is named METRIC.PART"),
        (
            "criterion_distance.stays_near: 1",
            "criterion_distance.stays_near: far",
            "is a number other than 0",
        ),
        ("stays_near: 1", "stays_near: .nan", "is a number other than 0, not nan"),
        ("population: 3", "population: 3\ngoal: true", "goal: should be a valid number, not True"),
        ("arrives: 2}", "arrives: false}", "'time_to_event.arrives' should be a valid number, not False"),
        ("population: 3", "population: true", "population: should be a valid integer, not True"),
        ("criterion_distance.stays_near", "criterion_dist.stays_near", "there is no metric 'criterion_dist'"),
        ("missing: {time_to_event.arrives: 2}", "until: 100 ms", "has no value of 'time_to_event.arrives'"),
        ("population: 3", "population: 3\nstop_when_failed: [stays]", "there is no criterion 'stays'"),
        (
            "{criterion_distance.stays_near: 1, time_to_event.arrives: -1}",
            "[{criterion_distance.stays_near: 1}, {time_to_event.arrives: -1}]",
            "the optimiser 'cma' has one objective, not 2; 'nsga2' takes several",
        ),
    ],
)
def test_bad_input_gets_one_error(command: Evolve, old: str, new: str, message: str) -> None:
    assert old in FILE
    Path("search.yaml").write_text(FILE.replace(old, new))
    code, _, err = command("search.yaml", "--workers", 1)
    assert code in (3, 4)
    assert err.count("error: ") == 1
    assert message in err


@pytest.mark.heavy
def test_a_folder_of_another_search_and_of_a_sweep_are_refused(command: Evolve) -> None:
    assert command("search.yaml", "--workers", 1)[0] == 0
    Path("search.yaml").write_text(FILE.replace("to: 2.0", "to: 3.0"))
    _, _, err = command("search.yaml")
    assert "the folder contains another search, with different settings of the search" in err
    Path("search.yaml").write_text(FILE.replace("generations: 3", "generations: 4"))
    assert command("search.yaml", "--workers", 1)[0] == 0
    assert len(candidates("search.evolve")) == RUNS + 6


def test_only_show_takes_a_folder_and_it_needs_one(command: Evolve) -> None:
    assert "name the folder of the results: nrp evolve show DIR" in words(command("show"))
    assert "only 'show' takes a folder; use --out for results" in words(command("search.yaml", "results"))


def words(done: tuple[int, str, str]) -> str:
    """Return the error of a command that was used wrongly, without line breaks."""
    code, out, err = done
    assert (code != 0, out) == (True, "")
    return " ".join(err.split())


def test_without_the_package_the_error_names_the_command(
    command: Evolve, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "cma", None)
    code, _, err = command("search.yaml")
    assert code != 0
    assert "pip install 'nrp-lab[evolve]'" in err
