"""A package adds a format by an entry point."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.scene.reading.context import added_formats
from nrp_core.scene.sdf import read_scene

READER = """
def read(path):
    name = path.read_text().split('"')[1]
    link = '<link name="l"><inertial/></link>'
    return f'<sdf version="1.9"><model name="{name}">{link}</model></sdf>', ["bricks are left out"]
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that packages are imported from, with one that says it reads ``<bricks>``."""
    info = tmp_path / "bricks-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: bricks\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[nrp_core.scene_readers]\nbricks = bricks_of_a_test:read\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "bricks_of_a_test", raising=False)
    return tmp_path


def test_a_file_of_an_added_format_is_a_scene(package: Path) -> None:
    (package / "bricks_of_a_test.py").write_text(READER)
    path = package / "tower.bricks"
    path.write_text('<bricks name="tower"/>')
    scene = read_scene(path)
    assert [model.name for model in scene.models] == ["tower"]
    assert scene.warnings == (Finding(Code.NRP278, "bricks are left out", Level.WARNING, path, 1),)
    assert "bricks" in added_formats()


def test_a_reader_that_does_not_import_is_named(package: Path, golden: Golden) -> None:
    path = package / "tower.bricks"
    path.write_text("<bricks/>")
    with golden.raises(SceneError, match=r"'bricks'.*1\.0.*bricks_of_a_test"):
        read_scene(path)


def test_two_readers_of_one_root_element_are_both_named(package: Path, golden: Golden) -> None:
    info = package / "more_bricks-2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: more_bricks\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text("[nrp_core.scene_readers]\nbricks = other_bricks:read\n")
    path = package / "tower.bricks"
    path.write_text("<bricks/>")
    with golden.raises(SceneError, match="'bricks'"):
        read_scene(path)
