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
from nrp_core.world.robot_setup import AddedSensor, with_added_sensors
from nrp_core.world.sensors.sensor import Sensor

MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
ROBOT = '<sdf version="1.9"><model name="robot"><link name="body">{}</link></model></sdf>'

BROKEN = """
import a_module_that_is_not_installed
"""


WHISKER = """
from dataclasses import dataclass
from nrp_core.world import Sensor, noise_of, rate_of

@dataclass(frozen=True, slots=True)
class Whisker(Sensor):
    length: float

    @classmethod
    def read(cls, sensor, mount, reading):
        own = sensor.section("whisker")
        noise = noise_of(own.section("bend"), reading)
        return cls("w", "/w", rate_of(sensor, reading), own.number("length", 0.1), noise=noise)

    def part(self, model, link, engine):
        raise NotImplementedError
"""


def install(folder: Path, monkeypatch: pytest.MonkeyPatch, source: str) -> None:
    """Write a package with a sensor of the type ``whisker`` to a folder, and the folder to the path."""
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "acme_whisker", raising=False)
    (folder / "acme_whisker.py").write_text(source)
    info = folder / "acme_whisker-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-whisker\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{SENSORS.group}]\nwhisker = acme_whisker:Whisker\n")


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
    install(tmp_path, monkeypatch, BROKEN)
    file = robot(tmp_path, '<sensor name="ears" type="whisker"/>')
    with golden.raises(SceneError, match=r"robot\.sdf:1.*'whisker'.*1\.0"):
        read_model(file)


OWN = (
    "<whisker><length>0.2</length><bend><noise type='gaussian'><stddev>0.1</stddev></noise></bend></whisker>"
)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (OWN, ""),
        (OWN.replace("length>", "lenght>"),
         "<lenght> is not an element of <whisker>: ignored; did you mean <length>?"),
        (OWN.replace("stddev>", "stdev>"),
         "<stdev> is not an element of <noise>: ignored; did you mean <stddev>?"),
        (OWN.replace("whisker>", "wisker>"),
         "<wisker> is not an element of <sensor>: ignored; did you mean <whisker>?"),
    ],
    ids=("as it is read", "a parameter", "its noise", "its element"),
)  # fmt: skip
@pytest.mark.parametrize("of_sdf", [True, False])
def test_the_element_of_a_registered_sensor_is_known_with_what_its_reader_looks_for(
    content: str, message: str, of_sdf: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch, WHISKER)
    sensor = f'<sensor name="w" type="whisker"><update_rate>10</update_rate>{content}</sensor>'
    file = robot(tmp_path, f"<inertial><mass>1</mass></inertial>{sensor}")
    if not of_sdf:
        file = tmp_path / "robot.urdf"
        block = f'<gazebo reference="body">{sensor}</gazebo>'
        file.write_text(f'<robot name="robot"><link name="body">{MASS}</link>{block}</robot>')
    model = read_model(file)
    assert [finding.message for finding in model.warnings] == [message] * bool(message)
    (whisker,) = model.links[0].sensors
    assert whisker.noise.stddev == (0.1 if "wisker>" not in content and "stddev>" in content else 0.0)


@pytest.mark.parametrize(("name", "known"), [("length", True), ("lenght", False)])
def test_the_element_of_a_registered_sensor_is_known_among_added_sensors(
    name: str, known: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    install(tmp_path, monkeypatch, WHISKER)
    noise = {"@type": "gaussian", "stddev": 0.1}
    added = AddedSensor("whisker", "body", settings={"whisker": {name: 0.2, "bend": {"noise": noise}}})
    model = read_model(robot(tmp_path, ""))
    if known:
        (sensor,) = with_added_sensors(model, [added]).links[0].sensors
        assert (sensor.length, sensor.noise.stddev) == (0.2, 0.1)  # type: ignore[attr-defined]
    else:
        with golden.raises(SceneError, match="<lenght>.*<length>"):
            with_added_sensors(model, [added])


def test_data_without_a_part_is_refused_by_its_name(golden: Golden) -> None:
    model = Model("robot", (Link("body", sensors=(MountedSensor("bare", "/bare", 10.0),)),))
    with golden.raises(SceneError, match="'bare'.*'robot/body'.*MountedSensor"):
        list(parts_of(model, None))  # type: ignore[arg-type]  # nothing is measured
