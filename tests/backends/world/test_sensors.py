"""What robots sense, on both engines: distances, depth, motion, contacts, loads in joints."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import asin, atan2, cos, hypot, inf, pi, sin, sqrt

import numpy as np
import pytest

from nrp_core.clock import SampleSchedule
from nrp_core.messages import point_cloud2
from nrp_core.messages.geometry_msgs import Pose as PoseMessage
from nrp_core.scene.devices import Noise
from nrp_core.scene.model import (
    Box,
    Capsule,
    Cylinder,
    Inertial,
    Joint,
    Link,
    Mesh,
    Model,
    Scene,
    Sphere,
)
from nrp_core.scene.rigid import Pose
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.contact import ContactSensor, ForceTorque
from nrp_core.world.sensors.ground_truth import GroundTruth
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.sensors.navigation import Imu
from nrp_core.world.sensors.sensor import with_imperfection

GRAVITY = 9.8


def carrier(*sensors, pose: Pose = Pose((0.0, 0.0, 0.5)), mass: float = 1.0) -> Model:
    """Return a small box that carries sensors; it is held where it is unless it has a mass."""
    body = Link(
        "link",
        inertial=Inertial(mass, inertia=(0.01, 0.01, 0.01, 0.0, 0.0, 0.0)),
        sensors=sensors,
    )
    return Model("carrier", (body,), pose=pose, static=not mass)


def fixed(*sensors, pose: Pose = Pose((0.0, 0.0, 0.5))) -> Model:
    return carrier(*sensors, pose=pose, mass=0.0)


def sense(world, topic: str, advance, seconds: float = 0.02):
    heard = world.subscribe(topic)
    advance(world, seconds)
    assert heard.latest is not None
    return heard.latest.message


# -- lasers

LASER = Laser("laser", "/scan", 50.0, samples=181, angle_min=-pi / 2, angle_max=pi / 2, range_max=8.0)


def test_a_laser_measures_the_distance_to_a_wall_in_every_direction(open_world, parts, advance):
    scan = sense(open_world(fixed(LASER), parts.wall(3.0)), "/scan", advance)
    angles = np.linspace(-pi / 2, pi / 2, 181)
    expected = np.full(181, inf)
    seen = np.abs(angles) < pi / 2 - 1e-9
    far = 3.0 / np.cos(angles[seen])
    side = np.abs(far * np.sin(angles[seen]))
    expected[seen] = np.where((side < 4.0) & (far < 8.0), far, inf)
    assert scan.ranges == pytest.approx(expected, abs=1e-5)
    right, step = float(np.float32(-pi / 2)), float(np.float32(pi / 180))  # as precise as a message is
    assert (scan.angle_min, scan.angle_max, scan.range_max) == (right, -right, 8.0)
    assert scan.angle_increment == step
    assert scan.header.frame_id == "carrier/link"


@pytest.mark.parametrize(
    ("shape", "distance"),
    [
        (Sphere(0.5), 1.5),
        (Box((1.0, 2.0, 1.0)), 1.5),
        (Cylinder(0.5, 2.0), 1.5),
        (Capsule(0.5, 1.0), 1.5),
    ],
)
def test_each_shape_is_met_where_it_begins(open_world, parts, advance, shape, distance):
    prop = parts.prop("thing", shape, Pose((2.0, 0.0, 0.5)))
    scan = sense(open_world(fixed(LASER), prop), "/scan", advance)
    assert scan.ranges[90] == pytest.approx(distance, abs=1e-5)


def test_a_mesh_is_met_at_its_triangles(open_world, parts, advance, tmp_path):
    mesh = tmp_path / "wedge.stl"
    corners = np.array([(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1), (0.2, 0, 0)], "<f4")
    faces = [(0, 1, 2), (0, 2, 3), (0, 4, 1), (1, 4, 2), (2, 4, 3), (3, 4, 0)]
    records = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("flags", "<u2")])
    records["corners"] = corners[np.array(faces)]
    mesh.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + records.tobytes())
    prop = parts.prop("thing", Mesh(mesh), Pose((2.0, 0.0, 0.5)))
    scan = sense(open_world(fixed(LASER), prop), "/scan", advance)
    assert scan.ranges[90] == pytest.approx(2.0, abs=1e-5)
    assert np.isfinite(scan.ranges).sum() == 2 * int(np.degrees(atan2(1.0, 2.0))) + 1


def test_points_of_a_scan_in_the_published_frame_are_on_the_wall(open_world, parts, advance):
    """The frame of the link would show the wall too near by 0.1 m."""
    mounted = replace(LASER, pose=Pose.from_rpy((-0.1, 0.2, 0.1), 0.0, 0.0, 0.3))
    scan = sense(open_world(fixed(mounted), parts.wall(3.0)), "/scan", advance)
    assert scan.header.frame_id == mounted.frame_on("carrier", "link") == "carrier/link/laser"
    angles = scan.angle_min + scan.angle_increment * np.arange(181)
    met = np.isfinite(scan.ranges)
    rays = [(r * cos(a), r * sin(a), 0.0) for r, a in zip(scan.ranges[met], angles[met], strict=True)]
    assert [(mounted.offset @ Pose(ray)).position[0] for ray in rays] == pytest.approx(
        [3.0] * met.sum(), abs=1e-4
    )


def test_a_laser_turns_with_its_robot_and_sees_what_moves(open_world, parts, advance):
    ball = parts.prop("ball", Sphere(0.5), Pose((0.0, 2.0, 0.5)), mass=1.0)
    turned = Pose.from_rpy((0.0, 0.0, 0.5), 0.0, 0.0, pi / 2)
    world = open_world(Scene((fixed(LASER, pose=turned), ball), gravity=(0.0, 0.0, 0.0)))
    assert sense(world, "/scan", advance).ranges[90] == pytest.approx(1.5, abs=1e-5)
    world.call("/gazebo/set_model_state", model_state=moved("ball", y=5.0))
    assert sense(world, "/scan", advance).ranges[90] == pytest.approx(4.5, abs=1e-5)


LIDAR = Laser(
    "lidar", "/scan", 50.0, samples=41, angle_min=-1.0, angle_max=1.0, range_max=6.0,
    pose=Pose.from_rpy((0.1, 0.0, 0.4), 0.0, 0.3, 0.0),
    layers=9, elevation_min=-0.6, elevation_max=0.6, points_topic="/points",
)  # fmt: skip


def test_a_lidar_sees_a_floor_and_a_wall_in_layers(open_world, parts, advance):
    floor = parts.prop("floor", Box((20.0, 20.0, 1.0)), Pose((0.0, 0.0, -0.5)))
    world = open_world(fixed(LIDAR, pose=Pose((0.5, 0.0, 0.5))), parts.wall(3.0), floor)
    cloud = sense(world, "/points", advance)
    assert (cloud.height, cloud.width, cloud.header.frame_id) == (9, 41, "carrier/link/lidar")
    points = point_cloud2.read_points(cloud)
    forward, y, up = (points[axis].astype(float) for axis in "xyz")  # the sensor looks down by 0.3 rad
    met = np.isfinite(forward)
    x = 0.1 + np.cos(0.3) * forward + np.sin(0.3) * up
    z = 0.4 - np.sin(0.3) * forward + np.cos(0.3) * up
    on_wall, on_floor = np.abs(x - 2.5) < 1e-5, np.abs(z + 0.5) < 1e-5
    assert (on_wall | on_floor == met).all()
    assert on_wall.sum() > 50 < on_floor.sum()
    assert np.abs(y[met]).max() > 1
    # each point lies where its layer looks, as the sensor's own frame has it
    level = np.hypot(forward, y)[met]
    elevations = np.arctan2(up[met], level)
    assert elevations == pytest.approx(np.linspace(-0.6, 0.6, 9)[points["ring"][met]], abs=1e-5)
    assert np.hypot(level, up[met]).max() <= 6.0


def test_the_scan_of_a_lidar_is_its_middle_layer(open_world, parts, advance):
    level = replace(LIDAR, pose=Pose(), noise=Noise(0.0, 0.05))
    world = open_world(fixed(level), parts.wall(3.0))
    points = world.subscribe("/points")
    ranges = sense(world, "/scan", advance).ranges
    middle = point_cloud2.read_points(points.latest.message, ("x", "y")).reshape(9, 41)[4]
    assert ranges[20] == pytest.approx(3.0, abs=0.3)
    assert np.hypot(middle["x"], middle["y"])[10:31] == pytest.approx(ranges[10:31], abs=1e-5)


def moved(name: str, *, x: float = 0.0, y: float = 0.0, z: float = 0.5):
    from nrp_core.messages.gazebo_msgs import ModelState

    pose = PoseMessage()
    pose.position.x, pose.position.y, pose.position.z = x, y, z
    return ModelState(name, pose)


def test_a_near_obstacle_blocks_a_laser_and_its_own_body_does_not(open_world, parts, advance):
    near = replace(LASER, range_min=1.0)
    model = fixed(near)
    box = parts.prop("shell", Box((0.4, 0.4, 0.4))).links[0]
    model = replace(model, links=(replace(model.links[0], collisions=box.collisions),))
    near = replace(near, noise=Noise(0.05, 0.1), topic="/noisy", name="noisy")
    sensors = (*model.links[0].sensors, near)
    model = replace(model, links=(replace(model.links[0], sensors=sensors),))
    world = open_world(model, parts.prop("ball", Sphere(0.1), Pose((0.6, 0.0, 0.5))), parts.wall(3.0))
    ranges, noisy = sense(world, "/scan", advance).ranges, sense(world, "/noisy", advance).ranges
    # REP 117: -inf is an object too close to measure; the ball of 0.1 m covers asin(0.1 / 0.6) to each side
    blocked = np.abs(np.linspace(LASER.angle_min, LASER.angle_max, len(ranges))) < asin(0.1 / 0.6)
    assert blocked.sum() == 19
    assert (ranges[blocked] == -inf).all()
    assert (noisy[blocked] == -inf).all()
    free = open_world(model, parts.wall(3.0))
    assert ranges[~blocked] == pytest.approx(sense(free, "/scan", advance).ranges[~blocked], abs=1e-5)
    assert sense(free, "/scan", advance).ranges[90] == pytest.approx(3.0, abs=1e-5)


def test_noise_has_its_spread_and_is_the_same_in_equal_runs(open_world, parts, advance):
    noisy = replace(LASER, noise=Noise(0.05, 0.1), angle_min=-0.3, angle_max=0.3, samples=2000)
    one, again, other = (
        sense(open_world(fixed(noisy), parts.wall(3.0), seed=seed), "/scan", advance).ranges
        for seed in (1, 1, 2)
    )
    error = one - 3.0 / np.cos(np.linspace(-0.3, 0.3, 2000))
    assert error.mean() == pytest.approx(0.05, abs=0.01)
    assert error.std() == pytest.approx(0.1, rel=0.06)
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


# -- depth and optics


def test_a_depth_camera_sees_how_far_away_things_are(open_world, parts, advance):
    camera = Camera(
        "camera", "/color", 50.0, pi / 2, 32, 24, depth_topic="/depth", info_topic="/info", far=20.0
    )
    world = open_world(fixed(camera), parts.wall(3.0), parts.prop("ball", Sphere(0.5), Pose((2.0, 0.0, 0.5))))
    depth = sense(world, "/depth", advance)
    assert (depth.encoding, depth.height, depth.width, depth.step) == ("32FC1", 24, 32, 128)
    assert depth.data.dtype == np.float32
    assert depth.data[12, 16] == pytest.approx(1.5, abs=0.02)
    assert depth.data[12, 2] == pytest.approx(3.0, abs=1e-4)  # along the line of sight, as far at the edges
    assert depth.data[0, 16] == inf  # over the wall
    info = sense(world, "/info", advance)
    assert (info.width, info.height) == (32, 24)
    assert info.k.reshape(3, 3) == pytest.approx(np.array([[16.0, 0, 16], [0, 16.0, 12], [0, 0, 1]]))


def test_nothing_is_seen_beyond_the_clip_distances(open_world, parts, advance):
    for near, far in ((0.1, 2.5), (3.5, 20.0)):
        camera = Camera("camera", "/color", 50.0, pi / 2, 32, 24, near, far, depth_topic="/depth")
        depth = sense(open_world(fixed(camera), parts.wall(3.0)), "/depth", advance)
        assert not np.isfinite(depth.data).any()


def test_images_have_noise(open_world, parts, advance):
    plain = Camera("camera", "/color", 50.0, pi / 2, 64, 48)
    clean, noisy = (
        sense(open_world(fixed(camera), parts.wall(3.0)), "/color", advance).data.astype(float)
        for camera in (plain, replace(plain, noise=Noise(0.0, 0.02)))
    )
    assert (noisy - clean).std() == pytest.approx(0.02 * 255, rel=0.05)
    assert abs((noisy - clean).mean()) < 0.3


# -- motion


def imu(**keys) -> Imu:
    return Imu("imu", "/imu", 100.0, **keys)


def vector(message) -> tuple[float, float, float]:
    return message.x, message.y, message.z


def test_at_rest_an_imu_feels_gravity_upwards(open_world, parts, advance):
    box = parts.prop("box", Box((0.2, 0.2, 0.2)), Pose((0.0, 0.0, 0.1)), mass=1.0)
    box = replace(
        box, links=(replace(box.links[0], sensors=(imu(pose=Pose.from_rpy((0, 0, 0), pi / 2, 0, 0)),)),)
    )
    world = open_world(parts.floor(), box)
    advance(world, 1.0)
    message = sense(world, "/imu", advance, 0.04)
    assert vector(message.linear_acceleration) == pytest.approx((0.0, GRAVITY, 0.0), abs=0.02)
    assert vector(message.angular_velocity) == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_its_turn_rates_and_accelerations_have_noise_of_their_own(open_world, advance):
    noisy = imu(noise=Noise(0.0, 0.5), turn_noise=Noise(0.0, 0.01))
    everywhere = with_imperfection(Scene((carrier(noisy),)), "/imu", noise=Noise(0.0, 2.0))
    for scene, deviations in ((Scene((carrier(noisy),)), (0.01, 0.5)), (everywhere, (2.0, 2.0))):
        world = open_world(replace(scene, gravity=(0.0, 0.0, 0.0)))
        heard = world.subscribe("/imu", depth=500)
        advance(world, 4.0)
        read = [stamped.message for stamped in heard.since(-1)]
        turns = np.array([vector(one.angular_velocity) for one in read])
        felt = np.array([vector(one.linear_acceleration) for one in read])
        assert (turns.std(), felt.std()) == pytest.approx(deviations, rel=0.1)


def test_in_free_fall_it_feels_nothing(open_world, advance):
    world = open_world(carrier(imu(), pose=Pose((0.0, 0.0, 50.0))))
    message = sense(world, "/imu", advance, 0.2)
    assert vector(message.linear_acceleration) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_away_from_the_axis_it_feels_the_turn(open_world, advance):
    turn, radius = 3.0, 0.4
    spinning = Scene((carrier(imu(pose=Pose((radius, 0.0, 0.0)))),), gravity=(0.0, 0.0, 0.0))
    world = open_world(spinning)
    from nrp_core.messages.gazebo_msgs import ModelState
    from nrp_core.messages.geometry_msgs import Twist, Vector3

    state = ModelState("carrier", PoseMessage(), Twist(Vector3(), Vector3(0.0, 0.0, turn)))
    world.call("/gazebo/set_model_state", state)
    message = sense(world, "/imu", advance, 0.5)
    assert vector(message.angular_velocity) == pytest.approx((0.0, 0.0, turn), abs=1e-3)
    felt = message.linear_acceleration
    assert hypot(felt.x, felt.y) == pytest.approx(turn**2 * radius, rel=0.01)
    assert felt.x < 0


def test_an_imu_goes_on_from_a_snapshot(open_world, parts, advance):
    def opened():
        world = open_world(parts.floor(), carrier(imu()), parts.husky(pose=Pose((2.0, 0, parts.standing))))
        return world, world.subscribe("/imu", depth=100)

    world, heard = opened()
    advance(world, 0.1)
    snapshot = world.snapshot()
    advance(world, 0.1)
    expected = heard.since(-1)
    fresh, again = opened()
    fresh.restore(snapshot)
    advance(fresh, 0.1)
    assert [repr(stamped) for stamped in again.since(-1)] == [repr(stamped) for stamped in expected]


def test_the_true_pose_is_that_of_the_link(open_world, advance):
    offset = Pose((0.3, 0.0, 0.0))
    truth = GroundTruth("p3d", "/truth", 50.0, offset)
    world = open_world(carrier(truth, pose=Pose.from_rpy((1.0, 2.0, 30.0), 0.0, 0.0, pi / 2)))
    message = sense(world, "/truth", advance, 0.2)
    expected = (world.model_motion("carrier").pose @ offset).position
    assert vector(message.pose.pose.position) == pytest.approx(expected, abs=1e-9)
    assert vector(message.twist.twist.linear) == pytest.approx((0.0, 0.0, -GRAVITY * 0.2), rel=1e-3)
    assert message.header.frame_id == "world"


def test_link_states_list_every_link(open_world, parts, advance):
    world = open_world(parts.floor(), parts.husky())
    advance(world, 0.1)
    latest = world.subscribe("/gazebo/link_states").latest
    states = dict(zip(latest.message.name, latest.message.pose, strict=True))
    assert list(states)[:3] == ["floor::link", "husky::base_link", "husky::eye"]
    base = world.model_motion("husky").pose
    eye = (base @ Pose((-0.16, 0.0, 0.36))).position
    assert vector(states["husky::eye"].position) == pytest.approx(eye, abs=1e-9)
    wheel = states["husky::front_left_wheel"].position
    assert vector(wheel) == pytest.approx((base @ Pose((0.256, 0.2855, 0.035))).position, abs=1e-4)


# -- contacts and loads


def resting(parts, mass: float = 2.0) -> tuple[Model, ...]:
    box = parts.prop("box", Box((0.4, 0.4, 0.2)), Pose((0.0, 0.0, 0.1)), mass=mass)
    bumper = ContactSensor("bumper", "/bumper", 50.0)
    return parts.floor(), replace(box, links=(replace(box.links[0], sensors=(bumper,)),))


def test_a_contact_names_both_bodies_and_the_force(open_world, parts, advance):
    world = open_world(*resting(parts))
    advance(world, 1.0)
    (state,) = sense(world, "/bumper", advance).states
    assert (state.collision1_name, state.collision2_name) == (
        "box::link::collision",
        "floor::link::collision",
    )
    assert vector(state.total_wrench.force) == pytest.approx((0.0, 0.0, 2.0 * GRAVITY), abs=0.1)
    assert all(normal.z == pytest.approx(1.0, abs=1e-3) for normal in state.contact_normals)
    assert all(abs(point.z) < 0.01 for point in state.contact_positions)
    assert len(state.contact_positions) == len(state.depths) >= 2


def test_all_contacts_of_a_world_are_reported_each_pair_of_shapes_once(open_world, parts, advance):
    floor, box = resting(parts)
    other = replace(box, name="a_box", pose=Pose((2.0, 0.0, 0.1)), links=(replace(box.links[0], sensors=()),))
    high = replace(other, name="high", pose=Pose((-2.0, 0.0, 50.0)))
    world = open_world(floor, box, other, high)
    advance(world, 1.0)
    state = sense(world, "/gazebo/contact_point_data", advance)
    pairs = [(each.collision1_name, each.collision2_name) for each in state.states]
    assert pairs == [
        ("a_box::link::collision", "floor::link::collision"),
        ("box::link::collision", "floor::link::collision"),
    ]
    for each in state.states:
        assert vector(each.total_wrench.force) == pytest.approx((0.0, 0.0, 2.0 * GRAVITY), abs=0.1)


def test_a_load_cell_without_contact_measures_nothing(open_world, parts, advance):
    floor, box = resting(parts)
    world = open_world(floor, replace(box, pose=Pose((0.0, 0.0, 3.0))))
    assert sense(world, "/bumper", advance).states == []


def test_of_several_shapes_the_one_that_touches_is_named(open_world, parts, advance):
    floor, box = resting(parts)
    (link,) = box.links
    foot = replace(link.collisions[0], name="foot", geometry=Sphere(0.05), pose=Pose((0.0, 0.0, -0.3)))
    world = open_world(
        floor,
        replace(box, pose=Pose((0, 0, 0.36)), links=(replace(link, collisions=(*link.collisions, foot)),)),
    )
    heard = world.subscribe("/bumper", depth=100)
    advance(world, 0.3)
    named = [state.collision1_name for stamped in heard.since(-1) for state in stamped.message.states]
    assert named[0] == "box::link::foot"


def test_a_force_sensor_weighs_what_hangs_on_it(open_world, advance):
    sensor = ForceTorque("ft", "/ft", 50.0, "wrist")
    upper = Link("upper", inertial=Inertial(1.0, inertia=(0.01, 0.01, 0.01, 0, 0, 0)))
    hand = Link(
        "hand",
        Pose((0.2, 0.0, 0.0)),
        Inertial(3.0, Pose((0.1, 0.0, 0.0)), (0.01, 0.01, 0.01, 0, 0, 0)),
        sensors=(sensor,),
    )
    for kind in ("fixed", "revolute"):
        joints = (
            Joint("mount", "revolute", "world", "upper", axis=(0.0, 1.0, 0.0), lower=0.0, upper=0.0),
            Joint("wrist", kind, "upper", "hand", Pose((0.2, 0.0, 0.0)), (1.0, 0.0, 0.0)),
        )
        world = open_world(Model("arm", (upper, hand), joints, pose=Pose((0.0, 0.0, 2.0))))
        message = sense(world, "/ft", advance, 2.0)
        assert vector(message.wrench.force) == pytest.approx((0.0, 0.0, -3.0 * GRAVITY), abs=0.3)
        assert vector(message.wrench.torque) == pytest.approx((0.0, 0.1 * 3.0 * GRAVITY, 0.0), abs=0.05)


# -- rates, delays, losses


@pytest.mark.parametrize("rate", [30.0, 33.3, 400.0, 7.0])
def test_samples_come_at_the_first_step_after_they_are_due(open_world, parts, advance, rate):
    world = open_world(fixed(replace(LASER, rate_hz=rate)), parts.wall(2.0))
    heard = world.subscribe("/scan", depth=1000)
    advance(world, 1.0)
    schedule = SampleSchedule(Fraction(str(rate)), world.capabilities.step_ns)
    stamps = [stamped.message.header.stamp.to_ns() for stamped in heard.since(-1)]
    assert stamps == [schedule.sample_ns(k) for k in range(int(rate) + 1)]


def test_a_delayed_message_arrives_later_with_the_stamp_of_its_measurement(open_world, parts, advance):
    world = open_world(fixed(replace(LASER, delay=0.07, rate_hz=50.0)), parts.wall(2.0))
    heard = world.subscribe("/scan", depth=100)
    advance(world, 0.06)
    assert heard.latest is None
    advance(world, 0.04)
    arrived = heard.since(-1)
    assert [stamped.message.header.stamp.to_ns() for stamped in arrived] == [0, 20_000_000]
    assert [stamped.t_ns for stamped in arrived] == [70_000_000, 90_000_000]
    snapshot = world.snapshot()
    advance(world, 0.04)
    expected = [stamped.t_ns for stamped in heard.since(-1)]
    world.restore(snapshot)
    advance(world, 0.04)
    assert [stamped.t_ns for stamped in heard.since(-1)] == expected


def test_the_share_of_messages_that_get_lost_is_as_declared(open_world, parts, advance):
    world = open_world(fixed(replace(LASER, drop_out=0.3, rate_hz=500.0, samples=1)), parts.wall(2.0))
    heard = world.subscribe("/scan", depth=10_000)
    advance(world, 4.0)
    assert len(heard.since(-1)) / 2001 == pytest.approx(0.7, abs=4 * sqrt(0.21 / 2001))


def test_a_sensor_without_a_reader_does_not_measure(open_world, parts, advance, monkeypatch):
    world = open_world(fixed(LASER), parts.wall(2.0))
    monkeypatch.setattr(world.engine, "_collisions", lambda: pytest.fail("a scan was made"))
    advance(world, 0.2)


def test_all_sensors_of_a_moving_robot_agree(open_world, parts, driver, advance):
    """A laser, the true pose and odometry tell one story of the way to a wall."""
    husky = parts.husky()
    eye = replace(
        husky.links[1], sensors=(*husky.links[1].sensors, LASER, GroundTruth("p3d", "/truth", 50.0))
    )
    world = open_world(
        parts.floor(), parts.wall(4.0), replace(husky, links=(husky.links[0], eye, *husky.links[2:]))
    )
    scans, truths = world.subscribe("/scan", depth=500), world.subscribe("/truth", depth=500)
    driver(world).drive(0.6, 0.1, 1.0)
    for scan, truth in zip(scans.since(-1), truths.since(-1), strict=True):
        q = truth.message.pose.pose.orientation
        yaw = Pose(orientation=(q.x, q.y, q.z, q.w)).yaw
        ahead = (4.0 - truth.message.pose.pose.position.x) / cos(yaw)
        assert scan.message.ranges[90] == pytest.approx(ahead, abs=2e-3)
        assert abs(sin(yaw)) < 0.2
