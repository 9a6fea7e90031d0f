"""Figures of a run, drawn from its recording alone."""

from __future__ import annotations

from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from nrp_core._support.files import replacing, writing
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.paths import check_free
from nrp_core.recording.reading.reader import RecordingReader

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nrp_core.recording.figures.style import PlotOptions

SUFFIXES = (".png", ".svg", ".pdf")

# equal recordings give equal files
UNDATED: dict[str, dict[str, str | None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


def require_matplotlib() -> None:
    """Raise an error if Matplotlib is not installed.

    Raises:
        ExperimentError: it is not.
    """
    if find_spec("matplotlib") is None:
        raise ExperimentError("a figure needs Matplotlib: pip install 'nrp-core[plot]'")


def check_target(path: Path, *, overwrite: bool = False) -> None:
    """Refuse a file in which figures cannot be drawn.

    Raises:
        ExperimentError: the suffix is not one of :data:`SUFFIXES`, the folder does not exist, the file exists
            and is not to be replaced, or Matplotlib is not installed.
    """
    require_matplotlib()
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix, SUFFIXES)
        raise ExperimentError(f"a figure is a .png, .svg or .pdf file, not '{path.name}'{hint}")
    if not path.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=path.parent)
    check_free(path, overwrite=overwrite)


class What(StrEnum):
    """The contents of a figure."""

    RUN = "run"
    """The whole run on one page."""
    RASTER = "raster"
    """The spikes."""
    TRAJECTORY = "trajectory"
    """The room from above with the tracks of the robots."""
    DEVICES = "devices"
    """Values of devices, commands to the robots, and observables."""
    CAMERA = "camera"
    """Camera images at important times."""


def draw(recording: RecordingReader, what: What = What.RUN, options: PlotOptions | None = None) -> Figure:
    """Return a figure of a recording, which a notebook shows.

    Args:
        recording: the recording.
        what: the whole page, or one part of it.
        options: its size, the time that it shows, ...

    Raises:
        ExperimentError: the recording has no data to show, or Matplotlib is not installed.
    """
    require_matplotlib()
    from nrp_core.recording.figures.film import camera_images, image_times
    from nrp_core.recording.figures.page import IMAGES, draw_page, draw_part
    from nrp_core.recording.figures.story import Story
    from nrp_core.recording.figures.style import Panel, PlotOptions, style

    if not recording.topics:
        raise ExperimentError("nothing was recorded, or no part of it is intact", path=recording.file)
    options = options or PlotOptions()
    story = Story.of(recording, options.begin_s, options.end_s)
    with style(options.size_inches and options.size_inches[0]):
        if what is not What.RUN:
            return draw_part(what.value, story, recording, options)
        shown = Panel.CAMERA in options.panels
        images = camera_images(recording, image_times(story, IMAGES)) if shown else []
        return draw_page(story, images, options)


def plot(
    recording: RecordingReader,
    path: Path,
    what: What = What.RUN,
    options: PlotOptions | None = None,
    *,
    overwrite: bool = False,
) -> None:
    """Draw a recording into a file.

    Args:
        recording: the recording.
        path: the suffix chooses between PNG, SVG and PDF.
        what: as for :func:`draw`.
        options: as for :func:`draw`.
        overwrite: whether to replace an existing file.

    Raises:
        ExperimentError: as for :func:`draw`; or the suffix is not supported, the folder does not exist, the
            file exists, or the disk refuses a write.
    """
    check_target(path, overwrite=overwrite)
    from nrp_core.recording.figures.style import PlotOptions, style

    options = options or PlotOptions()
    figure = draw(recording, what, options)
    with style(options.size_inches and options.size_inches[0]):
        save(figure, path)


def save(figure: Figure, path: Path) -> None:
    """Write a figure; equal figures give equal files.

    Raises:
        ExperimentError: the disk refuses a write.
    """
    with writing(path), replacing(path) as draft:
        figure.savefig(draft, metadata=UNDATED.get(path.suffix.lower()))
