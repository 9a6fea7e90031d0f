"""The errors, frames and rates that files give to sensors, as SDF and gz-sensors define them."""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from nrp_core.scene.devices import Noise
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.sensors.errors import Errors

S = 1_000_000_000
ROOM = """<sdf version="1.10"><world name="w"><gravity>0 0 -9.8</gravity>
<magnetic_field>1e-5 2e-5 -4e-5</magnetic_field>
<spherical_coordinates><heading_deg>{heading}</heading_deg></spherical_coordinates>
<model name="r"><pose>{pose}</pose><link name="b"><inertial><mass>2</mass></inertial>{sensor}</link>
<joint name="j" type="fixed"><parent>world</parent><child>b</child>{joint}</joint></model></world></sdf>"""
IMU = '<sensor name="i" type="imu"><update_rate>{}</update_rate><topic>/i</topic><imu>{}</imu></sensor>'
AXIS = "<{0}><noise type='gaussian{4}'><mean>{1}</mean><stddev>{2}</stddev>{3}</noise></{0}>"


def noisy(name: str, mean: float, stddev: float, more: str = "", kind: str = "") -> str:
    return AXIS.format(name, mean, stddev, more, kind)


@pytest.fixture
def opened(open_world, tmp_path):
    def open_room(sensor: str = "", joint: str = "", pose: str = "0 0 1 0 0 0", heading: float = 0.0):
        text = ROOM.format(sensor=sensor, joint=joint, pose=pose, heading=heading)
        (tmp_path / "room.sdf").write_text(text)
        return open_world(read_scene(tmp_path / "room.sdf"))

    return open_room


def collect(world, heard: dict, until_ns: int) -> dict[str, list]:
    """Return the messages of subscriptions; one keeps no more than those of a short time."""
    found: dict[str, list] = {name: [] for name in heard}
    while world.now_ns < until_ns:
        world.run_until(min(world.now_ns + 500_000_000, until_ns))
        for name, one in heard.items():
            found[name] += [each.message for each in one.take()]
    return found


def messages(world, topic: str, until_ns: int) -> list:
    return collect(world, {topic: world.subscribe(topic, depth=None)}, until_ns)[topic]


def rows(vectors) -> np.ndarray:
    return np.array([(each.x, each.y, each.z) for each in vectors])


def test_each_axis_of_an_imu_has_its_own_noise_and_a_bias_of_either_sign(opened):
    bias = "<bias_mean>0.5</bias_mean><bias_stddev>0</bias_stddev>"
    turning = noisy("x", 0, 0.01, bias) + noisy("y", 0, 0.02) + noisy("z", 0.1, 0.03)
    felt = noisy("x", 0, 0.1) + noisy("y", 0, 0.2, bias.replace("0.5", "0.7")) + noisy("z", 0, 0.3)
    axes = (("angular_velocity", turning), ("linear_acceleration", felt))
    inner = "".join(f"<{tag}>{each}</{tag}>" for tag, each in axes)
    sensor = IMU.format(500, inner)
    world = opened(sensor)
    found = messages(world, "/i", S // 2)
    turns, felt_by = rows(m.angular_velocity for m in found), rows(m.linear_acceleration for m in found)
    assert turns.std(axis=0) == pytest.approx([0.01, 0.02, 0.03], rel=0.15)
    assert felt_by.std(axis=0) == pytest.approx([0.1, 0.2, 0.3], rel=0.15)
    assert np.abs(turns.mean(axis=0)) == pytest.approx([0.5, 0.0, 0.1], abs=0.02)
    assert np.abs(felt_by.mean(axis=0)) == pytest.approx([0.0, 0.7, 9.8], abs=0.1)
    assert found[-1].angular_velocity_covariance[::4] == pytest.approx([1e-4, 4e-4, 9e-4])
    assert found[-1].linear_acceleration_covariance[::4] == pytest.approx([0.01, 0.04, 0.09])
    world.reset()
    again = rows(m.angular_velocity for m in messages(world, "/i", S // 2))
    assert again.tolist() == turns.tolist()


def test_the_noise_of_old_files_of_an_imu_is_that_of_its_quantities(opened):
    noise = (
        "<noise><type>gaussian</type><rate><mean>0</mean><stddev>0.02</stddev></rate>"
        "<accel><mean>1</mean><stddev>0.2</stddev></accel></noise>"
    )
    sensor = IMU.format(500, noise)
    found = messages(opened(sensor), "/i", S)
    assert rows(m.angular_velocity for m in found).std() == pytest.approx(0.02, rel=0.1)
    assert rows(m.linear_acceleration for m in found).mean(axis=0) == pytest.approx([1, 1, 10.8], abs=0.05)


def test_a_receiver_a_magnetometer_and_an_altimeter_have_the_noise_of_each_direction(opened):
    levels = noisy("horizontal", 0, 2) + noisy("vertical", 0, 5)
    fast = noisy("horizontal", 0.5, 0.1) + noisy("vertical", 0, 0.2)
    world = opened(
        '<sensor name="g" type="navsat"><update_rate>200</update_rate><topic>/g</topic><navsat>'
        f"<position_sensing>{levels}</position_sensing><velocity_sensing>{fast}</velocity_sensing></navsat></sensor>"
        '<sensor name="m" type="magnetometer"><update_rate>200</update_rate><topic>/m</topic><magnetometer>'
        f"{noisy('x', 0, 1e-6)}{noisy('y', 0, 3e-6)}{noisy('z', 2e-6, 5e-6)}</magnetometer></sensor>"
        '<sensor name="a" type="altimeter"><update_rate>200</update_rate><topic>/a</topic><altimeter>'
        f"{noisy('vertical_position', 0.2, 0.1)}{noisy('vertical_velocity', 0, 0.3)}</altimeter></sensor>"
    )
    heard = {name: world.subscribe(f"/{name}", depth=None) for name in ("g", "m", "a", "g/velocity")}
    got = collect(world, heard, 2 * S)
    places = np.array([(m.longitude * 111320, m.latitude * 110574, m.altitude) for m in got["g"]])
    assert places.std(axis=0) == pytest.approx([2, 2, 5], rel=0.15)
    assert got["g"][0].position_covariance[::4] == pytest.approx([4, 4, 25])
    velocities = rows(m.vector for m in got["g/velocity"])
    assert velocities.mean(axis=0) == pytest.approx([0.5, 0.5, 0], abs=0.05)
    assert velocities.std(axis=0) == pytest.approx([0.1, 0.1, 0.2], rel=0.15)
    fields = rows(m.magnetic_field for m in got["m"])
    assert fields.std(axis=0) == pytest.approx([1e-6, 3e-6, 5e-6], rel=0.15)
    assert fields[:, 2].mean() == pytest.approx(-3.8e-5, abs=1e-6)
    assert np.std([m.vertical_velocity for m in got["a"]]) == pytest.approx(0.3, rel=0.15)
    assert np.mean([m.vertical_position for m in got["a"]]) == pytest.approx(0.2, abs=0.03)


def test_a_bias_that_drifts_spreads_as_its_process_does():
    """Of an Ornstein-Uhlenbeck process from 0 the variance is sigma^2 tau / 2 (1 - exp(-2 t / tau))."""
    sigma, tau, t, n = 0.4, 3.0, 2.0, 4000
    errors = Errors(lambda: 5)
    noises = (Noise(drift_stddev=sigma, drift_time_s=tau),) * n
    for k in range(5):
        found = errors.on("x", round(k * t / 4 * S), np.zeros(n), noises)
    assert found.std() == pytest.approx(sigma * sqrt(tau / 2 * (1 - exp(-2 * t / tau))), rel=0.05)
    start = Errors(lambda: 5).on("x", 0, np.zeros(n), (Noise(bias_mean=3.0, bias_stddev=0.2),) * n)
    assert np.abs(start).mean() == pytest.approx(3.0, abs=0.02)
    assert np.abs(start).std() == pytest.approx(0.2, rel=0.1)
    assert (start > 0).mean() == pytest.approx(0.5, abs=0.05)


def test_a_drifting_bias_goes_on_from_a_snapshot(opened):
    drift = "<dynamic_bias_stddev>1</dynamic_bias_stddev>"
    drift += "<dynamic_bias_correlation_time>9</dynamic_bias_correlation_time>"
    inner = f"<angular_velocity>{noisy('x', 0, 0, drift)}</angular_velocity>"
    world = opened(IMU.format(50, inner))
    heard = {"/i": world.subscribe("/i", depth=None)}
    collect(world, heard, S)
    saved = world.snapshot()
    ahead = [each.angular_velocity.x for each in collect(world, heard, 2 * S)["/i"]]
    assert len(set(ahead)) == len(ahead) == 50
    world.restore(saved)
    assert [each.angular_velocity.x for each in collect(world, heard, 2 * S)["/i"]] == ahead


def test_a_quantized_reading_is_a_multiple_of_its_step(opened):
    noise = noisy("pressure", 0, 30, "<precision>25</precision>", "_quantized")
    sensor = (
        '<sensor name="p" type="air_pressure"><update_rate>100</update_rate><topic>/p</topic>'
        f"<air_pressure>{noise}</air_pressure></sensor>"
    )
    found = np.array([m.fluid_pressure for m in messages(opened(sensor), "/p", S)])
    assert np.all(found % 25 == 0)
    assert len(set(found)) > 3


@pytest.mark.parametrize(
    ("frame", "heading", "roll", "yaw"),
    [
        ("", 0, 0, 0.7),
        ("ENU", 0, 0, 0.7),
        ("ENU", 90, 0, 0.7 + pi / 2),
        ("NWU", 0, 0, 0.7 - pi / 2),
        ("NED", 0, pi, pi / 2 - 0.7),
        ("CUSTOM</localization><custom_rpy>0 0 0.3</custom_rpy><localization>", 0, 0, 0.4),
    ],
)
def test_the_orientation_of_an_imu_is_that_in_its_frame_of_reference(opened, frame, heading, roll, yaw):
    named = f"<localization>{frame}</localization>".replace("<localization></localization>", "")
    reference = f"<orientation_reference_frame>{named}</orientation_reference_frame>" if frame else ""
    sensor = IMU.format(50, reference)
    world = opened(sensor, pose="0 0 1 0 0 0.7", heading=heading)
    q = messages(world, "/i", S // 10)[-1].orientation
    wanted = Pose.from_rpy((0, 0, 0), roll, 0, yaw).orientation
    assert abs(np.dot((q.x, q.y, q.z, q.w), wanted)) == pytest.approx(1.0, abs=1e-9)


def test_an_imu_without_orientation_says_so(opened):
    sensor = IMU.format(50, "<enable_orientation>0</enable_orientation>")
    message = messages(opened(sensor, pose="0 0 1 0 0 0.7"), "/i", S // 10)[-1]
    assert message.orientation_covariance[0] == -1  # sensor_msgs/Imu
    assert message.orientation.w == 1


def test_a_force_sensor_measures_along_its_own_axes(opened):
    """A body of 2 kg is pitched by 0.5 rad, and the sensor turned by a quarter about the body's z."""
    sensor = (
        f'<sensor name="f" type="force_torque"><pose>0 0 0 0 0 {pi / 2}</pose><update_rate>100</update_rate>'
        "<topic>/f</topic><force_torque><frame>sensor</frame></force_torque></sensor>"
    )
    world = opened(joint=sensor, pose="0 0 2 0 0.5 0")
    force = messages(world, "/f", S // 10)[-1].wrench.force
    weight = 2 * 9.8
    assert (force.x, force.y, force.z) == pytest.approx((0, -weight * sin(0.5), -weight * cos(0.5)), abs=0.02)


def test_a_rate_of_0_is_one_message_in_each_step(opened):
    sensor = '<sensor name="i" type="imu"><update_rate>0</update_rate><topic>/i</topic></sensor>'
    world = opened(sensor)
    assert not [each for each in world.warnings if "update_rate" in str(each)]
    step_ns = world.engine.step_ns
    times = [each.header.stamp.to_ns() for each in messages(world, "/i", 100 * step_ns)]
    assert times == list(range(0, 101 * step_ns, step_ns))


def test_a_depth_camera_has_its_depths_on_its_topic(opened):
    sensor = (
        '<sensor name="d" type="depth_camera"><update_rate>10</update_rate><topic>/d</topic><camera>'
        "<image><width>16</width><height>12</height><format>R_FLOAT32</format></image></camera></sensor>"
    )
    world = opened(sensor)
    assert not [each for each in world.warnings if "FLOAT" in str(each)]
    assert messages(world, "/d", S // 5)[-1].encoding == "32FC1"
    assert {"/d", "/d/points", "/d/camera_info", "/d/color"} <= set(world.topics)


def test_the_mass_of_an_automatic_inertia_scales_that_of_its_shapes(tmp_path):
    shape = "<geometry><box><size>0.2 0.2 0.2</size></box></geometry>"
    box = f"<collision name='c'><density>200</density>{shape}</collision>"
    for mass, wanted in (("", 1.6), ("<mass>3</mass>", 3.0)):
        link = f"<link name='a'><inertial auto='true'>{mass}</inertial>{box}</link>"
        (tmp_path / "r.sdf").write_text(f"<sdf version='1.11'><model name='m'>{link}</model></sdf>")
        inertial = read_model(tmp_path / "r.sdf").links[0].inertial
        assert inertial.mass == pytest.approx(wanted)
        assert inertial.inertia[:3] == pytest.approx([wanted * 0.2**2 / 6] * 3)
