"""One figure that tells the story of a run, drawn from its recording alone."""

from __future__ import annotations

from enum import StrEnum
from importlib.util import find_spec
from pathlib import Path

from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.reading.recording import Recording

SUFFIXES = (".png", ".svg", ".pdf")

# so that equal recordings give equal files
_UNDATED: dict[str, dict[str, str | None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


def require_matplotlib() -> None:
    """Refuse to draw where Matplotlib is not installed.

    Raises:
        ExperimentError: it is not.
    """
    if find_spec("matplotlib") is None:
        raise ExperimentError("a figure needs Matplotlib: pip install 'nrp-core[plot]'")


def check_target(path: Path) -> None:
    """Refuse a file that no figure can be drawn into.

    Raises:
        ExperimentError: the suffix is not one of :data:`SUFFIXES`, the folder does not exist, or Matplotlib
            is not installed.
    """
    require_matplotlib()
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix, SUFFIXES)
        raise ExperimentError(f"a figure is a .png, .svg or .pdf file, not '{path.name}'{hint}")
    if not path.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=path.parent)


class What(StrEnum):
    """What a figure shows."""

    RUN = "run"
    """The whole story on one page."""
    RASTER = "raster"
    """The spikes."""
    TRAJECTORY = "trajectory"
    """The room from above with the tracks of the robots."""
    DEVICES = "devices"
    """What devices show and what is sent to the robots."""
    CAMERA = "camera"
    """What the camera saw at moments that matter."""


def plot(recording: Recording, path: Path, what: What = What.RUN) -> None:
    """Draw a recording into a file.

    Args:
        recording: of which run.
        path: the suffix chooses between PNG, SVG and PDF.
        what: the whole story, or a part of it.

    Raises:
        ExperimentError: the suffix is another, the folder does not exist, the recording has nothing of
            what shall be shown, or the disk does not take it.
    """
    check_target(path)
    from nrp_core.recording.figures.page import PICTURES, draw_page
    from nrp_core.recording.figures.parts import draw_part
    from nrp_core.recording.figures.story import Story, moments, pictures
    from nrp_core.recording.figures.style import style

    if not recording.topics:
        raise ExperimentError("nothing was recorded, or nothing of it is whole", path=recording.file)
    story = Story.of(recording)
    with style():
        if what is What.RUN:
            figure = draw_page(story, pictures(recording, moments(story, PICTURES)))
        else:
            figure = draw_part(what.value, story, recording)
        with writing(path):
            figure.savefig(path, metadata=_UNDATED.get(path.suffix.lower()))
