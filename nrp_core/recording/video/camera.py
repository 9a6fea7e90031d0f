"""The images of a recorded camera."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording.images import Pixels, pixels_of
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.recording import Recording
from nrp_core.recording.video import VideoOptions


def camera_frames(recording: Recording, times_s: FloatArray, options: VideoOptions) -> Iterator[Pixels]:
    """Yield the latest image of a camera at each time; before its first image, the first one.

    Raises:
        ExperimentError: the recording has no images of this camera.
    """
    images = recording.messages({_topic(recording, str(options.camera))})
    shown = next(images, None)
    if shown is None:
        raise ExperimentError(f"no images of '{options.camera}'", path=recording.file)
    coming = next(images, None)
    pixels = pixels_of(shown.message)
    for t_s in times_s.tolist():
        latest = None
        while coming is not None and seconds(coming.t_ns) <= t_s:
            latest, coming = coming, next(images, None)
        if latest is not None:
            pixels = pixels_of(latest.message)
        yield pixels


def camera_names(recording: Recording) -> list[str]:
    """Return the topics of the cameras, and the parts of their names."""
    topics = [topic.name for topic in recording.with_role(Role.CAMERA)]
    return [*topics, *sorted({part for topic in topics for part in topic.split("/") if part})]


def _topic(recording: Recording, camera: str) -> str:
    """Return the topic of a camera, by the topic or a part of its name."""
    topics = [topic.name for topic in recording.with_role(Role.CAMERA)]
    if camera in topics:
        return camera
    named = [topic for topic in topics if camera in topic.split("/")]
    if len(named) == 1:
        return named[0]
    if not topics:
        raise ExperimentError("the recording has no images of cameras", path=recording.file)
    wrong = f"several cameras are named '{camera}': {', '.join(named)}" if named else f"no camera '{camera}'"
    hint = "" if named else did_you_mean(camera, camera_names(recording))
    raise ExperimentError(wrong + hint, path=recording.file)
