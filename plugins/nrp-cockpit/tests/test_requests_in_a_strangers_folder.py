"""The requests of an opened session and of the designer, in a folder of traps.

The experiment is one of ours, beside the traps, so that nothing of the folder need be executed.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
import traps
from nrp_cockpit.wire.hub import Service
from visitors import Cockpit, cockpit

from nrp_core.errors import NrpError

EXPERIMENT = """
extends: braitenberg_husky/no_red
models: [.]
criteria: null
duration: 2 s
transfer_functions: [ours.py]
"""
EXECUTED = {"functions/apply", "functions/save", "designer/save", "designer/run"}
"""Requests that execute the text that they are given, or save it for the next run of the experiment."""
ENDING = {"halt", "part"}
"""Requests that end what others need."""
FILES = (
    "brain.py", "functions.py", "old.bibi", "robot.urdf", "robot.urdf.xacro", "world.sdf", "model.xml",
    "robot.zip", "mesh.dae", "network.pkl", "experiment.yaml", "tagged.yaml", "link.yaml", "beside/hostname",
    "waiting.py", "waiting.bibi", "waiting.urdf", "endless.urdf", "template.html.j2", "recorded",
)  # fmt: skip
OTHER = {
    "bool": True, "int": 1, "float": 0.02, "float | None": 0.02, "int | None": 1, "list[int]": [0],
    "Sequence[float]": [0.0, 0.0, 1.0], "dict[str, Any]": {"model": "robot.urdf"}, "Any": 1.0,
}  # fmt: skip
"""A value for each other type of an argument."""


def suited(text: str) -> str:
    """Return functions for the brain of the experiment."""
    return text.replace("wheels[0]", "actors")


@pytest.fixture
def marks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of marks; the current one has all traps, and an experiment without any."""
    folder, marks = tmp_path / "stranger", tmp_path / "marks"
    folder.mkdir()
    marks.mkdir()
    monkeypatch.setenv(traps.MARKS, str(marks))
    traps.lay(folder)
    (folder / "ours.yaml").write_text(EXPERIMENT)
    (folder / "ours.py").write_text(suited(traps.FUNCTIONS))
    monkeypatch.chdir(folder)
    return marks


@pytest.fixture
def opened(marks: Path) -> Iterator[Cockpit]:
    with cockpit(experiment="ours.yaml") as opened:
        yield opened


def requests(opened: Cockpit) -> dict[str, Service]:
    """Return all registered requests by their names."""
    services = opened.session.hub.services
    return {
        name.removeprefix("/cockpit/"): one
        for name, one in {**services.steering, **services.watching}.items()
    }


def fields_of(service: Service) -> Iterator[dict[str, Any]]:
    """Yield arguments for a request: each trap in each argument that is a text."""
    kinds = {one.name: str(one.annotation) for one in inspect.signature(service).parameters.values()}
    texts = [name for name, kind in kinds.items() if kind.split(" ")[0] in ("str", "'str'")]
    usual = {name: OTHER.get(kind) for name, kind in kinds.items() if name not in texts}
    if any(kind.startswith("Mapping") for kind in kinds.values()):
        texts_of_files = {
            "files": {str(Path("ours.py").absolute()): suited(Path("functions.py").read_text())},
            "base": None,
        }
        yield {**usual, **{name: value for name, value in texts_of_files.items() if name in kinds}}
    elif "language" in kinds:
        yield {"language": "python", "text": suited(Path("functions.py").read_text())}
        yield {"language": "xml", "text": Path("old.bibi").read_text()}
    elif texts:
        for trap in (*FILES, str(Path("brain.py").absolute()), traps.python("text"), traps.xacro("text")):
            yield {**usual, **dict.fromkeys(texts, trap)}
    else:
        yield usual


def ask(opened: Cockpit, name: str) -> int:
    """Ask for something in all ways; return how often it was done."""
    done = 0
    for fields in fields_of(requests(opened)[name]):
        with suppress(NrpError):
            requests(opened)[name](**fields)
            done += 1
    return done


def test_no_request_but_those_that_execute_what_they_are_given_springs_a_trap(
    opened: Cockpit, marks: Path
) -> None:
    """Every registered request, so that a new one is included."""
    done, sprung = {}, {}
    for name in [one for one in requests(opened) if one not in EXECUTED | ENDING]:
        done[name] = ask(opened, name)
        sprung |= {path.name: name for path in marks.iterdir() if path.name not in sprung}
    assert sprung == {}
    assert {"designer/open", "functions/check", "bodies/models", "designer/write", "step"} <= {
        name for name, times in done.items() if times
    }
    assert requests(opened).keys() >= EXECUTED | ENDING


def test_an_applied_text_is_executed_with_the_permissions_of_the_user(opened: Cockpit, marks: Path) -> None:
    opened.session.functions.apply(
        {str(Path("ours.py").absolute()): suited(Path("functions.py").read_text())}, base=None, check=False
    )
    assert [path.name for path in marks.iterdir()] == ["functions"]
