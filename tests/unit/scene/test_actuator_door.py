"""Drives and controllers are found by entry points, ours as those of others."""

from __future__ import annotations

from dataclasses import is_dataclass
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.reading.plugins import CONTROLLERS, DRIVES
from nrp_core.scene.sdf import read_model
from nrp_core.world.drives.drive import Drive

ROBOT = (
    '<sdf version="1.9"><model name="robot"><link name="body"/><plugin name="p" filename="{}"/></model></sdf>'
)

DRIFT = '''
from dataclasses import dataclass, replace
from nrp_core.world.drives.drive import Drive

@dataclass(frozen=True, slots=True)
class Drift(Drive):
    """A body that drifts."""

    def renamed(self, named):
        return replace(self, name=named(self.name))

    @classmethod
    def read_plugin(cls, plugin, model, reading):
        return cls(plugin.attribute("name"), f"/{reading.robot}/drift")

    def part(self, model, engine):
        raise NotImplementedError
'''


@pytest.mark.parametrize("name", DRIVES.names())
def test_every_drive_is_a_dataclass_that_reads_its_plugin(name: str) -> None:
    drive = DRIVES.load(name)
    assert isinstance(drive, type)
    assert issubclass(drive, Drive)
    assert is_dataclass(drive)
    assert not drive.__abstractmethods__


def test_no_plugin_is_both_a_drive_and_a_controller() -> None:
    assert len(CONTROLLERS.names()) >= 10
    assert not set(DRIVES.names()) & set(CONTROLLERS.names())


@pytest.mark.parametrize("name", CONTROLLERS.names())
def test_every_reader_of_controllers_imports(name: str) -> None:
    assert callable(CONTROLLERS.load(name))


def test_a_drive_of_another_package_is_read_and_one_without_wheels_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "acme_drift.py").write_text(DRIFT)
    info = tmp_path / "acme_drift-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-drift\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{DRIVES.group}]\nacme_drift = acme_drift:Drift\n")
    file = tmp_path / "robot.sdf"
    file.write_text(ROBOT.format("libacme_drift.so"))
    (drive,) = read_model(file).drives
    assert (type(drive).__name__, drive.command_topic, drive.joints) == ("Drift", "/robot/drift", ())
    file.write_text(ROBOT.format("libgazebo_ros_diff_drive.so"))
    with golden.raises(SceneError):
        read_model(file)
