"""Videos of a recording: the images of a camera, or the scene drawn from another place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import inf
from pathlib import Path

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.reading.recording import Recording

SUFFIXES = (".mp4", ".webm")
Vector = tuple[float, float, float]
Progress = Callable[[int, int], None]
"""Is called with the number of images written, and of all."""


class View(StrEnum):
    """Where a scene is seen from."""

    ABOVE = "above"
    """From above, with the whole way in view."""
    FOLLOW = "follow"
    """From behind a robot, and along with it."""
    FREE = "free"
    """From a place that stays."""


@dataclass(frozen=True, slots=True)
class VideoOptions:
    """The contents of a video.

    Args:
        camera: name of a camera, or its topic; None: the scene is drawn.
        view: where the scene is seen from.
        speed: how much faster than in reality the video shows it.
        begin_s, end_s: the time that is shown, s.
        width, height: size of drawn images, pixels, even.
        rate_hz: images a second of the video.
        robot: the one that is followed; None: the first that moves.
        eye, target: of the free view, m; None: a place that shows everything.
    """

    camera: str | None = None
    view: View = View.FOLLOW
    speed: float = 1.0
    begin_s: float = 0.0
    end_s: float = inf
    width: int = 640
    height: int = 480
    rate_hz: float = 25.0
    robot: str | None = None
    eye: Vector | None = None
    target: Vector | None = None


def check_target(path: Path) -> None:
    """Refuse a file that no video can be written into.

    Raises:
        ExperimentError: the suffix is not one of :data:`SUFFIXES`, or the folder does not exist.
    """
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix, SUFFIXES)
        raise ExperimentError(f"a video is a .mp4 or .webm file, not '{path.name}'{hint}")
    if not path.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=path.parent)


def video(recording: Recording, path: Path, options: VideoOptions, progress: Progress | None = None) -> int:
    """Write a video of a recording, in VP9; return the number of its images.

    Raises:
        ExperimentError: the suffix is another, the folder does not exist, the recording does not have what
            shall be shown, or the file cannot be written.
    """
    check_target(path)
    from nrp_core.recording.video.camera import camera_frames
    from nrp_core.recording.video.drawn import drawn_frames
    from nrp_core.recording.video.file import write_video
    from nrp_core.recording.video.timing import times_of

    times_s = times_of(recording, options)
    frames = drawn_frames if options.camera is None else camera_frames
    return write_video(path, frames(recording, times_s, options), options.rate_hz, len(times_s), progress)
