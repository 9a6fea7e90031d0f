"""Colours of visuals, and whether they glow."""

from __future__ import annotations

from typing import Any

from nrp_core.world.engine import Engine
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.part import Part
from nrp_core.world.scene.model import Rgba
from nrp_core.world.topics import Direction, TopicInfo


class ColorPart(Part):
    """The topic ``/<model>/<link>/<visual>/color``, to read or set the colour."""

    def __init__(self, visual: str, rgba: Rgba, glows: bool, engine: Engine) -> None:
        self._visual, self._initial, self._engine = visual, (rgba, glows), engine
        self._rgba, self._glows = rgba, glows
        what = f"colour of the visual {visual}"
        self.topics = (TopicInfo(f"/{visual}/color", ColorRGBA, Direction.BOTH, what=what, limits=(0, 1)),)

    def read(self, topic: str, now_ns: int) -> ColorRGBA:
        return ColorRGBA(*self._rgba)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._set((float(message.r), float(message.g), float(message.b), float(message.a)))

    def set_glow(self, glows: bool) -> None:
        """Set whether the visual has its colour in any light."""
        self._glows = glows
        self._engine.set_glow(self._visual, glows)

    def reset(self) -> None:
        self.restore(self._initial)

    def save(self) -> object:
        return self._rgba, self._glows

    def restore(self, saved: Any) -> None:
        rgba, glows = saved
        self._set(rgba)
        if glows is not self._glows:
            self.set_glow(glows)

    def _set(self, rgba: Rgba) -> None:
        self._rgba = rgba
        self._engine.set_color(self._visual, rgba)
