"""A recording with its figures and videos, as users open it, and the result of a run that has one."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.running.result import Result
from nrp_core.paths import path_of
from nrp_core.recording.reading.reader import RecordingReader

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Kind = TypeVar("Kind", bound=StrEnum)


class Recording(RecordingReader):
    """A recording on disk.

    Args:
        path: the folder of a recording, or a single MCAP file. A folder that lost its messages can be
            checked, not read.

    Raises:
        ExperimentError: not a recording, or in another format.
    """

    @checks_arguments("path")
    def plot(
        self, what: str = "run", path: Path | str | None = None, *, overwrite: bool = False, **options: Any
    ) -> Figure:
        """Draw the run, or one part of it, as ``nrp plot`` does.

        Args:
            what: ``run`` for the whole page, or ``raster``, ``trajectory``, ``devices`` or ``camera``.
            path: a .png, .svg or .pdf file to write as well.
            overwrite: whether to replace an existing file.
            options: ``size_inches``, ``dpi``, ``begin_s``, ``end_s`` and ``panels`` of
                :class:`~nrp_core.recording.figures.style.PlotOptions`.

        Returns:
            A figure of Matplotlib. Notebooks show it.

        Raises:
            ExperimentError: the part does not exist, the recording has no data to show, or the file exists
                or cannot be written.
            TypeError: the option does not exist.
        """
        from nrp_core.recording import figures

        figures.require_matplotlib()
        from nrp_core.recording.figures.style import PlotOptions

        chosen, drawn = _one_of(figures.What, what), PlotOptions(**options)
        if path is not None:
            figures.check_target(path_of(path), overwrite=overwrite)
        figure = figures.draw(self, chosen, drawn)
        if path is not None:
            figures.save(figure, path_of(path))
        return figure

    @checks_arguments("path")
    def video(
        self, path: Path | str = "video.mp4", view: str = "follow", *, overwrite: bool = False, **options: Any
    ) -> Path:
        """Write a video of the run, as ``nrp video`` does.

        Args:
            path: a .mp4 or .webm file.
            view: ``follow``, ``above`` or ``free``, the place of the camera of a drawn video.
            overwrite: whether to replace an existing file.
            options: the others of :class:`~nrp_core.recording.video.VideoOptions`, such as ``camera``,
                ``speed``, ``begin_s``, ``end_s``, ``width``, ``height`` and ``renderer``.

        Returns:
            The file.

        Raises:
            ExperimentError: the view does not exist, the recording lacks the data to show, or the file exists
                or cannot be written.
            TypeError: the option does not exist.
        """
        from nrp_core.recording import video

        target = path_of(path)
        renderer = _one_of(video.Renderer, options.pop("renderer", video.Renderer.SHADED))
        chosen = video.VideoOptions(view=_one_of(video.ViewKind, view), renderer=renderer, **options)
        video.video(self, target, chosen, overwrite=overwrite)
        return target


@dataclass(frozen=True, slots=True, repr=False)
class RecordedResult(Result):
    """The result of a run that was recorded.

    Args:
        folder: the folder of the recording.
    """

    folder: Path

    @property
    def recording(self) -> Recording:
        """The recording of the run."""
        return Recording(self.folder)

    def to_dict(self) -> dict[str, Any]:
        data = Result.to_dict(self)
        del data["folder"]
        return data


def recorded(result: Result, folder: Path) -> RecordedResult:
    """Return a result with the folder of its recording."""
    return RecordedResult(**{each.name: getattr(result, each.name) for each in fields(result)}, folder=folder)


def _one_of(kinds: type[Kind], name: str) -> Kind:
    """Return the member with a name.

    Raises:
        ExperimentError: none was found.
    """
    known = [kind.value for kind in kinds]
    if name not in known:
        raise ExperimentError(f"there is no '{name}' to draw{did_you_mean(str(name), known)}")
    return kinds(name)
