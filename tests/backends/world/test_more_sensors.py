"""Altimeters, logical cameras and pairs of cameras, on both engines, against geometry."""

from __future__ import annotations

from math import atan, cos, inf, pi, sin, sqrt, tan

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.messages.sensor_msgs import Range
from nrp_core.scene.devices import Noise
from nrp_core.scene.model import Box, Collision, Inertial, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.world.sensors.ground_truth import LogicalCamera
from nrp_core.world.sensors.navigation import Altimeter


def carrier(sensor, pose: Pose, *, static: bool = True) -> Model:
    body = Link("body", inertial=Inertial(1.0), sensors=(sensor,))
    return Model("carrier", (body,), pose=pose, static=static)


def sensed(world, topic, advance, seconds=0.02):
    heard = world.subscribe(topic)
    advance(world, seconds)
    return heard.latest.message


def test_a_falling_altimeter_measures_its_height_above_the_start(open_world, advance):
    sensor = Altimeter("a", "/height", 50.0, Pose((0.0, 0.0, 0.5)))
    world = open_world(
        Scene((carrier(sensor, Pose((0.0, 0.0, 20.0)), static=False),), gravity=(0.0, 0.0, -10.0))
    )
    message = sensed(world, "/height", advance, 1.0)
    assert message.vertical_reference == pytest.approx(20.5)
    assert message.vertical_velocity == pytest.approx(-10.0, abs=1e-6)
    assert message.vertical_position == pytest.approx(-5.0, abs=0.02)  # a physics step of the fall


def test_the_height_of_an_altimeter_has_the_noise_of_its_file(open_world, advance, read):
    noise = '<noise type="gaussian"><mean>3</mean><stddev>0.001</stddev></noise>'
    sensor = f"<altimeter><vertical_position>{noise}</vertical_position></altimeter>"
    model = read(
        '<static>1</static><link name="body"><sensor name="a" type="altimeter"><update_rate>50</update_rate>'
        f"{sensor}</sensor></link>"
    )
    assert model.links[0].sensors[0].noise == Noise(3.0, 0.001)
    message = sensed(open_world(model), "/robot/body/a/altimeter", advance)
    assert message.vertical_position != 3.0
    assert message.vertical_position == pytest.approx(3.0, abs=0.01)


EYE = LogicalCamera("eye", "/seen", 50.0, 0.5, 4.0, 1.0, 2.0, Pose((0.1, 0.0, 0.0)))
WIDE, HIGH = tan(0.5), tan(0.5) / 2


@pytest.mark.parametrize(
    ("place", "is_seen"),
    [
        ((0.51, 0.0, 0.0), True),
        ((0.49, 0.0, 0.0), False),
        ((3.99, 0.0, 0.0), True),
        ((4.01, 0.0, 0.0), False),
        ((2.0, 1.99 * WIDE, 0.0), True),
        ((2.0, -2.01 * WIDE, 0.0), False),
        ((2.0, 0.0, -1.99 * HIGH), True),
        ((2.0, 0.0, 2.01 * HIGH), False),
        ((-2.0, 0.0, 0.0), False),
    ],
)
def test_a_logical_camera_sees_origins_in_its_field_of_view(open_world, parts, advance, place, is_seen):
    stand = Pose.from_rpy((1.0, 2.0, 0.5), 0.0, 0.0, pi / 2)
    there = stand @ EYE.pose @ Pose(place)
    ball = parts.prop("ball", Sphere(0.2), Pose(there.position))
    far = parts.prop("far", Box((1.0, 1.0, 1.0)), Pose((50.0, 0.0, 0.0)))
    message = sensed(open_world(carrier(EYE, stand), ball, far), "/seen", advance)
    assert message.header.frame_id == "carrier/body/eye"
    assert [each.id for each in message.detections] == (["ball"] if is_seen else [])
    for each in message.detections:
        at = each.bbox.center.position
        assert (at.x, at.y, at.z) == pytest.approx(place, abs=1e-6)
        assert each.results[0].hypothesis.class_id == "ball"
        turn = each.bbox.center.orientation
        assert (turn.z, turn.w) == pytest.approx((-sqrt(0.5), sqrt(0.5)))


def test_a_logical_camera_that_could_see_nothing_is_refused(read, golden: Golden):
    lens = "<logical_camera><near>2</near><far>1</far></logical_camera>"
    with golden.raises(SceneError, match="<near>"):
        read(f'<link name="body"><sensor name="l" type="logical_camera">{lens}</sensor></link>')


STEREO = """<static>1</static><pose>0 0 0 0 0 0</pose><link name="head">
<sensor name="stereo" type="multicamera"><update_rate>50</update_rate>
{cameras}
<plugin name="s" filename="libgazebo_ros_multicamera.so"><cameraName>pair</cameraName>
<hackBaseline>0.2</hackBaseline></plugin></sensor></link>"""
CAMERA = """<camera name="{}"><pose>0 {} 0 0 0 0</pose><horizontal_fov>1</horizontal_fov>
<image><width>80</width><height>60</height></image></camera>"""


def test_a_pair_of_cameras_finds_the_distance_of_an_edge_by_its_disparity(open_world, parts, advance, read):
    robot = read(STEREO.format(cameras=CAMERA.format("left", 0.1) + CAMERA.format("right", -0.1)))
    post = parts.prop("post", Box((0.1, 1.0, 4.0)), Pose((2.05, -0.5, 0.0)), rgba=(1.0, 0.0, 0.0, 1.0))
    world = open_world(robot, post)
    topics = [
        f"/robot/pair/{eye}/{what}" for eye in ("left", "right") for what in ("image_raw", "camera_info")
    ]
    heard = {topic: world.subscribe(topic) for topic in topics}
    advance(world, 0.02)
    left, info, right, other = (heard[topic].latest.message for topic in topics)
    edges = [np.argmax(image.data[30, :, 0] == 255) for image in (left, right)]
    disparity = float(edges[0] - edges[1])
    focal, shift = other.p[0], other.p[3]
    assert (info.p[3], focal) == (0.0, pytest.approx(40 / tan(0.5)))
    assert shift == pytest.approx(-0.2 * focal)
    pixel = 2.0 / disparity  # what a pixel changes, m
    assert -shift / disparity == pytest.approx(2.0, abs=2 * pixel)
    assert {left.header.frame_id, right.header.frame_id} == {
        "robot/head/stereo_left_optical_frame", "robot/head/stereo_right_optical_frame"
    }  # fmt: skip


def test_several_cameras_that_are_none_are_refused(read, golden: Golden):
    with golden.raises(SceneError):
        read(STEREO.format(cameras=""))


SONAR = "<sonar><min>0.1</min><max>2</max><radius>0.4</radius></sonar>"
ROS_RANGE = """<ray><scan><horizontal><samples>5</samples><min_angle>-0.2</min_angle>
<max_angle>0.2</max_angle></horizontal></scan><range><min>0.1</min><max>2</max></range></ray>
<plugin filename="libgazebo_ros_range.so"
name="p"><topicName>near</topicName><radiation>infrared</radiation><fov>0.4</fov></plugin>"""


@pytest.mark.parametrize(
    ("kind", "inner", "topic", "radiation", "cone"),
    [
        ("sonar", SONAR, "body/s/sonar", Range.ULTRASOUND, 2 * atan(0.2)),
        ("ray", ROS_RANGE, "near", Range.INFRARED, 0.4),
    ],
)
def test_a_range_is_the_shortest_distance_in_a_cone(
    open_world, advance, read, kind, inner, topic, radiation, cone
):
    """A plate is seen by the outer ray alone, a wall behind it by the others; a third thing is too far."""
    model = read(
        f'<static>1</static><link name="body"><sensor name="s" type="{kind}"><update_rate>50</update_rate>'
        f"{inner}</sensor></link>"
    )
    angle = cone / 2
    plate = Pose.from_rpy((cos(angle), sin(angle), 0.0), 0.0, 0.0, angle)
    things = {
        "plate": Model("plate", (solid(Box((0.02, 0.02, 1.0))),), pose=plate, static=True),
        "wall": Model("wall", (solid(Box((0.2, 4.0, 4.0))),), pose=Pose((1.6, 0.0, 0.0)), static=True),
        "far": Model("far", (solid(Box((0.2, 4.0, 4.0))),), pose=Pose((2.2, 0.0, 0.0)), static=True),
    }
    found = {}
    for names in (("plate", "wall"), ("wall",), ("far",)):
        world = open_world(Scene((model, *(things[name] for name in names))))
        found[names[0]] = sensed(world, f"/robot/{topic}", advance)
    assert found["plate"].range == pytest.approx(0.99, abs=1e-3)
    assert found["wall"].range == pytest.approx(1.5, abs=1e-3)
    assert found["far"].range == inf
    assert (found["wall"].min_range, found["wall"].max_range) == pytest.approx((0.1, 2.0))
    assert (found["wall"].radiation_type, found["wall"].field_of_view) == (radiation, pytest.approx(cone))


def solid(shape: Box) -> Link:
    return Link("l", collisions=(Collision("c", shape),))
