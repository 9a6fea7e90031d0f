"""The start page of a folder that somebody else has made reads what it says, and executes nothing in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from golden import Golden
from nrp_cockpit.start.session import StartSession
from nrp_cockpit.wire.hub import Hub

from nrp_core.errors import ExperimentError

PLANTED = ("base64", "csv", "cv2", "json", "mcap", "numpy", "pydantic", "select", "sitecustomize", "struct")
"""Modules that the platform imports, and Python itself."""
PROPERTY = '<xacro:property name="p" value="${().__class__.__base__.__subclasses__()}"/>'
ROBOT = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">{property}
<link name="base{p}"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
</robot>
"""
EXPERIMENT = """name: {name}
extends: braitenberg_husky/no_red
brain: {{model: brain.py, populations: null}}
transfer_functions: [functions.py]
criteria: null
world: {{robots: {{husky: {{model: {robot}}}}}}}
"""


def trap(mark: Path) -> str:
    return f"open({str(mark)!r}, 'a').close()\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, in which each module and script leaves a mark when it is executed."""
    folder = tmp_path / "downloaded"
    folder.mkdir()
    monkeypatch.chdir(folder)
    for name in (*PLANTED, "brain", "functions"):
        (folder / f"{name}.py").write_text(trap(tmp_path / f"MARK_{name}"))
    (folder / "plain.urdf").write_text(ROBOT.format(property="", p=""))
    (folder / "robot.urdf.xacro").write_text(ROBOT.format(property=PROPERTY, p="${p}"))
    for name, robot in {"plain": "plain.urdf", "trap": "robot.urdf.xacro"}.items():
        (folder / f"{name}.yaml").write_text(EXPERIMENT.format(name=name, robot=robot))
    return folder


def test_a_folder_is_listed_at_once_and_drawn_on_request_and_nothing_in_it_is_executed(
    folder: Path, tmp_path: Path, golden: Golden
) -> None:
    session = StartSession(Hub(), lambda *_: pytest.fail("nothing is opened"), folder)
    session.look()
    for name in ("./plain.yaml", "./trap.yaml"):
        with golden.raises(ExperimentError, match=name):
            session.picture(name)
    assert session._pictures._drawing is None
    assert session.picture("./plain.yaml", reads_files=True)["type"] == "image/jpeg"
    with golden.raises(ExperimentError, match="trap.yaml"):
        session.picture("./trap.yaml", reads_files=True)
    session.close()
    assert sorted(path.name for path in tmp_path.glob("MARK_*")) == []
