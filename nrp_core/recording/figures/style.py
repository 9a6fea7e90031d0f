"""Colours and type of the figure; the colours can be told apart by everybody."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.colors import Colormap, LinearSegmentedColormap

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
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
    "svg.hashsalt": "nrp-core",
}


@contextmanager
def style() -> Iterator[None]:
    """Draw in the figure's style."""
    with mpl.rc_context(_RC):
        yield


def time_colours() -> Colormap:
    """Return the colours of time, from start to end; the palest part is left out."""
    viridis = mpl.colormaps["viridis"]
    return LinearSegmentedColormap.from_list("time", [viridis(0.94 * i / 15) for i in range(16)])


def colour(index: int) -> str:
    """Return a colour of the palette."""
    return PALETTE[index % len(PALETTE)]
