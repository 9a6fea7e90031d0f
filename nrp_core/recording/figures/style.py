"""Colours and fonts of the figure; the colours are distinguishable with colour blindness."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from io import BytesIO
from math import inf
from typing import Any

import matplotlib as mpl
from matplotlib.colors import Colormap, LinearSegmentedColormap
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
    VOLTAGES = "voltages"
    DEVICES = "devices"
    COMMANDS = "commands"
    OBSERVABLES = "observables"
    CAMERA = "camera"


@dataclass(frozen=True, slots=True)
class PlotOptions:
    """How a figure is drawn.

    Args:
        size_inches: width, and height, None for the figure's own proportions; None: its own size.
        dpi: dots per inch of a PNG file.
        begin_s, end_s: the period that is shown, s.
        panels: the parts of the page.
    """

    size_inches: tuple[float, float | None] | None = None
    dpi: int = DPI
    begin_s: float = 0.0
    end_s: float = inf
    panels: Collection[Panel] = tuple(Panel)

    @property
    def crowded(self) -> bool:
        """Whether a page with all panels is too small for them."""
        least = zip(self.size_inches or _PAGE_IN, _PAGE_IN, strict=True)
        small = any(side is not None and side < needed for side, needed in least)
        return len(self.panels) == len(Panel) and small

    def figure(self, size_inches: tuple[float, float], **settings: Any) -> Figure:
        """Return an empty figure, of this size unless the options have another."""
        own_in, (width_in, height_in) = size_inches, self.size_inches or size_inches
        height_in = height_in or max(_LEAST_IN, width_in * own_in[1] / own_in[0])
        return NotebookFigure(figsize=(width_in, height_in), dpi=self.dpi, **settings)


class NotebookFigure(Figure):
    """A figure that notebooks show; without pyplot, they do not show one of Matplotlib."""

    def _repr_png_(self) -> bytes:
        target = BytesIO()
        self.savefig(target, format="png", facecolor=PAPER)
        return target.getvalue()


def size_inches(text: str) -> tuple[float, float | None]:
    """Read a size such as ``180x120mm``, ``18x12cm`` or ``7x5in``, or a width such as ``85mm``.

    Raises:
        ValueError: it is not a size, or not between 1 and 100 inches.
    """
    *first, last = text.split("x")
    unit = last.lstrip("0123456789. ")
    numbers = [*first, last.removesuffix(unit)]
    if not unit or len(numbers) > 2 or not all(number.strip() for number in numbers):
        known = "a width, an x, a height and a unit, such as 180x120mm, or a width such as 85mm"
        raise ValueError(f"a size is {known}, not '{text}'")
    sides = [float(parse(f"{number}{unit}", _UNITS, "a size", bare=None)) for number in numbers]
    if not all(_LEAST_IN <= side <= _MOST_IN for side in sides):
        raise ValueError(f"a figure is {_LEAST_IN:g} to {_MOST_IN:g} inches wide and high, not {text}")
    return sides[0], sides[1] if len(sides) > 1 else None


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


# Okabe and Ito (2008), "Color universal design", without yellow, which vanishes on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
INK, FAINT, PAPER = "#222222", "#8a8a8a", "#ffffff"
GOOD, BAD = "#00734f", "#b03000"

_RC: dict[Any, Any] = {
    "font.size": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 5,
    "axes.labelsize": 8.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "svg.fonttype": "path",  # the same letters where another machine lacks the font
    "pdf.fonttype": 42,
    "svg.hashsalt": "nrp-core",
}


_SIZES = (
    "font.size",
    "axes.titlesize",
    "axes.labelsize",
    "xtick.labelsize",
    "ytick.labelsize",
    "legend.fontsize",
)
_USUAL_WIDTH_IN, _LEAST = 12.8, 0.72


def text_scale(width_inches: float | None) -> float:
    """Return the size of texts in a figure of a width, relative to the usual size."""
    return max(_LEAST, min(1.0, (width_inches or _USUAL_WIDTH_IN) / _USUAL_WIDTH_IN))


def points(size: float) -> float:
    """Return the text size in the present figure that corresponds to one in a figure of the usual width."""
    return size * float(mpl.rcParams["font.size"]) / float(_RC["font.size"])


@contextmanager
def style(width_inches: float | None = None) -> Iterator[None]:
    """Draw in the figure's style.

    Args:
        width_inches: width of the figure; None: the usual width.
    """
    with mpl.rc_context(_RC):
        sizes: dict[Any, Any] = {key: _RC[key] * text_scale(width_inches) for key in _SIZES}
        mpl.rcParams.update(sizes)
        yield


def time_colours() -> Colormap:
    """Return the colours of time, from start to end; the palest part is omitted."""
    viridis = mpl.colormaps["viridis"]
    return LinearSegmentedColormap.from_list("time", [viridis(0.94 * i / 15) for i in range(16)])


def colour(index: int) -> str:
    """Return a colour of the palette."""
    return PALETTE[index % len(PALETTE)]
