"""The simulated times of the images of a video."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.recording import Recording
from nrp_core.recording.video import VideoOptions


def times_of(recording: Recording, options: VideoOptions) -> FloatArray:
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
