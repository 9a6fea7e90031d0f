"""Videos of a recording: the images of a camera, or the scene drawn from another place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from importlib.util import find_spec
from math import inf
from pathlib import Path

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.paths import check_free
from nrp_core.recording.reading.reader import RecordingReader

SUFFIXES = (".mp4", ".webm")
Vector = tuple[float, float, float]
Progress = Callable[[int, int], None]
"""Called with the number of images written, and the total."""


class ViewKind(StrEnum):
    """The place of the camera in a drawn video."""

    ABOVE = "above"
    """From above, with the whole trajectory in view."""
    FOLLOW = "follow"
    """Behind a robot, following it."""
    FREE = "free"
    """At a fixed place."""


class Renderer(StrEnum):
    """How the scene is drawn."""

    SHADED = "shaded"
    """Without lights, so that shapes are recognised."""
    REALISTIC = "realistic"
    """With the lights and shadows of the scene."""


@dataclass(frozen=True, slots=True)
class VideoOptions:
    """The contents of a video.

    Args:
        camera: name of a camera, or its topic; None: the scene is drawn.
        view: the place of the camera.
        speed: factor of the speed of the video relative to simulated time.
        begin_s, end_s: the period that is shown, s.
        width, height: size of drawn images, pixels, even.
        rate_hz: images a second of the video.
        robot: the robot that is followed; None: the first movable one.
        eye, target: position and target of the camera in the free view, m; None: with everything in view.
        renderer: how the scene is drawn: ``shaded``, so that shapes are recognised, or ``realistic``, with
            the lights and shadows of the scene.
    """

    camera: str | None = None
    view: ViewKind = ViewKind.FOLLOW
    speed: float = 1.0
    begin_s: float = 0.0
    end_s: float = inf
    width: int = 640
    height: int = 480
    rate_hz: float = 25.0
    robot: str | None = None
    eye: Vector | None = None
    target: Vector | None = None
    renderer: Renderer = Renderer.SHADED


def check_target(path: Path, *, overwrite: bool = False) -> None:
    """Refuse a file that cannot be a video.

    Raises:
        ExperimentError: the suffix is not one of :data:`SUFFIXES`, the folder does not exist, the file
            exists and is not to be replaced, or PyAV is not installed.
    """
    if find_spec("av") is None:
        raise ExperimentError("a video needs PyAV: pip install 'nrp-core[video]'")
    if path.suffix.lower() not in SUFFIXES:
        hint = did_you_mean(path.suffix, SUFFIXES)
        raise ExperimentError(f"a video is a .mp4 or .webm file, not '{path.name}'{hint}")
    if not path.absolute().parent.is_dir():
        raise ExperimentError("the folder does not exist", path=path.parent)
    check_free(path, overwrite=overwrite)


def video(
    recording: RecordingReader,
    path: Path,
    options: VideoOptions,
    progress: Progress | None = None,
    *,
    overwrite: bool = False,
) -> int:
    """Write a video of a recording, in H.264, or VP8 for .webm; return the number of its images.

    Raises:
        ExperimentError: the suffix is not supported, the folder does not exist, the file exists and
            ``overwrite`` is not set, the recording lacks the data to show, or the file cannot be written.
    """
    check_target(path, overwrite=overwrite)
    from nrp_core.recording.video.file import times_of, write_video
    from nrp_core.recording.video.views import camera_frames, drawn_frames

    times_s = times_of(recording, options)
    frames = drawn_frames if options.camera is None else camera_frames
    return write_video(path, frames(recording, times_s, options), options.rate_hz, len(times_s), progress)
