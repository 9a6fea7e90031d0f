"""The time of a session as other viewers show and steer it: play, pause, speed, and a slider."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_cockpit.wire.protocol import PlaybackRequest, PlaybackStatus

FASTEST = 1000.0
"""The speed that stands for as fast as it can."""

_STATUS = {
    "running": PlaybackStatus.PLAYING,
    "busy": PlaybackStatus.BUFFERING,
    "finished": PlaybackStatus.ENDED,
    "failed": PlaybackStatus.ENDED,
}


@dataclass(frozen=True, slots=True)
class Playback:
    """Where a session is.

    Args:
        state: what it does, in one word.
        t_ns: the simulated time.
        end_ns: the simulated time at which it ends.
        pace: simulated seconds a wall second at most; None: as fast as it can.
    """

    state: str = "paused"
    t_ns: int = 0
    end_ns: int = 0
    pace: float | None = 1.0

    @property
    def status(self) -> PlaybackStatus:
        """What it does, as the protocol says it."""
        return _STATUS.get(self.state, PlaybackStatus.PAUSED)

    @property
    def speed(self) -> float:
        """The pace as a number."""
        return FASTEST if self.pace is None else self.pace

    def calls_for(self, request: PlaybackRequest) -> list[tuple[str, dict[str, object]]]:
        """Return the services that do what a viewer asks for, with their arguments."""
        calls: list[tuple[str, dict[str, object]]] = []
        if request.speed > 0 and abs(request.speed - self.speed) > 1e-3:
            calls.append(("pace", {"factor": None if request.speed >= FASTEST else request.speed}))
        if request.seek_ns is not None:
            calls.append(("seek", {"t_s": request.seek_ns * 1e-9}))
        is_playing = self.state == "running" and request.seek_ns is None
        if request.play != is_playing:
            at_end = (self.t_ns if request.seek_ns is None else request.seek_ns) >= self.end_ns
            if not (request.play and at_end):
                calls.append(("play" if request.play else "pause", {}))
        return calls
