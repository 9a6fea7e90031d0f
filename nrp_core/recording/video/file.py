"""Video files: VP8 in WebM, and VP9 in MP4, which browsers play.

OpenCV's wheel has no encoder for H.264, and its one for VP9 takes four times as long as for VP8.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.files import replacing, writing
from nrp_core._support.quiet import quiet
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_core.recording.images import Pixels
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.reader import RecordingReader
from nrp_core.recording.video import Progress, VideoOptions


def times_of(recording: RecordingReader, options: VideoOptions) -> FloatArray:
    """Return the times of the images, s, ascending.

    Raises:
        ExperimentError: the recording has no messages in the requested period.
    """
    moving = {topic.name for topic in recording.with_role(Role.MODELS, Role.CAMERA)}
    times_ns = [message.log_time for _, message in recording.raw(moving)]
    last_s = seconds(max(times_ns, default=0))
    end_s = min(options.end_s, last_s)
    if end_s <= options.begin_s:
        message = f"it has no messages after {options.begin_s:g} s: it ends at {last_s:g} s"
        raise ExperimentError(message, path=recording.file)
    count = int((end_s - options.begin_s) / options.speed * options.rate_hz) + 1
    times_s: FloatArray = options.begin_s + np.arange(count, dtype=np.float64) * (
        options.speed / options.rate_hz
    )
    return times_s


_CODECS = {".mp4": "vp09", ".webm": "VP80"}


def write_video(
    path: Path, frames: Iterator[Pixels], rate_hz: float, total: int, progress: Progress | None
) -> int:
    """Write images of one size as a video; return their number.

    Raises:
        ExperimentError: the file cannot be written.
    """
    import cv2

    first = next(frames)
    height, width = first.shape[:2]
    count = 0
    with writing(path), replacing(path) as draft:
        with quiet():  # FFmpeg reports that it chooses the tag of the codec itself
            code = cv2.VideoWriter.fourcc(*_CODECS[path.suffix.lower()])
            writer = cv2.VideoWriter(str(draft), cv2.CAP_FFMPEG, code, rate_hz, (width, height))
        if not writer.isOpened():
            raise ExperimentError("the video cannot be written: OpenCV's FFmpeg does not open it", path=path)
        try:
            for image in chain([first], frames):
                writer.write(cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
                count += 1
                if progress is not None:
                    progress(count, total)
        finally:
            writer.release()
        if not draft.is_file() or not draft.stat().st_size:
            raise ExperimentError("the video cannot be written: is the disk full?", path=path)
    return count
