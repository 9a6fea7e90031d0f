"""Comparing backends and recordings from the command line."""

import json
import re
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from nrp_lab.commands.diff import installed_worlds
from nrp_world_mujoco import MujocoBackend

from nrp_core._support.packages import fingerprint


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results that tests share: what one of them has run, another does not run again."""
    return tmp_path_factory.mktemp("results") / "kept"


@pytest.mark.heavy
def test_agreement_is_reported_and_the_exit_code_is_0(
    nrp: Any, worlds: Path, tmp_path: Path, kept: Path
) -> None:
    page = tmp_path / "page.html"
    done = nrp(
        "diff", worlds, "--worlds", "disc,twin", "--seeds", 7, "--jobs", 1,
        "--results", kept, "--html", page,
    )  # fmt: skip
    assert done.code == 0
    assert "runs: 14 of 14" in done.err
    assert done.out.startswith("The finding does not depend on the simulator\nThe engines agree: ")
    assert "the same to the last bit in 151 steps" in done.out
    html = page.read_text()
    assert html.count("<svg") == 3
    assert "agrees across backends" in html
    assert "<script" not in html
    assert 'src="' not in html


def test_differences_are_named(nrp: Any, worlds: Path, kept: Path) -> None:
    done = nrp(
        "diff", worlds, "--worlds", "disc,fast", "--seeds", 3, "--jobs", 1,
        "--results", kept, "--json",
    )  # fmt: skip
    assert done.code == 1
    told = json.loads(done.out)
    assert told["answer"] == "depends on the world"
    assert told["engines"]["answer"] == "the engines differ"
    assert told["engines"]["differences"][0]["measure"] == "motion"
    assert told["engines"]["differences"][0]["part"] == "husky/velocity"
    assert told["finding"] == ["criteria", "time_to_event"]
    assert told["metrics"]["steps"]["answer"] == "agrees across backends"
    response = told["metrics"]["drive_response"]["parts"]["husky/forward"]
    assert response["answer"] == "depends on the world"
    assert response["contrasts"][0]["difference"] == pytest.approx(0.5, abs=0.02)
    (divergence,) = told["divergences"]
    assert divergence["first"]["side"] == "world"
    assert divergence["visible"]["signal"].startswith("/gazebo/model_states/husky.")


@pytest.mark.heavy
def test_where_seeds_make_no_difference_it_says_what_to_do_about_it(
    nrp: Any, worlds: Path, tmp_path: Path, kept: Path
) -> None:
    page, results = tmp_path / "page.html", kept
    asked = ("diff", worlds, "--worlds", "disc,fast", "--seeds", 3, "--jobs", 1, "--results", results)
    done = nrp(*asked, "--html", page)
    assert "more than" not in done.out
    assert "seeds have no effect" in " ".join(done.out.split())
    for told in (" ".join(done.out.split()), page.read_text()):
        assert "Seeds have no effect on time to event, " in told
        assert "--vary" in told
        assert "--margin time_to_event=VALUE (in s)" in told
    told = json.loads(nrp(*asked, "--margin", "time_to_event=5 s", "--json").out)
    assert told["metrics"]["time_to_event"]["answer"] == "agrees across backends"
    assert "to time to event" not in told["advice"]  # which is not held against the seeds any more


@pytest.mark.heavy
def test_finished_runs_are_not_repeated_and_processes_share_the_work(
    nrp: Any, worlds: Path, tmp_path: Path
) -> None:
    results = tmp_path / "results"
    asked = ("diff", worlds, "--worlds", "disc,fast", "--results", results, "--json")
    first = nrp(*asked, "--seeds", 1, "--jobs", 2)
    made = {folder: (folder / "recording.mcap").stat().st_mtime_ns for folder in results.glob("*-*")}
    assert len(made) == 2
    assert json.loads(first.out)["answer"] == "not decided: take more seeds"
    (next(iter(made)) / "run.json").unlink()  # as a kill leaves it
    nrp(*asked, "--seeds", 2, "--jobs", 1)
    again = {folder: (folder / "recording.mcap").stat().st_mtime_ns for folder in results.glob("*-*")}
    assert len(again) == 4
    assert sum(again[folder] == made[folder] for folder in made) == 1


def recorded_ns(results: Path) -> dict[str, int]:
    """Return the time at which each run was recorded, by the world of the run."""
    folders = results.glob("*-*")
    return {folder.name.split("-")[1]: (folder / "recording.mcap").stat().st_mtime_ns for folder in folders}


@pytest.mark.heavy
def test_another_file_makes_the_runs_that_read_it_again(
    nrp: Any, worlds: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    results = tmp_path / "results"
    asked = ("diff", worlds, "--worlds", "disc,twin", "--seeds", 1, "--jobs", 1, "--results", results)
    nrp(*asked)
    first = recorded_ns(results)
    drive = worlds / "drive.py"
    drive.write_text(drive.read_text() + "\n# changed\n")
    nrp(*asked)
    again = recorded_ns(results)
    assert first.keys() == again.keys() == {"disc", "twin"}
    assert all(again[name] > first[name] for name in first)
    for name in first:
        assert re.search(rf"counting-{name}-7-\w+ is run again: the file drive.py changed", caplog.text)


@pytest.mark.heavy
def test_a_backend_that_was_worked_on_is_run_again(
    nrp: Any, worlds: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    results = tmp_path / "results"
    asked = ("diff", worlds, "--worlds", "disc,fast", "--seeds", 1, "--jobs", 1, "--results", results)
    monkeypatch.delitem(sys.modules, "fast", raising=False)  # that of another test
    nrp(*asked)
    first = recorded_ns(results)
    (code,) = [path for entry in sys.path if (path := Path(entry) / "fast.py").is_file()]
    code.write_text(code.read_text() + "\n# changed\n")
    fingerprint.cache_clear()  # another process
    nrp(*asked)
    again = recorded_ns(results)
    assert first.keys() == again.keys() == {"disc", "fast"}
    assert again["fast"] > first["fast"]
    assert again["disc"] == first["disc"]
    assert re.search(r"counting-fast-7-\w+ is run again: the code of fast changed", caplog.text)


def test_a_setting_can_be_drawn_with_the_seed(nrp: Any, worlds: Path, kept: Path) -> None:
    done = nrp(
        "diff", worlds, "--worlds", "disc,twin", "--seeds", 3, "--jobs", 1,
        "--vary", "events.red.at=0.5..1.5 s", "--results", kept, "--json",
    )  # fmt: skip
    told = json.loads(done.out)
    part = told["metrics"]["time_to_event"]["parts"]["arrives"]
    disc, twin = (set(cell["values"]) for cell in part["cells"])
    assert len(disc) > 1
    assert disc == twin


@pytest.mark.heavy
def test_two_recordings_are_compared_without_running_anything(nrp: Any, worlds: Path, tmp_path: Path) -> None:
    one, other, page = tmp_path / "one", tmp_path / "other", tmp_path / "page.html"
    assert nrp("run", worlds, "--record", one).code == 0
    nrp("run", worlds, "--record", other, "--world", "fast")
    same = shutil.copytree(one, tmp_path / "same")
    assert nrp("diff", one, same).out.startswith("identical: 151 steps")
    done = nrp("diff", one, other, "--html", page)
    assert done.code == 1
    assert "diverge in step" in done.out
    assert "Drive response" in done.out
    assert page.read_text().count("<svg") == 2
    told = json.loads(nrp("diff", one, other, "--json").out)
    assert told["identical"] is False
    assert told["signals"][0]["largest"] > 0


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["--worlds", "disc"], 2, "give two names"),
        (["--worlds", "disc,dics"], 4, "did you mean 'disc'"),
        (["--worlds", "disc,disc"], 3, "given twice"),
        (["--worlds", "disc,twin", "--margin", "time=1"], 2, "there is no metric 'time'"),
        (["--worlds", "disc,twin", "--vary", "seed"], 2, "KEY=LOW..HIGH"),
        (["--worlds", "disc,twin", "--vary", "events.rad.at=1..2 s"], 3, "did you mean 'red'"),
        (["--worlds", "disc,twin", "--vary", "seed=1..2", "--vary", "seed=3..4"], 2, "'seed' is given twice"),
        (["--worlds", "disc,twin", "--margin", "rate=1", "--margin", "rate=2"], 2, "'rate' is given twice"),
        (["--worlds", "disc,twin", "--html", "no/page.html"], 2, "the folder does not exist"),
    ],
)
def test_runs_that_cannot_be_compared_are_refused_before_anything_runs(
    nrp: Any, worlds: Path, tmp_path: Path, arguments: list[str], code: int, told: str
) -> None:
    results = tmp_path / "results"
    done = nrp("diff", worlds, *arguments, "--results", results)
    assert done.code == code
    assert told in " ".join(done.err.replace("│", " ").split())
    assert not results.exists()


def test_a_file_that_is_not_a_recording_is_refused(nrp: Any, worlds: Path, tmp_path: Path) -> None:
    done = nrp("diff", worlds, tmp_path)
    assert done.code == 3
    assert "it has no file 'recording.mcap'" in done.err


@pytest.mark.heavy
def test_an_experiment_says_itself_what_is_drawn_with_the_seed(nrp: Any, worlds: Path, kept: Path) -> None:
    varied = worlds / "varied.yaml"
    varied.write_text(
        "extends: experiment.yaml\nname: varied\ncomparison: {vary: {events.red.at: 0.5..1.5 s}}\n"
    )
    asked = ("diff", varied, "--worlds", "disc,twin", "--seeds", 3, "--jobs", 1, "--json")
    told = json.loads(nrp(*asked, "--results", kept).out)
    assert told["varied"] == {"events.red.at": "0.5..1.5 s"}
    part = told["metrics"]["time_to_event"]["parts"]["arrives"]
    assert len(set(part["cells"][0]["values"])) > 1
    fixed = json.loads(nrp(*asked, "--results", kept, "-s", "comparison=null").out)
    assert fixed["varied"] == {}


@pytest.fixture
def pair(nrp: Any, worlds: Path, tmp_path: Path) -> tuple[Path, Path]:
    """Two recordings; the robot of the second drives half as fast again."""
    one, other = tmp_path / "one", tmp_path / "other"
    nrp("run", worlds, "--record", one)
    nrp("run", worlds, "--record", other, "--world", "fast")
    return one, other


def test_options_of_runs_are_refused_where_nothing_runs(nrp: Any, pair: tuple[Path, Path]) -> None:
    for option in (("--brains", "x"), ("--worlds", "x"), ("--seeds", 3), ("-s", "seed=1"), ("--jobs", 1)):
        done = nrp("diff", *pair, *option)
        assert done.code == 2, option
        assert "two recordings are compared without a run" in " ".join(done.err.replace("│", " ").split())


def test_a_margin_against_seeds_is_refused_for_two_recordings(nrp: Any, pair: tuple[Path, Path]) -> None:
    done = nrp("diff", *pair, "--margin", "rate=1")
    assert done.code == 2
    assert "needs many seeds" in " ".join(done.err.replace("│", " ").split())


@pytest.mark.heavy
def test_the_exit_code_is_that_of_the_engines_on_request(nrp: Any, worlds: Path, kept: Path) -> None:
    asked = ("diff", worlds, "--seeds", 1, "--jobs", 1, "--results", kept)
    assert nrp(*asked, "--worlds", "disc,twin").code == 1  # one seed decides nothing about the finding
    assert nrp(*asked, "--worlds", "disc,twin", "--engines").code == 0
    done = nrp(*asked, "--worlds", "disc,fast", "--engines")
    assert done.code == 1
    assert "The engines differ in motion (world disc -> fast, husky/velocity: " in " ".join(done.out.split())


@pytest.mark.heavy
def test_a_margin_of_a_measure_says_what_matters(nrp: Any, worlds: Path, kept: Path) -> None:
    asked = ("diff", worlds, "--worlds", "disc,fast", "--seeds", 1, "--jobs", 1, "--engines", "--json")
    results = ("--results", kept)
    first = json.loads(nrp(*asked, *results).out)["engines"]
    margins = [x for name in {key.split(": ")[1].split("/", 1)[0] for key in first["new"]}
               for x in ("--margin", f"{name}=1000")]  # fmt: skip
    done = nrp(*asked, *results, *margins)
    assert done.code == 0
    refused = nrp(*asked, *results, "--margin", "motion/dog=1 %")
    assert refused.code == 3
    assert "'motion/dog' was not measured" in refused.out
    assert nrp(*asked, *results, "--margin", "motion=2sd").code == 2


def test_only_differences_that_a_baseline_does_not_have_are_new(
    nrp: Any, worlds: Path, pair: tuple[Path, Path], tmp_path: Path
) -> None:
    known = tmp_path / "known.json"
    asked = ("diff", *pair, "--engines", "--baseline", known, "--json")
    first = nrp(*asked)
    assert first.code == 0
    assert json.loads(first.out)["engines"]["answer"] == "the engines differ as known"
    data = json.loads(known.read_text())
    forgotten = next(iter(data["known"]))
    shrunk = {key: amount for key, amount in data["known"].items() if key != forgotten}
    known.write_text(json.dumps({**data, "known": shrunk}))
    again = nrp(*asked)
    assert again.code == 1
    assert json.loads(again.out)["engines"]["new"] == [forgotten]
    assert json.loads(known.read_text())["known"] == shrunk  # a baseline is written once
    known.write_text(json.dumps({**data, "known": {key: v / 2 for key, v in data["known"].items()}}))
    assert nrp(*asked).code == 1  # what has grown is new
    known.write_text(json.dumps({**data, "experiment": "another"}))
    assert nrp(*asked).code == 3
    known.write_text("[]")
    assert nrp(*asked).code == 3


def test_a_run_that_ended_early_is_reported_first(nrp: Any, worlds: Path, tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    nrp("run", worlds, "--record", one)
    wrong = worlds / "wrong.py"
    wrong.write_text(
        "@nrp.Neuron2Robot(Topic('/husky/cmd_vel', geometry_msgs.msg.Twist))\n"
        "def wrong(t):\n    if t > 1.0:\n        raise ValueError('worn out')\n"
    )
    nrp("run", worlds, "--record", other, "-s", f"transfer_functions=[{wrong}]")
    told = nrp("diff", one, other).out
    assert told.startswith("not complete: ")
    assert "worn out" in " ".join(told.split())


def test_all_worlds_are_the_installed_physics_engines_that_can_simulate_the_scene(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = installed_worlds("reflex_arm")
    assert "mujoco" in found
    assert ("pybullet" in found) == (find_spec("pybullet") is not None)
    monkeypatch.setattr(MujocoBackend, "muscles", False)
    monkeypatch.setattr(MujocoBackend, "own_actuators", False)
    assert installed_worlds("reflex_arm") == [name for name in found if name != "mujoco"]
    assert "mujoco has no muscles" in " ".join(capsys.readouterr().err.split())
    assert "mujoco" in installed_worlds("braitenberg_husky")
