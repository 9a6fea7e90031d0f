"""One figure that tells the story of a run, drawn from its recording alone."""

from __future__ import annotations

from pathlib import Path

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.read import Recording

SUFFIXES = (".png", ".svg", ".pdf")

# so that equal recordings give equal files
_UNDATED: dict[str, dict[str, str | None]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}


def check_target(path: Path) -> None:
    """Refuse a file that no figure can be drawn into.

    Raises:
        ExperimentError: the suffix is not one of :data:`SUFFIXES`, or there is no such folder.
    """
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix, SUFFIXES)
        raise ExperimentError(f"a figure is a .png, .svg or .pdf file, not '{path.name}'{hint}")
    if not path.absolute().parent.is_dir():
        raise ExperimentError("there is no such folder", path=path.parent)


def plot(recording: Recording, path: Path) -> None:
    """Draw a recording into a file.

    Args:
        recording: of which run.
        path: the suffix chooses between PNG, SVG and PDF.

    Raises:
        ExperimentError: the suffix is another, or there is no such folder.
    """
    check_target(path)
    from nrp_core.recording.plot.page import PICTURES, draw_page
    from nrp_core.recording.plot.story import Story, moments, pictures
    from nrp_core.recording.plot.style import style

    story = Story.of(recording)
    with style():
        figure = draw_page(story, pictures(recording, moments(story, PICTURES)))
        figure.savefig(path, metadata=_UNDATED.get(path.suffix.lower()))
