"""Sensors that an experiment makes worse than their files have them."""

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.findings import InvalidExperimentError
from nrp_core.scene.devices import Noise
from nrp_core.scene.model import Link, Model, Scene
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.sensors.sensor import with_imperfection

pytestmark = pytest.mark.usefixtures("fakes")


def laser() -> Scene:
    sensor = Laser("laser", "/scan", 10.0, noise=Noise(0.0, 0.5))
    return Scene((Model("robot", (Link("base", sensors=(sensor,)),)), Model("other", (Link("base"),))))


def sensor_of(scene: Scene) -> Laser:
    (sensor,) = scene.models[0].links[0].sensors
    assert isinstance(sensor, Laser)
    return sensor


def test_only_the_given_settings_of_a_sensor_change() -> None:
    changed = with_imperfection(laser(), "/scan", delay=0.05)
    assert sensor_of(changed) == Laser("laser", "/scan", 10.0, noise=Noise(0.0, 0.5), delay=0.05)
    assert changed.models[1] == laser().models[1]
    assert changed.digest != laser().digest


def test_an_experiment_file_sets_noise_delay_and_losses(drive_to_the_wall: Path, tmp_path: Path) -> None:
    with_laser = (
        "<sensor name='laser' type='camera'><update_rate>10</update_rate><topic>eye</topic><camera><image>"
        "<width>4</width><height>4</height></image></camera></sensor>"
    )
    husky = tmp_path / "seeing.sdf"
    plain = Path(__file__).parents[2] / "shared" / "fakes" / "husky.sdf"
    husky.write_text(plain.read_text().replace("</link>", f"{with_laser}</link>", 1))
    override = "world.sensors={/husky/eye: {noise: 0.1, bias: 0.2, delay: 30 ms, drop_out: 0.25}}"
    scene = prepare(load_experiment(drive_to_the_wall, (override, f"world.robots.husky.model={husky}"))).scene
    (sensor,) = [s for _, link in scene.links() for s in link.sensors]
    assert (sensor.noise, sensor.delay, sensor.drop_out) == (Noise(0.2, 0.1), 0.03, 0.25)


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("{/husky/eyes: {delay: 1 ms}}", "'/husky/eyes'"),
        ("{/husky/eye: {drop_out: 1.5}}", ""),
        ("{/husky/eye: {noises: 1}}", "noises"),
    ],
)
def test_a_meaningless_setting_is_refused(
    drive_to_the_wall: Path, written: str, told: str, golden: Golden
) -> None:
    with golden.raises((InvalidExperimentError, ExperimentError), match=told):
        prepare(load_experiment(drive_to_the_wall, (f"world.sensors={written}",)))
