"""Sensors, from SDF's ``<sensor>`` (URDF carries the same inside ``<gazebo>``)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from math import pi
from posixpath import join

from nrp_core.world.scene.model import Camera, Sensor
from nrp_core.world.scene.plugins import plugin_name, ros_namespace, warn_of_plugin
from nrp_core.world.scene.pose import Pose
from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.xml_tree import Element
from nrp_core.world.topics import resolve_name

DEFAULT_RATE_HZ = 30.0

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
        if kind == "camera":
            yield _camera(sensor, link, reading, place)
        else:
            reading.notes.warn(sensor, f"sensors of type '{kind}' are not simulated")


def _camera(sensor: Element, link: str, reading: Reading, place: Callable[[Element], Pose]) -> Camera:
    camera = sensor.require("camera")
    fov = camera.positive("horizontal_fov", 1.047)
    if fov >= pi:
        raise camera.error(f"a flat picture has a <horizontal_fov> below pi, not {fov:g}")
    width, height = _size(camera.section("image"), reading)
    near, far = _clip(camera.section("clip"))
    for tag in ("noise", "distortion"):
        if camera.find(tag):
            reading.notes.warn(camera, f"the <{tag}> of cameras is not simulated")
    return Camera(
        sensor.attribute("name"),
        _topic(sensor, link, reading),
        _rate(sensor, reading),
        fov,
        width,
        height,
        near,
        far,
        place(sensor) @ place(camera),
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


def _rate(sensor: Element, reading: Reading) -> float:
    rate_hz = sensor.number("update_rate", 0.0)
    if rate_hz > 0:
        return rate_hz
    name = sensor.attribute("name")
    reading.notes.warn(sensor, f"the sensor '{name}' has no <update_rate>: {DEFAULT_RATE_HZ:g} Hz are taken")
    return DEFAULT_RATE_HZ


def _topic(sensor: Element, link: str, reading: Reading) -> str:
    """Return the topic that the ROS plugin names, else the one of the sensor, else Gazebo's default."""
    default = f"{link}/{sensor.attribute('name')}/image".replace("::", "/")
    topic = sensor.word("topic", default)
    for plugin in sensor.all("plugin"):
        if plugin_name(plugin) == _CAMERA_PLUGIN:
            camera = plugin.word("cameraName") or plugin.word("camera_name") or sensor.attribute("name")
            topic = join(ros_namespace(plugin), camera, plugin.word("imageTopicName", "image_raw"))
        else:
            warn_of_plugin(plugin, reading)
    return resolve_name(topic, reading.robot)
