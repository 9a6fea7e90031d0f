"""Measurements are where they were made: each, carried along the published tree, meets the wall it saw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from golden import Golden

from nrp_core.messages import point_cloud2
from nrp_core.recording.writing.frames import SceneFrames
from nrp_core.scene.model import Box, Model, Scene
from nrp_core.scene.rigid import Pose

WALL_X, EDGE_Y = 2.5, 0.3
START = Pose.from_rpy((0.4, -0.1, 0.6), 0.05, -0.1, 0.2)
LENS = "<horizontal_fov>1.2</horizontal_fov><image><width>80</width><height>60</height></image>"
KINECT = (
    '<plugin name="k" filename="libgazebo_ros_openni_kinect.so"><cameraName>kinect</cameraName>'
    "<frameName>depth_optical</frameName></plugin>"
)
ROBOT = f"""
<link name="base"><inertial><mass>5</mass></inertial></link>
<link name="base_scan"><pose>0.1 0 0.1 0 0 0</pose><inertial/>
  <sensor name="lds" type="ray"><pose>-0.064 0 0.05 0 0 0.1</pose><update_rate>50</update_rate>
    <ray><scan><horizontal><samples>61</samples><min_angle>-0.5</min_angle><max_angle>0.5</max_angle>
    </horizontal><vertical><samples>3</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle>
    </vertical></scan><range><min>0.1</min><max>9</max></range></ray>
    <plugin name="l" filename="libgazebo_ros_laser.so"><topicName>scan</topicName>
      <frameName>base_scan</frameName></plugin></sensor></link>
<link name="head"><pose>0.2 0.1 0.3 0 0.1 -0.1</pose><inertial/>
  <sensor name="cam" type="camera"><update_rate>50</update_rate><topic>seen/image</topic>
    <camera>{LENS}<optical_frame_id>head_optical</optical_frame_id></camera></sensor>
  <sensor name="kinect" type="depth"><pose>0 0.05 0 0 0 0.1</pose><update_rate>50</update_rate>
    <camera>{LENS}</camera>{KINECT}</sensor></link>
<link name="head_optical"><pose relative_to="head">0 0 0 -1.57 0 -1.57</pose></link>
<joint name="a" type="fixed"><parent>base</parent><child>base_scan</child></joint>
<joint name="b" type="fixed"><parent>base</parent><child>head</child></joint>
<joint name="c" type="fixed"><parent>head</parent><child>head_optical</child></joint>
"""


@pytest.fixture
def robot(read) -> Model:
    return replace(read(ROBOT), pose=START)


@pytest.fixture
def told(robot, open_world, parts, advance):
    """Return a function from topics to their message and the pose of its frame, as it is published."""
    half = 4.0
    walls = [
        parts.prop(
            name, Box((0.2, half, 8.0)), Pose((WALL_X + 0.1, EDGE_Y + side * half / 2, 0.0)), rgba=color
        )
        for name, side, color in (("left", 1, (1.0, 0.0, 0.0, 1.0)), ("right", -1, (0.0, 0.0, 1.0, 1.0)))
    ]
    world = open_world(Scene((robot, *walls), gravity=(0.0, 0.0, 0.0)))
    topics = ("scan", "base_scan/lds/scan/points", "seen/image", "seen/camera_info")
    topics += tuple(f"kinect/{name}" for name in ("image_raw", "camera_info", "depth/image_raw", "points"))
    heard = {topic: world.subscribe(f"/robot/{topic}") for topic in topics}
    advance(world, 0.02)
    frames = SceneFrames(world).now
    poses = dict(zip(frames.names, frames.poses().tolist(), strict=True))

    def told(topic: str):
        message = heard[topic].latest.message
        *place, x, y, z, w = poses[message.header.frame_id]
        return message, Pose(tuple(place), (x, y, z, w))

    return told


def in_world(pose: Pose, points: np.ndarray) -> np.ndarray:
    turn = np.array([pose.rotate(axis) for axis in np.eye(3).tolist()]).T
    return points @ turn.T + pose.position


def rays(info, points: np.ndarray) -> np.ndarray:
    """Return the directions of places in an image, in pixels from its upper left corner."""
    places = np.column_stack([points, np.ones(len(points))])
    return places @ np.linalg.inv(info.k.reshape(3, 3)).T


def test_scans_and_points_of_a_laser_are_on_the_wall(told):
    scan, frame = told("scan")
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ends = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))]) * scan.ranges[:, None]
    assert in_world(frame, ends)[:, 0] == pytest.approx(np.full(61, WALL_X), abs=1e-4)
    cloud, frame = told("base_scan/lds/scan/points")
    points = point_cloud2.read_points(cloud)
    found = in_world(frame, np.column_stack([points[axis] for axis in "xyz"]))
    assert found[:, 0] == pytest.approx(np.full(3 * 61, WALL_X), abs=1e-4)


@pytest.mark.parametrize("camera", ["seen/image", "kinect/image_raw"])
def test_rays_through_the_edge_in_an_image_meet_the_edge_of_the_wall(told, camera):
    image, frame = told(camera)
    info, _ = told(f"{camera.rpartition('/')[0]}/camera_info")
    assert (info.header.frame_id, info.width, info.height) == (
        image.header.frame_id,
        image.width,
        image.height,
    )
    assert info.p.reshape(3, 4)[:, :3] == pytest.approx(info.k.reshape(3, 3))
    assert not info.d.any()
    red = image.data[..., 0] > 128
    edges = np.column_stack([red.sum(axis=1), np.arange(len(red)) + 0.5])  # red is on the left
    ends = in_world(Pose(orientation=frame.orientation), rays(info, edges))
    share = (WALL_X - frame.position[0]) / ends[:, 0]
    pixel_m = WALL_X / info.k[0]
    assert frame.position[1] + share * ends[:, 1] == pytest.approx(np.full(60, EDGE_Y), abs=pixel_m)


def test_depths_and_their_points_are_on_the_wall(told):
    depth, frame = told("kinect/depth/image_raw")
    info, _ = told("kinect/camera_info")
    rows, columns = np.indices((60, 80)).reshape(2, -1) + 0.5
    points = rays(info, np.column_stack([columns, rows])) * depth.data.reshape(-1, 1)
    assert in_world(frame, points)[:, 0] == pytest.approx(np.full(4800, WALL_X), abs=1e-4)
    cloud, frame = told("kinect/points")
    found = point_cloud2.read_points(cloud)
    assert np.column_stack([found[axis] for axis in "xyz"]) == pytest.approx(points, abs=1e-4)
    image, _ = told("kinect/image_raw")
    packed = found["rgb"].view("<u4").reshape(60, 80)
    assert (np.stack([packed >> 16, packed >> 8, packed], -1) % 256 == image.data).all()


def test_frames_have_the_names_in_the_file_unless_they_are_elsewhere(told, robot, golden: Golden):
    assert told("seen/image")[0].header.frame_id == "robot/head_optical"
    assert told("kinect/points")[0].header.frame_id == "robot/depth_optical"
    assert told("scan")[0].header.frame_id == "robot/base_scan/lds"
    (warning,) = (each for each in robot.warnings if each.code.name == "NRP266")
    assert "'base_scan'" in warning.message
    golden(warning.message)
