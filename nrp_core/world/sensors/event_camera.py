"""Event cameras (dynamic vision sensors): each pixel reports when its brightness has changed.

A pixel emits an event when the logarithm of its intensity has moved by its threshold since its last event.
Between two images the logarithm is taken to change evenly, so that events have times between those of the
images, and a strong change gives several events. This is the model of Rebecq et al. (2018), "ESIM: an Open
Event Camera Simulator", with a threshold of its own for each pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.small_matrices import product
from nrp_core.messages.base import Time
from nrp_core.messages.dvs_msgs import Event, EventArray
from nrp_core.messages.event_camera_msgs import EventPacket
from nrp_core.messages.sensor_msgs import Image
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.sensors import Mount
from nrp_core.seeds import Seeds
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.sensors.camera import Camera, ImageSensor, topic_of
from nrp_core.world.sensors.sensor import SensorPart

LUMA = np.array([0.299, 0.587, 0.114]) / 255
"""Weights of red, green and blue in the intensity (ITU-R BT.601), which is 1 for white."""
DARK = 0.001
"""Added to the intensity, so that black has a logarithm."""


def log_intensity(image: ImageArray) -> FloatArray:
    """Return the logarithm of the intensity of each pixel, shape ``(height, width)``."""
    result: FloatArray = np.log(product(image, LUMA) + DARK)
    return result


@dataclass(frozen=True, slots=True)
class Retina(ImageSensor):
    """Ganglion cells behind a lens, an ON and an OFF cell for each pixel.

    Args:
        topic: absolute topic of the rates, Hz, an image of two channels (``32FC2``): ON and OFF.
        centre, surround: standard deviations of the two Gaussians, pixels.
        gain: Hz for each unit of the logarithm of contrast.
        baseline: rate without contrast, Hz.
        sustained: the share of the response to constant light that remains, from 0 (transient) to 1.
        adaptation_s: time constant of the adaptation, s.
    """

    tag: ClassVar[str] = "retina"

    centre: float = 0.8
    surround: float = 2.4
    gain: float = 60.0
    baseline: float = 5.0
    sustained: float = 0.3
    adaptation_s: float = 0.1

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> Retina:
        """Read a ``<camera>`` and a ``<retina>`` with the other fields, in s, Hz and pixels."""
        retina = sensor.section("retina")
        centre, surround = retina.positive("centre", 0.8), retina.positive("surround", 2.4)
        if centre >= surround:
            raise retina.error(f"the <centre> ({centre:g}) must be below the <surround> ({surround:g})")
        sustained = retina.number("sustained", 0.3)
        if not 0 <= sustained <= 1:
            raise retina.error(f"<sustained> is a share from 0 to 1, not {sustained:g}")
        optics = Camera.read(sensor, mount, reading)
        topic = topic_of(sensor, mount, reading, "rates")
        gain, baseline = retina.positive("gain", 60.0), retina.number("baseline", 5.0)
        if baseline < 0:
            raise retina.error(f"the <baseline> of a retina is a rate of 0 Hz or more, not {baseline:g}")
        adaptation_s = retina.positive("adaptation", 0.1)
        return cls(
            optics.name, topic, optics.rate_hz, optics,
            centre, surround, gain, baseline, sustained, adaptation_s,
        )  # fmt: skip

    def part(self, model: Model, link: str, engine: Engine) -> RetinaPart:
        return RetinaPart(self, model.name, link, engine)


class RetinaPart(SensorPart):
    """Publishes the rates of one retina, adapted to the first image."""

    def __init__(self, retina: Retina, model: str, link: str, engine: Engine) -> None:
        super().__init__(retina, model, link, engine)
        self._retina, self._path = retina, (model, link, retina.name)
        size = f"{retina.optics.width}x{retina.optics.height}"
        self.topics = (
            self._served(retina.topic, Image, f"rates of ON and OFF cells of {retina.name}, {size}"),
        )
        self._adapted: tuple[int, FloatArray] | None = None

    def read(self, topic: str, now_ns: int) -> Image:
        retina = self._retina
        contrast = self._contrast(log_intensity(self._engine.render(*self._path)))
        then_ns, usual = self._adapted or (now_ns, contrast)
        usual = contrast + (usual - contrast) * exp((then_ns - now_ns) * 1e-9 / retina.adaptation_s)
        self._adapted = now_ns, usual
        response = retina.gain * (contrast - (1 - retina.sustained) * usual)
        rates = np.stack([retina.baseline + response, retina.baseline - response], axis=-1)
        data = rates.clip(0, None).astype(np.float32)
        data.flags.writeable = False
        height, width, channels = data.shape
        return Image(self._header(now_ns), height, width, "32FC2", 0, 4 * width * channels, data)  # type: ignore[arg-type]

    def _contrast(self, brightness: FloatArray) -> FloatArray:
        import cv2  # takes time to load

        centre, surround = (
            cv2.GaussianBlur(brightness, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE)
            for sigma in (self._retina.centre, self._retina.surround)
        )
        return np.asarray(centre - surround, np.float64)

    def reset(self) -> None:
        self._adapted = None

    def save(self) -> object:
        return self._adapted

    def restore(self, saved: Any) -> None:
        self._adapted = saved


LOWEST_THRESHOLD = 0.01
"""Thresholds that are drawn are at least this; real ones are about 0.1 to 0.5."""


@dataclass(frozen=True, slots=True)
class EventCamera(ImageSensor):
    """A camera that reports changes of brightness, sampled ``rate_hz`` times a second.

    Args:
        topic: absolute topic of the events (``dvs_msgs/EventArray``).
        packets_topic: that of the same events in a compact form (``event_camera_msgs/EventPacket``).
        threshold: mean of the thresholds of pixels, in the logarithm of the intensity.
        spread: their standard deviation.
    """

    tag: ClassVar[str] = "event_camera"

    packets_topic: str
    threshold: float = 0.2
    spread: float = 0.0

    @classmethod
    def read(cls, sensor: Element, mount: Mount, reading: Reading) -> EventCamera:
        """Read a ``<camera>``, and ``<threshold>`` and ``<spread>`` in an ``<event_camera>``."""
        events = sensor.section("event_camera")
        threshold, spread = events.positive("threshold", 0.2), events.number("spread", 0.0)
        if spread < 0:
            raise events.error(f"the <spread> of thresholds must be 0 or more, not {spread:g}")
        optics = Camera.read(sensor, mount, reading)
        topic = topic_of(sensor, mount, reading, "events")
        return cls(optics.name, topic, optics.rate_hz, optics, f"{topic}/packets", threshold, spread)

    def part(self, model: Model, link: str, engine: Engine) -> EventCameraPart:
        return EventCameraPart(self, model.name, link, engine)


class PixelEvents(NamedTuple):
    """Events in the order of their times: columns and rows of pixels, times (ns), and whether brighter."""

    x: IntArray
    y: IntArray
    t_ns: IntArray
    polarity: IntArray


class Pixels:
    """The pixels of an event camera.

    Args:
        thresholds: of each pixel, shape ``(height, width)``.
    """

    def __init__(self, thresholds: FloatArray) -> None:
        self._thresholds = thresholds
        self._before: tuple[int, FloatArray, FloatArray] | None = None

    def see(self, brightness: FloatArray, now_ns: int) -> PixelEvents:
        """Return the events since the last image; the first image gives none.

        Args:
            brightness: logarithms of the intensities, shape ``(height, width)``.
            now_ns: the time of the image.
        """
        if self._before is None:
            self._before = now_ns, brightness, brightness
        then_ns, last, reference = self._before
        change = brightness - reference
        counts = np.floor(np.abs(change) / self._thresholds).astype(np.int64)
        signs = np.sign(change)
        self._before = now_ns, brightness, reference + signs * counts * self._thresholds
        rows, columns = np.nonzero(counts)
        many = counts[rows, columns]
        which = np.repeat(np.arange(len(many)), many)
        first = np.cumsum(many) - many
        steps = np.arange(len(which)) - first[which] + 1
        y, x = rows[which], columns[which]
        level = reference[y, x] + signs[y, x] * steps * self._thresholds[y, x]
        # the share of the time between the images at which the level was reached
        moved = brightness[y, x] - last[y, x]
        share = np.divide(level - last[y, x], moved, out=np.ones_like(moved), where=moved != 0)
        t_ns = then_ns + np.rint(share.clip(0, 1) * (now_ns - then_ns)).astype(np.int64)
        order = np.argsort(t_ns, kind="stable")
        brighter = (signs[y, x] > 0).astype(np.int64)
        return PixelEvents(x[order], y[order], t_ns[order], brighter[order])

    def reset(self) -> None:
        """Forget the images."""
        self._before = None

    def save(self) -> object:
        """Return the state that is kept between images."""
        return self._before

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._before = saved


class EventCameraPart(SensorPart):
    """Publishes the events of one camera, without its images."""

    def __init__(self, camera: EventCamera, model: str, link: str, engine: Engine) -> None:
        super().__init__(camera, model, link, engine)
        self._camera, self._path = camera, (model, link, camera.name)
        size = f"{camera.name}, {camera.optics.width}x{camera.optics.height}"
        self.topics = (
            self._served(camera.topic, EventArray, f"events of {size}"),
            self._served(camera.packets_topic, EventPacket, f"events of {size}, compact"),
        )
        self._made: Pixels | None = None
        self._last: tuple[int, int, PixelEvents] | None = None
        self._sequence = 0

    @property
    def _pixels(self) -> Pixels:
        if self._made is None:
            camera, shape = self._camera, self._engine.image_size(*self._path)
            stream = Seeds(self._engine.seed).child("world/thresholds").stream(camera.topic)
            drawn = stream.normal(camera.threshold, camera.spread, shape)
            self._made = Pixels(drawn.clip(LOWEST_THRESHOLD, None))
        return self._made

    def read(self, topic: str, now_ns: int) -> EventArray | EventPacket:
        since_ns, events = self._events(now_ns)
        header = self._header(now_ns)
        height, width = self._engine.image_size(*self._path)
        if topic == self._camera.topic:
            listed = zip(*(column.tolist() for column in events), strict=True)
            found = [Event(x, y, Time.from_ns(t_ns), bool(p)) for x, y, t_ns, p in listed]
            return EventArray(header, height, width, found)
        header.stamp = Time.from_ns(since_ns)  # times of a packet count from its stamp
        words = (events.t_ns - since_ns).astype(np.uint64) | events.x.astype(np.uint64) << np.uint64(32)
        words |= events.y.astype(np.uint64) << np.uint64(48) | events.polarity.astype(np.uint64) << np.uint64(
            63
        )
        data = words.astype("<u8").view(np.uint8)
        self._sequence += 1
        return EventPacket(header, height, width, self._sequence, since_ns, "mono", False, data)

    def _events(self, now_ns: int) -> tuple[int, PixelEvents]:
        """Return the events since the last image with its time, the same for both forms."""
        if self._last is None or self._last[1] != now_ns:
            since_ns = now_ns if self._last is None else self._last[1]
            image = self._engine.render(*self._path)
            self._last = since_ns, now_ns, self._pixels.see(log_intensity(image), now_ns)
        return self._last[0], self._last[2]

    def reset(self) -> None:
        self._made, self._last, self._sequence = None, None, 0

    def save(self) -> object:
        return self._last, self._sequence, None if self._made is None else self._made.save()

    def restore(self, saved: Any) -> None:
        self._last, self._sequence, pixels = saved
        self._pixels.restore(pixels)
