"""A retina: images as the firing rates of ON and OFF ganglion cells, ready for Poisson sources.

Each cell compares the logarithm of the intensity in its centre with that in its surround (a difference of
Gaussians; Rodieck 1965) and adapts to what stays (Enroth-Cugell and Robson 1966). Its rate is ``baseline``
plus ``gain`` times that contrast for ON cells, minus for OFF cells, and never below 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.engine import Engine
from nrp_core.world.messages.sensor_msgs import Image
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.sensors import Mount
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.eye import Eye, topic_of
from nrp_core.world.sensors.intensity import log_intensity
from nrp_core.world.sensors.sensor import SensorPart


@dataclass(frozen=True, slots=True)
class Retina(Eye):
    """Ganglion cells behind a lens, an ON and an OFF cell for each pixel.

    Args:
        topic: absolute topic of the rates, Hz, an image of two channels (``32FC2``): ON and OFF.
        centre, surround: standard deviations of the two Gaussians, pixels.
        gain: Hz for each unit of the logarithm of contrast.
        baseline: rate without contrast, Hz.
        sustained: the share of the response to what stays that remains, from 0 (transient) to 1.
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
