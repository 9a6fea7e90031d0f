"""Options of a figure: its contents and its size."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum
from math import inf
from typing import Any

from matplotlib.figure import Figure

from nrp_core.errors import did_you_mean
from nrp_core.quantities import parse

DPI = 150
_UNITS = {"cm": 1 / 2.54, "mm": 1 / 25.4, "in": 1.0}
_LEAST_IN, _MOST_IN = 1.0, 100.0
_PAGE_IN = (5.9, 3.9)
"""The smallest page on which the texts of all panels keep clear of each other, with four criteria."""


class Panel(StrEnum):
    """A part of the page."""

    MAP = "map"
    TIMELINE = "timeline"
    SPIKES = "spikes"
    DEVICES = "devices"
    COMMANDS = "commands"
    CAMERA = "camera"


@dataclass(frozen=True, slots=True)
class PlotOptions:
    """How a figure is drawn.

    Args:
        size_inches: width and height; None: the figure's own size.
        dpi: dots per inch of a PNG file.
        begin_s, end_s: the period that is shown, s.
        panels: the parts of the page.
        style: a style sheet of Matplotlib: its name, or a file. It comes after our own.
    """

    size_inches: tuple[float, float] | None = None
    dpi: int = DPI
    begin_s: float = 0.0
    end_s: float = inf
    panels: Collection[Panel] = tuple(Panel)
    style: str | None = None

    @property
    def crowded(self) -> bool:
        """Whether a page with all panels is too small for them."""
        least = zip(self.size_inches or _PAGE_IN, _PAGE_IN, strict=True)
        return len(self.panels) == len(Panel) and any(side < needed for side, needed in least)

    def figure(self, size_inches: tuple[float, float], **settings: Any) -> Figure:
        """Return an empty figure, of this size unless the options have another."""
        return Figure(figsize=self.size_inches or size_inches, dpi=self.dpi, **settings)


def size_inches(text: str) -> tuple[float, float]:
    """Read a size such as ``180x120mm``, ``18x12cm`` or ``7x5in``.

    Raises:
        ValueError: it is not a size, or not between 1 and 100 inches.
    """
    number, _, rest = text.partition("x")
    unit = rest.lstrip("0123456789. ")
    if not unit or not number.strip():
        raise ValueError(f"a size is a width, an x, a height and a unit, such as 180x120mm, not '{text}'")
    sides = [
        float(parse(f"{side}{unit}", _UNITS, "a size", bare=None)) for side in (number, rest[: -len(unit)])
    ]
    if not all(_LEAST_IN <= side <= _MOST_IN for side in sides):
        raise ValueError(f"a figure is {_LEAST_IN:g} to {_MOST_IN:g} inches wide and high, not {text}")
    return sides[0], sides[1]


def panels_of(text: str) -> tuple[Panel, ...]:
    """Read a list of panels, separated by commas.

    Raises:
        ValueError: one of them does not exist, or is given twice.
    """
    known = [panel.value for panel in Panel]
    for name in (names := [each.strip() for each in text.split(",")]):
        if name not in known:
            raise ValueError(f"unknown panel '{name}'{did_you_mean(name, known)}")
        if names.count(name) > 1:
            raise ValueError(f"'{name}' is given twice")
    return tuple(map(Panel, names))
