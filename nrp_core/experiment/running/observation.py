"""The observations of a run at each time: events, criteria, falls, and the trajectories of robots."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Collection, Iterable
from typing import Any

from nrp_core.cle import ClosedLoop
from nrp_core.experiment.making.watch import Watch
from nrp_core.experiment.running.falls import FallWatch
from nrp_core.world.rigid import Pose


class Observation:
    """Observes a run once for each time.

    Args:
        watch: the events and criteria of the experiment.
        falls: reports robots that fall.
        robots: names of the robots, of which some may have been left out.

    Attributes:
        digest: the digest of the robots' trajectories so far.
    """

    def __init__(self, watch: Watch, falls: FallWatch, robots: Collection[str]) -> None:
        self._watch, self._falls, self._robots = watch, falls, robots
        self._begin()

    def _begin(self) -> None:
        self._looked_at_ns: int | None = None
        self.digest = TrajectoryDigest()

    def look(self, loop: ClosedLoop) -> None:
        """Evaluate a time, after the step to it or before the first step; once for each time."""
        now_ns = loop.now_ns
        if now_ns != self._looked_at_ns:
            self._looked_at_ns = now_ns
            self._watch.look(now_ns)
            poses = self.poses()
            self.digest.add(poses.values())
            self._falls.look(now_ns, poses)

    def poses(self) -> dict[str, Pose]:
        """Return the poses of the present robots: some may have been left out or deleted."""
        where = self._watch.where
        return {name: where.pose(name) for name in self._robots if name in where}

    def reset(self) -> None:
        """Reset to time 0."""
        self._watch.reset()
        self._falls.reset()
        self._begin()

    def save(self) -> tuple[Any, ...]:
        """Return the state, as a part of a snapshot."""
        return self._looked_at_ns, self.digest.state, self._watch.save()

    def restore(self, saved: tuple[Any, ...]) -> None:
        """Restore a state from :meth:`save`, in a world that was restored."""
        self._looked_at_ns, self.digest.state, watched = saved
        self._watch.restore(watched)


class TrajectoryDigest:
    """A hash of poses, bit for bit; equal digests, equal trajectories.

    The digest of each step is made from the previous one, so the state is a few bytes.

    Attributes:
        state: the digest so far.
    """

    def __init__(self) -> None:
        self.state = b""

    def add(self, poses: Iterable[Pose]) -> None:
        """Add the poses of the robots after one more step."""
        data = b"".join(struct.pack("<7d", *pose.position, *pose.orientation) for pose in poses)
        self.state = hashlib.blake2b(self.state + data, digest_size=16).digest()

    def hexdigest(self) -> str:
        """Return the digest so far."""
        return self.state.hex()
