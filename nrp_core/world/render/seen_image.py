"""An image that is drawn when it is read."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Header
from nrp_core.world.render.cameras import ImageArray, Sight

ChooseColors = Callable[[npt.NDArray[np.uint8]], npt.NDArray[np.bool_]]
"""Returns which colours of an array, shape ``(n, 3)``, are chosen."""

_NO_PIXELS = np.empty(0, np.uint8)
_data: Any = Image.__dict__["data"]


@lru_cache(maxsize=64)
def _choose(choose: ChooseColors, palette: bytes) -> npt.NDArray[np.bool_]:
    """Return which colours of a palette are chosen; copies of a scene have the same palettes."""
    return choose(np.frombuffer(palette, np.uint8).reshape(-1, 3))


class SeenImage(Image):
    """The image of a camera; its ``data`` are drawn at the first access."""

    __slots__ = ("_sight",)
    __qualname__ = Image.__qualname__  # so its text is that of an Image
    _sight: Sight | None

    @classmethod
    def of(cls, header: Header, sight: Sight) -> SeenImage:
        """Return the image of what a camera saw.

        Args:
            header: its time and frame.
            sight: what it saw.
        """
        height, width = sight.size
        image = cls(header, height, width, "rgb8", 0, 3 * width, _NO_PIXELS)
        image._sight = sight
        return image

    @property
    def data(self) -> ImageArray:
        """The pixels, read-only, shape ``(height, width, 3)``."""
        if (sight := self._sight) is not None:
            self.data = sight.image()
        pixels: ImageArray = _data.__get__(self)
        return pixels

    @data.setter
    def data(self, data: ImageArray) -> None:
        _data.__set__(self, data)
        self._sight = None  # last, because another thread may be reading the data

    def count_colors(self, choose: ChooseColors) -> tuple[int, int] | None:
        """Return the number of pixels of some colours in the left and in the right half, without the image.

        Returns:
            None if the image exists, or if the sky has such a colour.
        """
        if (sight := self._sight) is None:
            return None
        chosen = _choose(choose, sight.palette.tobytes())
        return None if chosen[-1] else sight.count(chosen)

    def __reduce__(self) -> tuple[Any, ...]:
        return Image, (self.header, self.height, self.width, self.encoding, 0, self.step, self.data)
