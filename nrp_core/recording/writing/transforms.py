"""Poses of links: ``tf2_msgs/TFMessage`` on ``/tf``, from the world to each movable frame."""

from __future__ import annotations

from nrp_core.recording.layout import TRANSFORMS, WORLD_FRAME, Role
from nrp_core.recording.writing.encoding import TransformsEncoder
from nrp_core.recording.writing.frames import Frames, SceneFrames
from nrp_core.recording.writing.signals import Add, RecordEntry, Signal, about_role
from nrp_core.world.messages.generated import made

PERIOD_NS = 40_000_000
"""Minimum simulated time between two messages: 25 Hz is enough for viewers and videos."""


class LinkTransforms(Signal):
    """The poses of all frames that can move."""

    _about = about_role(Role.TRANSFORMS)

    def __init__(self, frames: SceneFrames) -> None:
        self._frames = frames
        self._encoded: Frames | None = None
        self._due_ns = 0
        kind = made("tf2_msgs/msg/TFMessage")
        assert kind is not None
        self._kind = kind

    def take(self, now_ns: int, add: Add) -> None:
        frames = self._frames.now
        if frames is not self._encoded:
            self._encoded, self._due_ns = frames, now_ns
            self._encode = TransformsEncoder(WORLD_FRAME, frames.names)
        if now_ns < self._due_ns or not frames.names:
            return
        self._due_ns = (now_ns // PERIOD_NS + 1) * PERIOD_NS
        add(RecordEntry(now_ns, TRANSFORMS, self._kind, self._about, self._encode(now_ns, frames.poses())))
