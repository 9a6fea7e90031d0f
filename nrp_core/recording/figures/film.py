"""The choice of camera images: at events, and at times of much motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_seconds, seconds
from nrp_core.recording.figures.story import Story
from nrp_core.recording.images import pixels_of
from nrp_core.recording.layout import Role
from nrp_core.recording.reading.reader import RecordingReader

_BEFORE_S = 0.1
_NEAR, _NEAR_S = 0.015, 0.2
"""Times closer than this share of the period are merged; in a short period, times closer than this, s."""
_EVEN = 0.2
"""The share of the images at equal intervals of time, so that pauses are shown, too."""


@dataclass(frozen=True)
class CameraFrame:
    """A camera image and its time."""

    t_s: float
    pixels: npt.NDArray[np.uint8]


def image_times(story: Story, count: int) -> list[float]:
    """Return the times of the images to show, ascending.

    They are both ends of the period; the middle and the end of each interval in which a visual had another
    colour; events; and the times of most motion in between.
    """
    begin_s, end_s = story.begin_s, story.end_s
    near_s = max(_NEAR * (end_s - begin_s), min(_NEAR_S, (end_s - begin_s) / 20))
    chosen = {begin_s, end_s}
    for t_s in _event_times(story):
        apart = min(abs(t_s - other) for other in chosen)
        if len(chosen) < count and begin_s < t_s < end_s and apart > near_s:
            chosen.add(t_s)
    return _fill_times(np.array(sorted(chosen)), *_progress(story), count)


def _event_times(story: Story) -> list[float]:
    times = []
    for one in story.coloured():
        middle_s = (one.since_s + one.until_s) / 2
        times += [middle_s, max(middle_s, one.until_s - _BEFORE_S)]
    events = dict((story.run.get("result") or {}).get("events") or {})
    return times + [float(t_s) for t_s in events.values() if t_s is not None]


def _progress(story: Story) -> tuple[FloatArray, FloatArray]:
    """Return times, and the share of all motion in the period that is done by then."""
    begin_s, end_s = story.span_s
    moved = np.array([(begin_s, 0.0), *story.activity, (end_s, 0.0)])
    order = np.argsort(moved[:, 0], kind="stable")
    times, sums = moved[order, 0], np.cumsum(moved[order, 1])
    even = (times - begin_s) / (end_s - begin_s)
    return times, even if not sums[-1] else _EVEN * even + (1 - _EVEN) * sums / sums[-1]


def _fill_times(fixed: FloatArray, times: FloatArray, progress: FloatArray, count: int) -> list[float]:
    """Return the fixed times, and others between them at equal steps of the motion."""
    at = np.interp(fixed, times, progress)
    gaps, parts = np.diff(at), np.ones(len(fixed) - 1, int)
    while len(gaps) and parts.sum() < count - 1:
        parts[np.argmax(gaps / parts)] += 1
    between = [np.linspace(at[i], at[i + 1], n, endpoint=False)[1:] for i, n in enumerate(parts)]
    others = np.interp(np.concatenate([*between, np.empty(0)]), progress, times)
    return sorted(float(t_s) for t_s in np.concatenate([fixed, others]))


def camera_images(recording: RecordingReader, times_s: Sequence[float]) -> list[CameraFrame]:
    """Return the images of the first camera nearest to some times; fewer if it took fewer."""
    cameras = recording.with_role(Role.CAMERA)
    if not cameras:
        return []
    topic = cameras[0].name
    taken = np.array([message.log_time for _, message in recording.raw({topic})])
    if not len(taken):
        return []
    chosen = {int(taken[np.argmin(np.abs(taken - from_seconds(t_s)))]) for t_s in times_s}
    return [
        CameraFrame(seconds(recorded.t_ns), pixels_of(recorded.message))
        for recorded in recording.messages({topic})
        if recorded.t_ns in chosen
    ]
