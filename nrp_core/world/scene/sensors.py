"""Sensors, from SDF's ``<sensor>`` (URDF carries the same inside ``<gazebo>``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import pi
from posixpath import join

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Camera, Sensor
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name, ros_namespace, warn_of_plugin
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensor_kinds import read_contact, read_imu, read_laser
from nrp_core.world.scene.sensor_parts import noise_of, rate_of
from nrp_core.world.topics import resolve_name

_COLOR_FORMATS = ("", "R8G8B8", "RGB_INT8", "B8G8R8", "BGR_INT8")
_CAMERA_PLUGIN = "gazebo_ros_camera"


def read_sensors(
    sensors: Iterable[Element], link: str, reading: Reading, place: Callable[[Element], Pose]
) -> Iterator[Sensor]:
    """Read the sensors of one link; those that cannot be simulated are warned of and left out.

    Args:
        sensors: the ``<sensor>`` elements.
        link: name of the link.
        reading: what is carried along.
        place: returns the pose of an element in the frame of the link.
    """
    seen: set[str] = set()
    for sensor in sensors:
        name, kind = sensor.attribute("name"), sensor.attribute("type")
        if name in seen:
            raise sensor.error(f"the link '{link}' has two sensors named '{name}'")
        seen.add(name)
        read = _KINDS.get(kind)
        if read is not None:
            yield read(sensor, link, reading, place)
        elif kind != "force_torque":  # those belong to joints
            reading.notes.warn(sensor, f"sensors of type '{kind}' are not simulated")


def _camera(sensor: Element, link: str, reading: Reading, place: Callable[[Element], Pose]) -> Camera:
    camera = sensor.require("camera")
    fov = camera.positive("horizontal_fov", 1.047)
    if fov >= pi:
        raise camera.error(f"a flat picture has a <horizontal_fov> below pi, not {fov:g}")
    width, height = _size(camera.section("image"), reading)
    near, far = _clip(camera.section("clip"))
    if camera.find("distortion"):
        reading.notes.warn(camera, "the <distortion> of cameras is not simulated")
    topic, depth, info = _topics(sensor, link, reading)
    return Camera(
        sensor.attribute("name"),
        topic,
        rate_of(sensor, reading),
        fov,
        width,
        height,
        near,
        far,
        place(sensor) @ place(camera),
        depth,
        info,
        noise=noise_of(camera, reading),
    )


def _size(image: Element, reading: Reading) -> tuple[int, int]:
    if image.word("format") not in _COLOR_FORMATS:
        reading.notes.warn(image, f"pictures are RGB, not {image.word('format')}")
    width, height = image.positive("width", 320), image.positive("height", 240)
    if width != int(width) or height != int(height):
        raise image.error(f"a picture has a whole number of pixels, not {width:g} x {height:g}")
    return int(width), int(height)


def _clip(clip: Element) -> tuple[float, float]:
    near, far = clip.positive("near", 0.1), clip.positive("far", 100.0)
    if near >= far:
        raise clip.error(f"the near clip distance ({near:g} m) must be below the far one ({far:g} m)")
    return near, far


def _topics(sensor: Element, link: str, reading: Reading) -> tuple[str, str | None, str | None]:
    """Return the topics of pictures, depth and optics: those that the ROS plugin names, else Gazebo's."""
    name, deep = sensor.attribute("name"), sensor.attribute("type") in _DEPTH
    picture = sensor.word("topic", reading.topic_of(link, f"{name}/image"))
    depth = f"{picture.removesuffix('/image')}/depth_image" if deep else ""
    info = ""
    for plugin in sensor.all("plugin"):
        kind = plugin_name(plugin)
        if kind in (_CAMERA_PLUGIN, *_DEPTH_PLUGINS):
            camera = plugin.word("cameraName") or plugin.word("camera_name") or name
            base = join(ros_namespace(plugin), camera)
            picture = join(base, plugin.word("imageTopicName", "image_raw"))
            info = join(base, plugin.word("cameraInfoTopicName", "camera_info"))
            if deep or kind in _DEPTH_PLUGINS:
                depth = join(base, plugin.word("depthImageTopicName", "depth/image_raw"))
        else:
            warn_of_plugin(plugin, reading)
    deep_topic, info_topic = (resolve_name(each, reading.robot) if each else None for each in (depth, info))
    return resolve_name(picture, reading.robot), deep_topic, info_topic


_DEPTH = ("depth", "depth_camera", "rgbd", "rgbd_camera")
_DEPTH_PLUGINS = ("gazebo_ros_openni_kinect", "gazebo_ros_depth_camera")
_KINDS: dict[str, Callable[[Element, str, Reading, Callable[[Element], Pose]], Sensor]] = {
    "camera": _camera,
    **dict.fromkeys(_DEPTH, _camera),
    **dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), read_laser),
    "imu": read_imu,
    "contact": read_contact,
}
