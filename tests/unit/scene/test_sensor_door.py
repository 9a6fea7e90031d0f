"""Sensors are found by entry points: ours, and those of packages of somebody else."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.devices import MountedSensor
from nrp_core.scene.model import Link, Model
from nrp_core.scene.reading.plugins import CONTROLLERS, DRIVES
from nrp_core.scene.reading.sensors import PLUGIN, SENSORS
from nrp_core.scene.sdf import read_model
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.parts import parts_of
from nrp_core.world.sensors.sensor import Sensor

ROBOT = '<sdf version="1.9"><model name="robot"><link name="body">{}</link></model></sdf>'

BROKEN = """
import a_module_that_is_not_installed
"""


def robot(folder: Path, content: str) -> Path:
    file = folder / "robot.sdf"
    file.write_text(ROBOT.format(content))
    return file


@pytest.mark.parametrize("name", SENSORS.names())
def test_every_sensor_says_what_it_reads_and_what_it_needs_of_an_engine(name: str) -> None:
    sensor = SENSORS.load(name)
    assert isinstance(sensor, type)
    assert issubclass(sensor, Sensor)
    assert is_dataclass(sensor)
    assert sensor.needs
    assert set(sensor.needs) <= {field.name for field in fields(WorldCapabilities)}
    reads = sensor.read_plugin if name.startswith(PLUGIN) else sensor.read
    assert reads.__func__ is not getattr(Sensor, reads.__name__).__func__  # type: ignore[attr-defined]


def test_the_reference_names_every_sensor_drive_and_controller() -> None:
    page = (Path(__file__).parents[3] / "docs" / "reference" / "topics.md").read_text("utf-8")
    names = [*SENSORS.names(), *DRIVES.names(), *CONTROLLERS.names()]
    assert [name for name in names if f"`{name.removeprefix(PLUGIN)}`" not in page] == []


def test_a_file_imports_the_sensors_that_it_has_and_no_others(tmp_path: Path) -> None:
    file = robot(tmp_path, '<sensor name="imu" type="imu"><update_rate>10</update_rate></sensor>')
    code = (
        "import sys\n"
        "from nrp_core.scene.sdf import read_model\n"
        f"read_model({str(file)!r})\n"
        "room = 'nrp_core.world.sensors'\n"
        "print([name for name in ('navigation', 'camera', 'laser') if f'{room}.{name}' in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "['navigation']"


def test_a_sensor_that_does_not_import_is_one_error_at_its_element(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "acme_whisker.py").write_text(BROKEN)
    info = tmp_path / "acme_whisker-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-whisker\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{SENSORS.group}]\nwhisker = acme_whisker:Whisker\n")
    file = robot(tmp_path, '<sensor name="ears" type="whisker"/>')
    with golden.raises(SceneError, match=r"robot\.sdf:1.*'whisker'.*1\.0"):
        read_model(file)


def test_data_without_a_part_is_refused_by_its_name(golden: Golden) -> None:
    model = Model("robot", (Link("body", sensors=(MountedSensor("bare", "/bare", 10.0),)),))
    with golden.raises(SceneError, match="'bare'.*'robot/body'.*MountedSensor"):
        list(parts_of(model, None))  # type: ignore[arg-type]  # nothing is measured
