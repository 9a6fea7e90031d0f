"""Sensors of the Earth around the world: its magnetic field, its air, and the place on it."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.scene.model import Inertial, Joint, Link, Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.scene.surroundings import Surroundings
from nrp_core.world.sensors.navigation import AirPressure, Imu, Magnetometer, NavSat

MUNICH = Surroundings((2.1e-5, 1.5e-6, -4.3e-5), latitude=48.1, longitude=11.6, elevation=519.0, heading=90.0)
ROOM = """<sdf version="1.9"><world name="w">
<magnetic_field>2.1e-5 1.5e-6 -4.3e-5</magnetic_field>
<atmosphere type="adiabatic"><temperature>300</temperature><pressure>1e5</pressure></atmosphere>
<spherical_coordinates><surface_model>{planet}</surface_model><latitude_deg>48.1</latitude_deg>
<longitude_deg>11.6</longitude_deg><elevation>519</elevation><heading_deg>90</heading_deg>
</spherical_coordinates>
<model name="drone"><pose>0 0 2 0 0 0</pose><link name="body"><inertial/>
<sensor name="m" type="magnetometer"><update_rate>50</update_rate></sensor>
<sensor name="p" type="air_pressure"><update_rate>50</update_rate>
<air_pressure><reference_altitude>1000</reference_altitude></air_pressure></sensor>
<sensor name="g" type="navsat"><update_rate>50</update_rate></sensor>
</link></model></world></sdf>"""


def measured(open_world, advance, sensor, earth: Surroundings = MUNICH, pose: Pose = Pose()):
    """Return the message of a sensor on a body that is held in the world."""
    body = Link("body", inertial=Inertial(1.0), sensors=(sensor,))
    held = Model("drone", (body,), (Joint("j", "fixed", "world", "body"),), pose=pose)
    world = open_world(Scene((held,), surroundings=earth))
    heard = world.subscribe(sensor.topic)
    advance(world, 0.02)
    return heard.latest.message


def test_a_magnetometer_turns_with_its_robot_and_not_with_the_field(open_world, advance):
    mount = Pose.from_rpy((0.0, 0.0, 0.1), pi, 0.0, 0.0)
    sensor = Magnetometer("m", "/field", 50.0, mount)
    message = measured(open_world, advance, sensor, pose=Pose.from_rpy((1.0, 0.0, 2.0), 0.0, 0.0, pi / 2))
    felt = message.magnetic_field
    # half a turn about x after a quarter about z: the world's y is its x, and the world's x its y
    assert (felt.x, felt.y, felt.z) == pytest.approx((1.5e-6, 2.1e-5, 4.3e-5))
    assert message.header.frame_id == "drone/body/m"


@pytest.mark.parametrize(("height", "pascal"), [(0.0, 101325.0), (1000.0, 89874.6), (5000.0, 54019.9)])
def test_a_barometer_measures_the_standard_atmosphere(open_world, advance, height, pascal):
    """The pressures are those of the tables of the U.S. Standard Atmosphere 1976, Pa."""
    sensor = AirPressure("p", "/air", 50.0, altitude=height - 2.0)
    message = measured(open_world, advance, sensor, pose=Pose((0.0, 0.0, 2.0)))
    assert message.fluid_pressure == pytest.approx(pascal, rel=2e-4)


def test_a_receiver_of_satellites_knows_its_place_on_the_earth(open_world, advance):
    """With a heading of 90 degrees the world's x axis points north, and its y axis west."""
    message = measured(open_world, advance, NavSat("g", "/fix", 50.0), pose=Pose((100.0, -50.0, 20.0)))
    # radii of curvature of WGS 84 at this latitude, along the meridian and across it
    w = sqrt(1 - 0.00669437999014 * sin(radians(48.1)) ** 2)
    along, across = 6378137.0 * (1 - 0.00669437999014) / w**3, 6378137.0 / w
    assert message.latitude == pytest.approx(48.1 + 180 / pi * 100 / (along + 529), abs=1e-8)
    east = 180 / pi * 50 / ((across + 529) * cos(radians(48.1)))
    assert message.longitude == pytest.approx(11.6 + east, abs=1e-7)
    assert message.altitude == pytest.approx(539.0, abs=2e-3)
    assert (message.status.status, message.position_covariance_type) == (0, 2)


@given(st.floats(-89, 89), st.floats(-179, 179), st.floats(-400, 9000))
def test_the_origin_is_where_the_world_says(latitude, longitude, elevation):
    earth = Surroundings(latitude=latitude, longitude=longitude, elevation=elevation)
    found = earth.on_earth((0.0, 0.0, 0.0))
    assert found == pytest.approx((latitude, longitude, elevation), abs=1e-6)


def test_a_room_states_its_place_its_air_and_its_field(tmp_path, open_world, advance):
    path = tmp_path / "room.sdf"
    path.write_text(ROOM.format(planet="EARTH_WGS84"))
    scene = read_scene(path)
    assert scene.warnings == ()
    earth = scene.surroundings
    assert (earth.latitude, earth.longitude, earth.elevation, earth.heading) == (48.1, 11.6, 519, 90)
    assert (earth.magnetic_field, earth.temperature, earth.pressure) == (MUNICH.magnetic_field, 300, 1e5)
    world = open_world(scene)
    topics = {name.rpartition("/")[2]: world.subscribe(name) for name in world.topics if "/body/" in name}
    advance(world, 0.02)
    assert topics["navsat"].latest.message.latitude == pytest.approx(48.1)
    assert topics["air_pressure"].latest.message.fluid_pressure == pytest.approx(
        earth.pressure_at(1002), rel=1e-6
    )
    assert topics["magnetic_field"].latest.message.magnetic_field.z == pytest.approx(-4.3e-5)


def test_another_planet_is_reported(tmp_path, golden: Golden):
    path = tmp_path / "room.sdf"
    path.write_text(ROOM.format(planet="MOON_SCS"))
    (warning,) = read_scene(path).warnings
    assert "<surface_model> MOON_SCS" in warning.message
    golden(warning.message)


HECTOR = """<sdf version="1.6"><model name="quad"><link name="base"><inertial/></link>
<plugin name="gps" filename="libhector_gazebo_ros_gps.so"><bodyName>base</bodyName><updateRate>4</updateRate>
<referenceLatitude>49.9</referenceLatitude><referenceAltitude>3</referenceAltitude>
<gaussianNoise>0.1 0.1 0.2</gaussianNoise>
<xyzOffset>0 0 0.5</xyzOffset></plugin>
<plugin name="imu" filename="libhector_gazebo_ros_imu.so"><bodyName>base</bodyName>
<topicName>raw_imu</topicName><accelGaussianNoise>0.35 0.35 0.3</accelGaussianNoise></plugin>
</model></sdf>"""


def test_sensors_of_hector_are_read(tmp_path):
    (tmp_path / "quad.sdf").write_text(HECTOR)
    model = read_model(tmp_path / "quad.sdf", name="quad")
    gps, imu = model.link("base").sensors
    assert (gps.topic, gps.rate_hz, gps.noise.stddev) == ("/quad/fix", 4, 0.1)
    assert gps.velocity_topic == "/quad/fix_velocity"
    assert gps.pose.position == (0, 0, 0.5)
    assert (type(imu), imu.topic, imu.noise.stddev) == (Imu, "/quad/raw_imu", 0.35)
    (warning,) = (str(each) for each in model.warnings if "not used" in str(each))
    assert "<referenceLatitude> and <referenceAltitude> are not used: the world's" in warning


def test_a_receiver_of_hector_measures_its_velocity_in_the_world(open_world, tmp_path):
    """It falls freely for 1 s; gravity is 9.8 m/s²."""
    (tmp_path / "quad.sdf").write_text(HECTOR)
    world = open_world(read_model(tmp_path / "quad.sdf", name="quad"))
    velocity = world.subscribe("/quad/fix_velocity")
    world.run_until(1_000_000_000)
    message = velocity.latest.message
    assert message.header.frame_id == "world"
    fall = message.vector
    assert (fall.x, fall.y, fall.z) == pytest.approx((0, 0, -9.8), abs=1e-6)
