"""The table of verdicts in docs/reference/command-line.md, with real runs: every surface says the same."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nrp_experiments
import pytest

from nrp_core.cli import app
from nrp_core.errors import NrpError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.recording.figures import plot
from nrp_core.recording.recording import Recording

CORPUS = Path(__file__).parents[2] / "plugins" / "nrp-legacy" / "tests" / "corpus"
SHIPPED = Path(nrp_experiments.__file__).parent / "braitenberg_husky"
HUSKY = ("husky",)
STAYS = "criteria={stays: {stays_within: {model: husky, distance: 5 m, of: start}}}"
NEVER = "criteria={never: {near: {model: husky, point: [90, 0], within: 1 m}}}"
SOON = "criteria={soon: {near: {model: husky, point: [0, 0], within: 1 m}}}"
NONE = "criteria=null"
RAISES = "raise ValueError('deep')"
HANGS = "while True: pass"
STOPS = "os.kill(os.getpid(), signal.SIGINT)"
LENIENT, GHOST = "strict=false", "world.robots.ghost={model: {broken}}"
QUARANTINE, LIMIT = "on_error=quarantine", "function_time_limit=0.3 s"

EXPERIMENT = f"""
name: verdict
timestep: 20 ms
duration: 0.4 s
brain: {{backend: event, model: {SHIPPED}/brain.py, populations: {{sensors: "0:5", actors: "6:8"}}}}
world:
  backend: mujoco
  scene: {SHIPPED}/room.sdf
  robots: {{husky: {{model: {SHIPPED}/husky.sdf, pose: [0, 0, 0.2, 0, 0, 0]}}}}
"""
FAULTY = """
from nrp_brain_event import EventBackend
from nrp_world_mujoco import MujocoBackend


def break_at(side, method):
    step = getattr(side, method)

    def broken(*arguments):
        if side.now_ns >= 260_000_000:
            raise ZeroDivisionError("deep inside")
        return step(*arguments)

    setattr(side, method, broken)


class World(MujocoBackend):
    def open(self, *arguments, **options):
        world = super().open(*arguments, **options)
        break_at(world, "_advance")
        return world


class Brain(EventBackend):
    def open(self, *arguments, **options):
        brain = super().open(*arguments, **options)
        break_at(brain, "_do_run_until")
        return brain
"""


@dataclass(frozen=True)
class Row:
    """A row of the table: settings, and the verdict that follows from them.

    Args:
        settings: the experiment and its overrides.
        complete, passed, code: the verdict.
        problem: the code of the finding that is the cause, if any.
        body: the code of a transfer function after 0.2 s.
        options: of the command.
        unusable: a file of the corpus that cannot be used.
    """

    settings: tuple[str, ...]
    complete: bool
    passed: bool | None
    code: int
    problem: str | None = None
    body: str | None = None
    options: tuple[str, ...] = ()
    unusable: str | None = None


TABLE = {
    "all criteria are met": Row((*HUSKY, STAYS), True, True, 0),
    "a criterion is not met": Row((*HUSKY, NEVER), True, False, 1),
    "no criteria": Row((*HUSKY, NONE), True, None, 0),
    "until, open": Row((*HUSKY, STAYS), True, None, 0, options=("--until", "0.2s")),
    "until, decided": Row((*HUSKY, SOON), True, True, 0, options=("--until", "0.2s")),
    "unheard command": Row((*HUSKY, STAYS, LENIENT), True, True, 0, "NRP212", "return Twist()"),
    "unheard, declared": Row((*HUSKY, STAYS), True, True, 0, "NRP212", "return Twist()"),
    "a robot is left out": Row((*HUSKY, STAYS, LENIENT, GHOST), False, None, 1),
    "quarantine": Row((*HUSKY, STAYS, QUARANTINE), False, None, 1, "NRP272", RAISES),
    "quarantine, not met": Row((*HUSKY, NEVER, QUARANTINE), False, False, 1, "NRP272", RAISES),
    "quarantine, no criteria": Row((*HUSKY, NONE, QUARANTINE), False, None, 1, "NRP272", RAISES),
    "quarantine, allowed": Row(
        (*HUSKY, STAYS, QUARANTINE), False, None, 0, "NRP272", RAISES, ("--allow-incomplete",)
    ),
    "a function raises": Row((*HUSKY, STAYS), False, False, 1, "NRP276", RAISES),
    "a function raises, allowed": Row(
        (*HUSKY, STAYS), False, False, 1, "NRP276", RAISES, ("--allow-incomplete",)
    ),
    "a function hangs": Row((*HUSKY, STAYS, LIMIT), False, False, 1, "NRP276", HANGS),
    "a function hangs, quarantine": Row((*HUSKY, STAYS, LIMIT, QUARANTINE), False, None, 1, "NRP272", HANGS),
    "the world fails": Row((*HUSKY, STAYS, "world.backend=faulty"), False, False, 1, "NRP276"),
    "the brain fails": Row((*HUSKY, SOON, "brain.backend=faulty"), False, False, 1, "NRP276"),
    "interrupted": Row((*HUSKY, SOON), False, None, 130, "NRP294", STOPS),
    "the room is left out": Row(("bare/bare.exc",), False, None, 1),
    "the brain is left out": Row(
        ("husky_2017/experiment_configuration.exc", "duration=0.1 s"), False, None, 1,
        unusable="models/brain_model/two_cells.py",
    ),
    "a function is left out": Row(("floreano_2018/experiment.exc", "duration=0.1 s"), False, None, 1),
    "a state machine is left out": Row(("icub_2017/icub.exc", "duration=0.1 s"), False, None, 1),
}  # fmt: skip


@pytest.fixture
def settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Row], list[str]]:
    """Return a function that gives the experiment of a row and its overrides; installs faulty backends."""
    site = tmp_path / "site"
    info = site / "faulty-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: faulty\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[nrp_core.brain]\nfaulty = faulty:Brain\n[nrp_core.world]\nfaulty = faulty:World\n"
    )
    (site / "faulty.py").write_text(FAULTY)
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)

    def of(row: Row) -> list[str]:
        name, *overrides = row.settings
        if name.endswith(".exc"):
            corpus = shutil.copytree(CORPUS, tmp_path / "corpus")
            if row.unusable is not None:
                (corpus / row.unusable).write_text("import no_such_simulator as sim\nsim.setup()\n")
            return [str(corpus / name), *overrides, f"models=[{corpus / 'models'}]"]
        experiment, broken = tmp_path / "experiment.yaml", tmp_path / "broken.sdf"
        experiment.write_text(EXPERIMENT)
        broken.write_text("<sdf><model name='ghost'></model></sdf>")
        if row.body is not None:
            functions = tmp_path / "late.py"
            functions.write_text(
                "import os, signal\nfrom geometry_msgs.msg import Twist\n\n\n"
                "@nrp.Neuron2Robot(Topic('/husky/cmd_vell', Twist))\ndef late(t):\n"
                f"    if t > 0.2:\n        {row.body}\n"
            )
            declared = (
                [] if "strict=false" in overrides else ["topics={/husky/cmd_vell: geometry_msgs/Twist}"]
            )
            overrides += [f"transfer_functions=[{functions}]", *declared]
        return [str(experiment), *(each.replace("{broken}", str(broken)) for each in overrides)]

    return of


def shown(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, dict[str, Any]]:
    """Run a command with ``--json``; return its exit code and its document."""
    code = app.run_app([*arguments, "--json"])
    out = capsys.readouterr().out
    return code, json.loads(out[out.index("{\n") :])  # functions of the corpus print


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", TABLE)
def test_each_cause_has_its_verdict_on_every_surface(
    name: str,
    settings: Callable[[Row], list[str]],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    row, folder = TABLE[name], tmp_path / "recording"
    experiment, *overrides = settings(row)
    given = [word for override in overrides for word in ("-s", override)]
    code, data = shown(["run", experiment, *given, *row.options, "--record", str(folder)], capsys)
    assert (data["complete"], data["passed"], code) == (row.complete, row.passed, row.code), data["problems"]
    codes = [problem["code"] for problem in data["problems"]]
    assert row.problem is None or row.problem in codes
    assert row.complete is not any(problem["weight"] == "incomplete" for problem in data["problems"])
    _, inspected = shown(["inspect", str(folder)], capsys)
    told = ("complete", "passed", "problems", "state")
    assert {key: inspected[key] for key in told} == {key: data[key] for key in told}
    assert inspected["end_s"] == pytest.approx(data["sim_time_s"])
    with Run(load_experiment(experiment, overrides)) as run:
        with suppress(NrpError, KeyboardInterrupt):
            run.run_until(0.2 if "--until" in row.options else run.experiment.duration / 1e9)
        result = run.result()
    assert (result.complete, result.passed) == (row.complete, row.passed)


def test_the_time_and_the_verdict_of_a_failed_world_are_the_same_everywhere(
    settings: Callable[[Row], list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "recording"
    experiment, *overrides = settings(TABLE["the world fails"])
    given = [word for override in overrides for word in ("-s", override)]
    assert app.run_app(["run", experiment, *given, "--record", str(folder)]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "failed at 0.26 s"
    app.run_app(["inspect", str(folder)])
    out = capsys.readouterr().out
    assert "0 s to 0.26 s, 13 steps" in out
    assert "criterion is not met" not in out
    assert out.splitlines()[-1] == "failed at 0.26 s"
    figure = tmp_path / "figure.svg"
    plot(Recording(folder), figure)
    assert "failed at 0.26 s" in figure.read_text()


def test_a_killed_run_is_not_complete_and_no_criterion_is_blamed(
    settings: Callable[[Row], list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "recording"
    kills = Row((*HUSKY, STAYS), False, None, -signal.SIGKILL, body="os.kill(os.getpid(), signal.SIGKILL)")
    experiment, *overrides = settings(kills)
    given = [word for override in (*overrides, "pace=2") for word in ("-s", override)]
    command = [sys.executable, "-m", "nrp_core", "run", experiment, *given, "--record", str(folder)]
    done = subprocess.run(command, capture_output=True, env=dict(os.environ), timeout=300, check=False)
    assert done.returncode == -signal.SIGKILL
    _, data = shown(["inspect", str(folder)], capsys)
    assert (data["complete"], data["passed"]) == (False, None)
    assert [problem["code"] for problem in data["problems"]] == ["NRP294"]
    app.run_app(["inspect", str(folder)])
    out = capsys.readouterr().out
    assert "criterion" not in out
    assert out.splitlines()[-1].startswith("killed or still running at 0.")


def test_problems_are_grouped_and_counted_and_each_is_shown_on_request(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(app, "reserve_stdout", lambda: None)
    functions = tmp_path / "two.py"
    functions.write_text("".join(f"@nrp.Neuron2Robot()\ndef wrong{i}(t):\n    1 / 0\n\n\n" for i in (1, 2)))
    given = [f"transfer_functions=[{functions}]", QUARANTINE]
    experiment = tmp_path / "experiment.yaml"
    experiment.write_text(EXPERIMENT)
    command = ["run", str(experiment), *(word for each in given for word in ("-s", each))]
    assert app.run_app(command) == 1
    out, err = capsys.readouterr()
    assert (
        out.splitlines()[1].strip()
        == "✗ 2 transfer functions or state machines are left out or stopped [NRP272]"
    )
    assert "wrong1" not in out + err
    assert app.run_app([*command, "-v"]) == 1
    out, err = capsys.readouterr()
    assert (out + err).count("'wrong1' raised ZeroDivisionError: division by zero") == 1
    assert f"{functions}:3: the transfer function 'wrong1' raised" in out
