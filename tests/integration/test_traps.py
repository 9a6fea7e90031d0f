"""A folder of a stranger: no command executes anything of it, except those that the documentation names."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import traps
from typer.main import get_command

from nrp_core.cli.app import build_app

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "faults.md"
NOTHING, CONFINED, EXECUTED = "nothing", "confined", "with your permissions"
ROW = re.compile(r"^\| (nothing|confined|with your permissions) \| (`nrp .*) \|$", re.MULTILINE)
RECORDING = "recorded"
SCENES = (
    "robot.urdf", "robot.xml", "robot.urdf.xacro", "evaluated.xacro", "world.sdf", "plugin.sdf", "entity.sdf",
    "model.xml", "robot.zip", "mesh.dae", "mesh.stl", "image.png", "pipes.sdf", "pipes.xacro", "endless.urdf",
    "around.sdf",
)  # fmt: skip
EXPERIMENTS = (
    "experiment.yaml", "tagged.yaml", "robots.yaml", "pickled.yaml", "link.yaml", "old.exc",
    "simulation_config.json", ".",
)  # fmt: skip
OTHERS = (
    "brain.py", "functions.py", "old.bibi", "machine.exd", "network.pkl", "network.npy", "network.nrpnet",
    "network.json", "cells.nestml", "notebook.ipynb", "start.launch", "sweep.yaml", "template.html.j2",
    "edges.csv", "beside", "nowhere", RECORDING,
)  # fmt: skip
WAITING = tuple(f"waiting{suffix}" for suffix in traps.PIPES)
EVERY = (*SCENES, *EXPERIMENTS, *OTHERS, *WAITING, "pipes.yaml", "again/again")
VALIDATED = (
    *EXPERIMENTS[:3], *EXPERIMENTS[4:-1], "functions.py", "old.bibi", *WAITING[:3], "pipes.yaml",
)  # fmt: skip
TARGETS: dict[str, list[list[str]]] = {
    "list": [[]], "backends": [[], ["--refresh"]], "doctor": [[]], "cache": [[]], "schema": [["experiment"]],
    "inspect": [[one] for one in EVERY],
    "explain": [[one, "x"] for one in (*EXPERIMENTS, "functions.py", "brain.py", RECORDING)],
    "validate": [[one] for one in VALIDATED],
    "map": [["experiment.yaml", "-s", "brain.backend=spinnaker"], ["pickled.yaml"], ["old.exc"]],
    "generate": [["old.bibi"], ["functions.py"], ["waiting.bibi"], ["waiting.py", "--reverse"]],
    "import": [["simulation_config.json", "-o", "imported"], ["old.exc", "-o", "imported_exc"]],
    "import-connectome": [["edges.csv", "-o", "edges.nrpnet"], ["waiting.csv", "-o", "waiting.nrpnet2"]],
    "plot": [[RECORDING, "-o", "plot.png"]], "video": [[RECORDING, "-o", "video.mp4"]],
    "export": [[RECORDING, "--format", "csv", "-o", "exported"], [RECORDING, "--format", "nwb"]],
    "recover": [[RECORDING, "-o", "recovered"]], "share": [[RECORDING, "-o", "shared.html"]],
    "new": [["experiment", "mine", "-o", "new"]],
    "publish": [["socket", "/a", "1"]],
    "diff DIR DIR2": [[RECORDING, RECORDING]],
    "sweep show": [["show", "."]], "evolve show": [["show", "."]],
}  # fmt: skip
"""What is tried for each command that executes nothing, or confined."""


def table() -> dict[str, str]:
    """Return the table of the documentation: what each command executes."""
    rows = ROW.findall(PAGE.read_text())
    return {command: what for what, cell in rows for command in re.findall("`nrp ([^`]+)`", cell)}


def commands(command: Any, before: str = "") -> Iterator[str]:
    """Yield the registered commands, of which a group has several."""
    if not hasattr(command, "list_commands"):
        yield before
        return
    for name in command.list_commands(None):
        yield from commands(command.get_command(None, name), f"{before} {name}".strip())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with all traps, and a recording of a run of its experiment."""
    place = tmp_path_factory.mktemp("stranger")
    marks = tmp_path_factory.mktemp("marks")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(traps.MARKS, str(marks))
        patch.setenv("TMPDIR", str(tmp_path_factory.mktemp("temporary")))
        traps.lay(place)
        (answer,) = spring(place, [["run", "experiment.yaml", "--record", RECORDING, "--images", "off"]])
        assert {"brain", "functions"} <= set(answer[1]), "the traps work"
        assert not [one for one in answer[1] if one.startswith("module_")]
        yield place


def spring(place: Path, lines: list[list[str]]) -> list[tuple[int, list[str]]]:
    """Run command lines in a folder; return the exit code of each and the traps that it sprang."""
    done = subprocess.run(
        [sys.executable, "-P", traps.__file__], cwd=place, input="\n".join(map(json.dumps, lines)),
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(answers) == len(lines), f"{lines[len(answers)]}: {done.stderr[-2000:]}"
    assert "Traceback" not in done.stderr
    assert "this is a bug" not in done.stderr, done.stderr
    return [(code, sprung) for code, sprung in answers]


def test_the_table_has_every_command_and_no_other() -> None:
    names = set(commands(get_command(build_app())))
    documented = {name.split(" DIR")[0].removesuffix(" show") for name in table()}
    assert documented - names <= {"cockpit", "demo", "design", "share", "ros-bridge"}, "of plugins"
    assert names - documented == set()


def test_every_command_that_does_not_run_experiments_is_tried() -> None:
    safe = {name for name, what in table().items() if what != EXECUTED}
    assert safe - {"cockpit", "design", "share"} <= TARGETS.keys()
    assert not {name for name, what in table().items() if what == EXECUTED} & TARGETS.keys()


def test_there_are_at_least_thirty_traps(folder: Path) -> None:
    assert len(list(folder.iterdir())) >= 30


@pytest.mark.heavy
def test_no_trap_is_sprung_by_a_command_that_executes_nothing_or_confined(folder: Path) -> None:
    """It takes 25 s of a processor for a hundred command lines, most of it for seven checks and diagnoses."""
    names = set(commands(get_command(build_app())))
    lines = [
        [command.split()[0], *words]
        for command, tried in TARGETS.items()
        if command.split()[0] in names
        for words in tried
    ]
    before = {path.name for path in folder.iterdir()}
    found = spring(folder, lines)
    sprung = {" ".join(line): traps for line, (_, traps) in zip(lines, found, strict=True) if traps}
    assert sprung == {}
    written = {path.name for path in folder.iterdir()} - before
    assert written <= {word for line in lines for word in line} | {f"{RECORDING}.nwb"}, written
    codes = {" ".join(line): code for line, (code, _) in zip(lines, found, strict=True)}
    assert codes["inspect experiment.yaml"] == codes["validate experiment.yaml"] == 0
    assert codes["map experiment.yaml -s brain.backend=spinnaker"] == 0
    assert codes["inspect robot.urdf"] == 3
    assert not list(folder.glob("imported/beside*")), "a link to another folder is not followed"


@pytest.mark.heavy
def test_no_trap_is_sprung_by_confined_commands_on_a_system_without_landlock(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They execute nothing there: `validate` says so, and `map` has no network to map."""
    without = "from nrp_core._support import confinement\nconfinement._landlock_version = lambda: 0\n"
    (tmp_path / "sitecustomize.py").write_text(without)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    lines = [["validate", "experiment.yaml"], ["validate", "old.exc"], ["map", *TARGETS["map"][0]]]
    assert spring(folder, lines) == [(0, []), (0, []), (3, [])]
    with (folder / "brain.py").open("a") as brain:
        brain.write("\n# changed, so that the network which the run has built is not used again\n")
    ((_, trusted),) = spring(folder, [["validate", "experiment.yaml", "--trust"]])
    assert {"brain", "functions"} <= set(trusted), "the traps work"


def test_the_pages_and_the_help_agree_with_the_table(capfd: pytest.CaptureFixture[str]) -> None:
    pages = PAGE.parents[1]
    assert "faults.md#untrusted-files" in (pages / "reference" / "command-line.md").read_text()
    assert "faults.md#untrusted-files" in (pages / "howto" / "check-an-experiment.md").read_text()
    app = get_command(build_app())
    for name, what in table().items():
        if what == CONFINED:
            told = " ".join((app.get_command(None, name).help or "").split())
            assert "without network that can write only temporary files" in told
