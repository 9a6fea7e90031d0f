"""The time of a session for other viewers, which can play, pause, seek and set the speed."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_cockpit.wire.protocol import PlaybackRequest, PlaybackStatus

FASTEST = 1000.0
"""The speed that means as fast as possible."""

_STATUS = {
    "running": PlaybackStatus.PLAYING,
    "busy": PlaybackStatus.BUFFERING,
    "finished": PlaybackStatus.ENDED,
    "failed": PlaybackStatus.ENDED,
}


@dataclass(frozen=True, slots=True)
class Playback:
    """The state of a session's time.

    Args:
        state: its mode, in one word.
        t_ns: the simulated time.
        end_ns: the simulated time at which it ends.
        pace: maximum simulated seconds per wall second; None: as fast as possible.
    """

    state: str = "paused"
    t_ns: int = 0
    end_ns: int = 0
    pace: float | None = 1.0

    @property
    def status(self) -> PlaybackStatus:
        """The mode in the protocol."""
        return _STATUS.get(self.state, PlaybackStatus.PAUSED)

    @property
    def speed(self) -> float:
        """The pace as a number."""
        return FASTEST if self.pace is None else self.pace

    def calls_for(self, request: PlaybackRequest) -> list[tuple[str, dict[str, object]]]:
        """Return the services for a request of a viewer, with their arguments."""
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
