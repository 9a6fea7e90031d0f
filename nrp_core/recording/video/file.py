"""Video files: H.264 in MP4, and VP8 in WebM."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import Final, cast

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.files import replacing, writing
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


_ENCODERS: Final = {
    ".mp4": ("mp4", "libx264", {"preset": "veryfast", "crf": "18"}),
    ".webm": ("webm", "libvpx", {"deadline": "good", "cpu-used": "4", "crf": "8", "b": "8M"}),
}
"""Container, encoder and its options; the rate is that of a constant quality, at most 8 Mbit/s in WebM."""
_CONTAINERS: Final = {
    "mp4": {"movflags": "faststart", "fflags": "bitexact"},  # players begin before they have the whole file
    "webm": {"fflags": "bitexact"},  # else it has a random number
}
_BT709, _SRGB, _BT601 = 1, 13, 6
"""Codes of ITU-T H.273: the primaries and the transfer of sRGB, and the matrix of the encoded images."""


def write_video(
    path: Path, frames: Iterator[Pixels], rate_hz: float, total: int, progress: Progress | None
) -> int:
    """Write images of one size as a video; return their number.

    Raises:
        ExperimentError: the file cannot be written.
    """
    import av

    first = next(frames)
    height, width = first.shape[:2]
    container, encoder, options = _ENCODERS[path.suffix.lower()]
    count = 0
    with (
        writing(path),
        replacing(path) as draft,
        av.open(draft, "w", format=container, options=_CONTAINERS[container]) as file,
    ):
        stream = cast(
            "av.VideoStream", file.add_stream(encoder, Fraction(rate_hz).limit_denominator(1000), options)
        )
        stream.width, stream.height = width + width % 2, height + height % 2
        stream.pix_fmt = "yuv420p"
        context = stream.codec_context
        context.thread_count = 1  # with more, images depend on the number of processors
        context.color_primaries, context.color_trc, context.colorspace = _BT709, _SRGB, _BT601
        for image in chain([first], frames):
            file.mux(stream.encode(av.VideoFrame.from_ndarray(_with_even_sides(image), format="rgb24")))
            count += 1
            if progress is not None:
                progress(count, total)
        file.mux(stream.encode(None))
    return count


def _with_even_sides(image: Pixels) -> Pixels:
    """Return an image whose last row and column are repeated if their number is odd."""
    height, width = image.shape[:2]
    if height % 2 or width % 2:
        image = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return np.ascontiguousarray(image)
