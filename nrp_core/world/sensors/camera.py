"""Cameras: images, depth, points and segments, and the base of sensors that compute on images."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from math import atan, tan
from posixpath import basename, dirname, join
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.messages.point_cloud2 import create_cloud
from nrp_core.messages.sensor_msgs import CameraInfo, Image, PointCloud2
from nrp_core.messages.std_msgs import Bool, Header
from nrp_core.scene.devices import ANY_CAMERA, LATER, View, set_fields
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import plugin_name, remapped_topic, ros_namespace, warn_of_plugin
from nrp_core.scene.reading.sensors import Mount, bit_mask, field_of_view, noise_of, rate_of
from nrp_core.scene.rigid import Pose
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import DepthArray, ImageArray, SegmentArray, Sight
from nrp_core.world.render.seen_image import SeenImage
from nrp_core.world.sensors.sensor import Sensor, SensorPart
from nrp_core.world.topics import Direction, Stamped, TopicInfo

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("rgb", "<f4")])
"""A point in the frame of the images, and its colour, whose bytes are those of the number 0xRRGGBB."""


def cloud_of(header: Header, depth: DepthArray, image: ImageArray, focal: float) -> PointCloud2:
    """Return a row of points for each row of an image; NaN where the camera sees nothing.

    Args:
        header: their time and frame.
        depth: shape ``(height, width)``, m.
        image: of the same size.
        focal: focal length, pixels.
    """
    height, width = depth.shape
    points = np.zeros(depth.shape, POINT)
    ahead = np.where(np.isfinite(depth), depth, np.nan)
    points["x"] = (np.arange(width) + 0.5 - width / 2) / focal * ahead
    points["y"] = ((np.arange(height) + 0.5 - height / 2) / focal)[:, None] * ahead
    points["z"] = ahead
    red, green, blue = (image[..., channel].astype("<u4") for channel in range(3))
    points["rgb"] = (red << 16 | green << 8 | blue).view("<f4")
    return create_cloud(header, points)


_SLACK = 0.01
"""How much pixels may differ from squares without a warning."""
_DEPTH_FORMATS = ("R_FLOAT32", "FLOAT32")
_COLOR_FORMATS = ("", "R8G8B8", "RGB_INT8", "B8G8R8", "BGR_INT8")
_MOST_PIXELS = 2**28
"""An image of more takes over 1 GB as depth, and several times that in a renderer."""
_CAMERA_PLUGIN, _STEREO_PLUGIN = "gazebo_ros_camera", "gazebo_ros_multicamera"
_OPTICAL = Pose(orientation=(-0.5, 0.5, -0.5, 0.5))
"""The frame of images in that of a camera: z ahead, x right, y down (REP 103 of ROS)."""
_BENT = ("k1", "k2", "k3", "p1", "p2")
_DEPTH_ALONE = ("depth", "depth_camera")
"""The types of cameras whose images are depths: Gazebo has these on the topic of the sensor."""
_DEPTH = (*_DEPTH_ALONE, "rgbd", "rgbd_camera")
_WIDE = ("type", "scale_to_hfov", "custom_function", "cutoff_angle", "env_texture_size")
"""The elements of a ``<lens>`` that only a wide-angle camera has."""
_DEPTH_PLUGINS = ("gazebo_ros_openni_kinect", "gazebo_ros_depth_camera")


@dataclass(frozen=True, slots=True)
class Camera(Sensor):
    """A colour camera that looks along x of its pose, z up; with a ``depth_topic`` it also measures depth.

    Args:
        name: the name of the sensor.
        topic: absolute topic of its images.
        rate_hz: images per second.
        horizontal_fov: horizontal field of view, rad.
        width, height: size of the image, pixels.
        near, far: clip distances, m.
        depth_topic: absolute topic of its depth images, None for none.
        info_topic: absolute topic of its optics, None for none.
        points_topic: absolute topic of the points that it sees, None for none.
        baseline: of the right camera of a pair, its distance from the left one (m), which its ``P`` holds.
        projection: x and y of the focal lengths, the centre and the translation in ``P``, pixels, if they
            replace those of the lens.
        mask: bits; it sees the visuals whose flags share one.
        trigger_topic: absolute topic; each true message triggers an image. Empty for images at a rate.
    """

    tag: ClassVar[str] = "camera"
    frame_suffix: ClassVar[str] = "_optical_frame"

    needs: ClassVar[tuple[str, ...]] = ("renderers",)

    horizontal_fov: float
    width: int
    height: int
    near: float = 0.1
    far: float = 100.0
    pose: Pose = Pose()
    depth_topic: str | None = None
    info_topic: str | None = None
    points_topic: str | None = field(default=None, metadata=LATER)
    baseline: float = field(default=0.0, metadata=LATER)
    projection: tuple[float, ...] = field(default=(), kw_only=True, metadata=LATER)
    mask: int = field(default=ANY_CAMERA, kw_only=True, metadata=LATER)
    trigger_topic: str = field(default="", kw_only=True, metadata=LATER)

    __setstate__ = set_fields

    @property
    def offset(self) -> Pose:
        return self.pose @ _OPTICAL

    @property
    def view(self) -> View:
        """The images that it consists of."""
        lens = self.horizontal_fov, self.width, self.height, self.near, self.far
        return View(self.pose, *lens, self.mask)

    def focal(self, width: int) -> float:
        """Return the focal length in pixels of images of a width."""
        return width / 2 / tan(self.horizontal_fov / 2)

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading, fov: float | None = None) -> Camera:
        """Read a ``<sensor>`` with a ``<camera>``; ``fov`` (rad) replaces the field of view in the file."""
        camera = sensor.require("camera")
        width, height = _size(sensor, camera.section("image"), reading)
        is_deep = sensor.attribute("type") in _DEPTH_ALONE
        own = camera.section("depth_camera").find("clip") if is_deep else None
        if fov is None:
            camera.section("lens").pass_over(*_WIDE)
            fov = _field_of(camera, width, height, reading)
        near, far = _clip(own or camera.section("clip"))
        given = [each for each in camera.section("distortion").all(*_BENT) if each.text.strip("+-0. ")]
        if given:
            names = ", ".join(f"<{each.tag}>" for each in given)
            message = f"the <distortion> of cameras is not simulated ({names})"
            reading.notes.warn(camera, Code.NRP262, message)
        topics = _topics(sensor, mount, reading)
        return cls(
            sensor.attribute("name"),
            topics.image,
            rate_of(sensor, reading),
            fov,
            width,
            height,
            near,
            far,
            mount.place(sensor) @ mount.place(camera),
            topics.depth,
            topics.info,
            topics.points,
            _baseline(sensor),
            noise=noise_of(camera, reading),
            projection=_projection(camera.section("lens"), fov, (width, height)),
            mask=bit_mask(camera, "visibility_mask", ANY_CAMERA),
            trigger_topic=_trigger(sensor, topics.image, reading),
        )

    def part(self, model: Model, link: str, engine: Engine) -> CameraPart:
        kind = TriggeredCameraPart if self.trigger_topic else CameraPart
        return kind(self, model.name, link, engine)


class CameraPart(SensorPart):
    """Publishes the images of one camera."""

    def __init__(self, camera: Camera, model: str, link: str, engine: Engine) -> None:
        super().__init__(camera, model, link, engine)
        self._camera = camera
        self._is_noisy = bool(camera.noise)
        self._path = (model, link, camera.name)
        self._render: Callable[[], ImageArray] = partial(engine.render, *self._path)
        size = f"{camera.name}, {camera.width}x{camera.height}"
        topics = [self._served(camera.topic, Image, f"camera {size}")]
        if camera.depth_topic is not None:
            topics.append(self._served(camera.depth_topic, Image, f"depth of {size}, m"))
        if camera.info_topic is not None:
            topics.append(self._served(camera.info_topic, CameraInfo, f"optics of {size}"))
        if camera.points_topic is not None:
            topics.append(self._served(camera.points_topic, PointCloud2, f"points seen by {size}"))
        self.topics = tuple(topics)

    def read(self, topic: str, now_ns: int) -> Any:
        header = self._header(now_ns)
        if topic == self._camera.info_topic:
            return self._optics(header)
        if topic == self._camera.depth_topic:
            depth = self._depth(now_ns)
            height, width = depth.shape
            return Image(header, height, width, "32FC1", 0, 4 * width, depth)  # type: ignore[arg-type]
        if topic == self._camera.topic and (sight := self._look()):
            return SeenImage.of(header, sight)
        image = self._render()
        if self._is_noisy:
            image = self._with_noise(image, now_ns)
        height, width, channels = image.shape
        if topic == self._camera.points_topic:
            return cloud_of(header, self._depth(now_ns), image, self._camera.focal(width))
        return Image(header, height, width, "rgb8", 0, width * channels, image)

    def _look(self) -> Sight | None:
        """Return what the camera sees, if its image can be drawn when it is read."""
        return None if self._is_noisy else self._engine.look(*self._path)

    def _depth(self, now_ns: int) -> DepthArray:
        depth = self._engine.depth(*self._path)
        if self._is_noisy:
            name = self._camera.depth_topic or self._camera.topic
            depth = depth + self._measured(name, now_ns, np.zeros(depth.shape)).astype(np.float32)
            depth.flags.writeable = False
        return depth

    def _with_noise(self, image: ImageArray, now_ns: int) -> ImageArray:
        noisy = 255 * self._measured(self._camera.topic, now_ns, image / 255)
        result: ImageArray = np.rint(noisy).clip(0, 255).astype(np.uint8)
        result.flags.writeable = False
        return result

    def _optics(self, header: Header) -> CameraInfo:
        return info_of(self._camera, header, self._engine.image_size(*self._path))


class TriggeredCameraPart(CameraPart):
    """Publishes what a camera sees one physics step after each message that is true."""

    def __init__(self, camera: Camera, model: str, link: str, engine: Engine) -> None:
        super().__init__(camera, model, link, engine)
        self.pushed_topics = frozenset(topic.name for topic in self.topics)
        self._subscribed = frozenset[str]()
        self.deadline_ns: int | None = None
        what = f"takes an image with {camera.name}"
        self.topics = (*self.topics, TopicInfo(camera.trigger_topic, Bool, Direction.IN, what=what))

    def on_subscriptions_changed(self, subscribed: frozenset[str]) -> None:
        self._subscribed = self.pushed_topics & subscribed

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        if message.data and self.deadline_ns is None:
            self.deadline_ns = now_ns + self._engine.step_ns

    def poll(self) -> Iterator[tuple[str, Stamped]]:
        now_ns = self._engine.now_ns
        if self.deadline_ns is not None and now_ns >= self.deadline_ns:
            self.deadline_ns = None
            for topic in sorted(self._subscribed):
                yield topic, Stamped(now_ns, self.read(topic, now_ns))

    def at_deadline(self, now_ns: int) -> None:
        """Stop the engine at the time of an image, which :meth:`poll` takes."""

    def reset(self) -> None:
        super().reset()
        self.deadline_ns = None

    def save(self) -> object:
        return super().save(), self.deadline_ns

    def restore(self, saved: Any) -> None:
        biases, self.deadline_ns = saved
        super().restore(biases)


def _field_of(camera: Element, width: int, height: int, reading: Reading) -> float:
    """Return the horizontal field of view, rad: that of the ``<intrinsics>`` if given."""
    fov = field_of_view(camera, 1.047)
    given = camera.section("lens").find("intrinsics")
    if given is None:
        return fov
    fx = given.positive("fx", 277.0)
    fy, cx, cy = given.positive("fy", fx), given.number("cx", width / 2), given.number("cy", height / 2)
    if abs(fy / fx - 1) > _SLACK or abs(cx - width / 2) > 1 or abs(cy - height / 2) > 1:
        message = (
            f"<intrinsics> with fx {fx:g}, fy {fy:g}, cx {cx:g} and cy {cy:g}: pixels are square and the "
            f"image of {width} x {height} is centred, with the focal length fx"
        )
        reading.notes.warn(given, Code.NRP262, message)
    return 2 * atan(width / 2 / fx)


def _projection(lens: Element, fov: float, size: tuple[int, int]) -> tuple[float, ...]:
    """Return the numbers of a ``<projection>``, by default those of the lens; () without one."""
    given = lens.find("projection")
    if given is None:
        return ()
    width, height = size
    focal = width / 2 / tan(fov / 2)
    usual = {"p_fx": focal, "p_fy": focal, "p_cx": width / 2, "p_cy": height / 2, "tx": 0.0, "ty": 0.0}
    return tuple(given.number(tag, default) for tag, default in usual.items())


def info_of(camera: Camera, header: Header, size: tuple[int, int]) -> CameraInfo:
    """Return the optics of a camera whose images have this height and width."""
    height, width = size
    focal = camera.focal(width)
    k = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])
    p = np.column_stack([k, [-focal * camera.baseline, 0.0, 0.0]])
    if camera.projection:
        fx, fy, cx, cy, tx, ty = np.multiply(camera.projection, width / camera.width)
        p = np.array([[fx, 0.0, cx, tx], [0.0, fy, cy, ty], [0.0, 0.0, 1.0, 0.0]])
    return CameraInfo(header, height, width, d=np.zeros(5), k=k.ravel(), r=np.eye(3).ravel(), p=p.ravel())


def _size(sensor: Element, image: Element, reading: Reading) -> tuple[int, int]:
    is_deep = sensor.attribute("type") in _DEPTH and image.word("format") in _DEPTH_FORMATS
    if image.word("format") not in _COLOR_FORMATS and not is_deep:
        message = f"the image format '{image.word('format')}' is not simulated: images are R8G8B8"
        reading.notes.warn(image, Code.NRP262, message)
    width, height = image.positive("width", 320), image.positive("height", 240)
    if width != int(width) or height != int(height):
        raise image.error(f"an image must have a whole number of pixels, not {width:g} x {height:g}")
    if width * height > _MOST_PIXELS:
        name, size = sensor.attribute("name"), f"{width:g} x {height:g}"
        raise image.error(
            f"the image of camera '{name}' has {size} pixels; at most {_MOST_PIXELS:,} are possible"
        )
    return int(width), int(height)


def _clip(clip: Element) -> tuple[float, float]:
    near, far = clip.positive("near", 0.1), clip.positive("far", 100.0)
    if near >= far:
        raise clip.error(f"the near clip distance ({near:g} m) must be below the far one ({far:g} m)")
    return near, far


def _eye_name(sensor: Element) -> str:
    """Return the name of the ``<camera>`` of a sensor."""
    return sensor.require("camera").attributes.get("name", "")


def _baseline(sensor: Element) -> float:
    """Return the distance of the right one of several cameras from the left one, m; 0 for any other."""
    if _eye_name(sensor) != "right":
        return 0.0
    plugins = [plugin for plugin in sensor.all("plugin") if plugin_name(plugin) == _STEREO_PLUGIN]
    return max((plugin.number("hackBaseline", 0.0) for plugin in plugins), default=0.0)


class _Topics(NamedTuple):
    """Absolute topics: images, depth, optics and points; None for none."""

    image: str
    depth: str | None
    info: str | None
    points: str | None


def _trigger(sensor: Element, image: str, reading: Reading) -> str:
    """Return the topic that triggers a camera; empty for one that takes images by itself."""
    camera = sensor.section("camera")
    if sensor.attribute("type") not in ("camera", *_DEPTH) or not camera.flag("triggered", False):
        return ""
    return resolve_name(camera.word("trigger_topic") or f"{image}/trigger", reading.robot)


def _topics(sensor: Element, mount: Mount, reading: Reading) -> _Topics:
    """Return the topics: those of the ROS plugin, else Gazebo's."""
    name, deep = sensor.attribute("name"), sensor.attribute("type") in _DEPTH
    image = sensor.word("topic", reading.topic_of(mount.name, f"{name}/image"))
    base = dirname(image) if basename(image).startswith("image") else image
    info = sensor.section("camera").word("camera_info_topic", join(base, "camera_info"))
    depth, points = (join(base, "depth_image"), join(base, "points")) if deep else ("", "")
    if sensor.attribute("type") in _DEPTH_ALONE:
        image, depth = join(base, "color"), image
    for plugin in sensor.all("plugin"):
        kind = plugin_name(plugin)
        if kind in (_CAMERA_PLUGIN, _STEREO_PLUGIN, *_DEPTH_PLUGINS):
            camera = plugin.word("cameraName") or plugin.word("camera_name") or name
            eye = _eye_name(sensor) if kind == _STEREO_PLUGIN else ""
            named = partial(_topic_of_plugin, plugin, join(camera, eye).rstrip("/"))
            image, info = named("imageTopicName", "image_raw"), named("cameraInfoTopicName", "camera_info")
            if deep or kind in _DEPTH_PLUGINS:
                depth = named("depthImageTopicName", "depth/image_raw")
                points = named("pointCloudTopicName", "points")
        else:
            warn_of_plugin(plugin, reading)
    further = (resolve_name(each, reading.robot) if each else None for each in (depth, info, points))
    return _Topics(resolve_name(image, reading.robot), *further)


def _topic_of_plugin(plugin: Element, base: str, tag: str, usual: str) -> str:
    """Return a topic of a ROS plugin: in ROS 1 named by a tag, in ROS 2 remapped."""
    return join(ros_namespace(plugin), remapped_topic(plugin, join(base, plugin.word(tag, usual))))


@dataclass(frozen=True, slots=True)
class ImageSensor(Sensor):
    """A sensor behind a lens.

    Args:
        optics: the camera that sees the images.
    """

    needs: ClassVar[tuple[str, ...]] = ("renderers",)

    frame_suffix: ClassVar[str] = Camera.frame_suffix

    optics: Camera

    @property
    def view(self) -> View | None:
        """The images that it consists of; None: several views."""
        return self.optics.view

    @property
    def offset(self) -> Pose:
        return self.optics.offset


def topic_of(sensor: Element, mount: Mount, reading: Reading, last: str) -> str:
    """Return the absolute topic of a sensor: its ``<topic>``, or its place and name, and a last part."""
    default = reading.topic_of(mount.name, f"{sensor.attribute('name')}/{last}")
    return resolve_name(sensor.word("topic", default), reading.robot)


_SEMANTIC = "semantic"
_PANOPTIC = ("panoptic", "instance")


@dataclass(frozen=True, slots=True)
class SegmentationCamera(ImageSensor):
    """A camera of labels, which gz-sim's ``Label`` plugin gives to visuals and models.

    Args:
        topic: absolute topic of the labels (``rgb8``): the label in all channels; of a panoptic one the label
            in the last channel, and the number of the instance in the first (low) and the second byte.
        colored_topic: that of the same as colours, a colour for each label (and instance).
        info_topic: that of its optics.
        panoptic: whether instances are distinguished.
    """

    tag: ClassVar[str] = "segmentation"

    colored_topic: str
    info_topic: str
    panoptic: bool = False

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> SegmentationCamera:
        optics = Camera.read(sensor, mount, reading)
        kind = sensor.section("camera").word("segmentation_type", _SEMANTIC).lower()
        if kind not in (_SEMANTIC, *_PANOPTIC):
            given = sensor.require("camera").require("segmentation_type")
            hint = did_you_mean(kind, (_SEMANTIC, *_PANOPTIC))
            raise given.error(f"'{given.text}' is not a <segmentation_type>{hint}")
        base = sensor.word("topic", reading.topic_of(mount.name, f"{optics.name}/segmentation"))
        labels, colored, info = (
            resolve_name(join(base, end), reading.robot)
            for end in ("labels_map", "colored_map", "camera_info")
        )
        return cls(optics.name, labels, optics.rate_hz, optics, colored, info, kind in _PANOPTIC)

    def part(self, model: Model, link: str, engine: Engine) -> SegmentationPart:
        return SegmentationPart(self, model.name, link, engine)


class SegmentationPart(SensorPart):
    """Publishes the labels of one camera."""

    def __init__(self, sensor: SegmentationCamera, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor, self._path = sensor, (model, link, sensor.name)
        what = f"seen by {sensor.name}"
        self.topics = (
            self._served(sensor.topic, Image, f"labels {what}"),
            self._served(sensor.colored_topic, Image, f"labels {what}, as colours"),
            self._served(sensor.info_topic, CameraInfo, f"optics of {sensor.name}"),
        )

    def read(self, topic: str, now_ns: int) -> Any:
        header = self._header(now_ns)
        if topic == self._sensor.info_topic:
            return info_of(self._sensor.optics, header, self._engine.image_size(*self._path))
        segments = self._engine.segments(*self._path)
        painted = colors_of if topic == self._sensor.colored_topic else bytes_of
        image = painted(segments, panoptic=self._sensor.panoptic)
        height, width, channels = image.shape
        return Image(header, height, width, "rgb8", 0, width * channels, image)


def bytes_of(segments: SegmentArray, *, panoptic: bool) -> npt.NDArray[np.uint8]:
    """Return segments as gz-sim's map of labels, shape ``(height, width, 3)``."""
    labels, instances = segments[..., 0], segments[..., 1]
    channels = (instances & 255, instances >> 8, labels) if panoptic else (labels, labels, labels)
    return np.stack(channels, axis=-1).astype(np.uint8)


def colors_of(segments: SegmentArray, *, panoptic: bool) -> npt.NDArray[np.uint8]:
    """Return a colour for each label (and instance), black for none, shape ``(height, width, 3)``.

    They are those of the PASCAL VOC data sets: the bits of the number are dealt out to red, green and blue,
    the highest bits first.
    """
    numbers = segments[..., 0].astype(np.uint32)
    if panoptic:
        numbers |= (segments[..., 1].astype(np.uint32) & 0xFFFF) << 8
    image = np.zeros((*numbers.shape, 3), np.uint8)
    for bit in range(8):
        for channel in range(3):
            image[..., channel] |= ((numbers >> (3 * bit + channel) & 1) << (7 - bit)).astype(np.uint8)
    return image
