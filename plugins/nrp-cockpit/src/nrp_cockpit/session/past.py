"""The past of a run: snapshots, and what was published from outside since, so that it can be lived again."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Any

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import CapabilityError
from nrp_core.experiment.running.run import Run

EVERY_NS = NS_PER_S
"""Simulated time between two snapshots that are taken on their own."""
MOST_BYTES = 256_000_000
"""Of snapshots together; those taken on their own are thinned out first."""


@dataclass(slots=True)
class Moment:
    """A snapshot.

    Args:
        id: its name.
        t_ns: when it was taken.
        data: the state.
        kept: whether a person asked for it.
    """

    id: str
    t_ns: int
    data: bytes = field(repr=False)
    kept: bool


class Past:
    """Takes snapshots of a run and returns to any time between them.

    Args:
        run: the run.
        can_save: whether it can be saved at all; otherwise the past is empty.
    """

    def __init__(self, run: Run, *, can_save: bool) -> None:
        self._run, self._can_save = run, can_save
        self._moments: list[Moment] = []
        self._published: list[tuple[int, str, Any]] = []
        self._number = 0
        self._reliving = False
        run.loop.hooks.from_outside.append(self._note)
        self.after_step()

    @property
    def shown(self) -> list[dict[str, Any]]:
        """The snapshots that a person asked for, as data."""
        return [{"id": each.id, "t_s": seconds(each.t_ns)} for each in self._moments if each.kept]

    def take(self) -> Moment:
        """Take a snapshot because a person wants it.

        Raises:
            CapabilityError: the run cannot be saved.
        """
        return self._take(kept=True)

    def after_step(self) -> None:
        """Take a snapshot if it is time."""
        if not self._can_save or self._reliving:
            return
        now_ns = self._run.loop.now_ns
        if not self._moments or now_ns - self._moments[-1].t_ns >= EVERY_NS:
            try:
                self._take(kept=False)
            except CapabilityError:
                self._can_save = False  # a variable of a function holds what cannot be saved

    def named(self, name: str) -> Moment:
        """Return a snapshot by its name.

        Raises:
            CapabilityError: there is none.
        """
        found = next((each for each in self._moments if each.id == name), None)
        if found is None:
            raise CapabilityError(f"there is no snapshot '{name}'")
        return found

    def restore(self, moment: Moment) -> None:
        """Return to a snapshot; what came after it is kept until the run goes another way."""
        self._run.restore(moment.data)
        self._run.error = None

    def return_to(self, t_ns: int) -> None:
        """Return to a time: to the last snapshot before it, and from there forward as it was.

        Raises:
            CapabilityError: there is no snapshot before it.
        """
        before = [each for each in self._moments if each.t_ns <= t_ns]
        if not before:
            raise CapabilityError("there is no snapshot to go back to: this run cannot be saved")
        published = list(self._published)
        self.restore(before[-1])
        self._reliving = True
        try:
            self._relive(t_ns, published)
        finally:
            self._reliving = False

    def forget_after(self, t_ns: int) -> None:
        """Forget what came after a time, but what a person kept: from there the run goes another way."""
        self._moments = [each for each in self._moments if each.kept or each.t_ns <= t_ns]
        self._published = [each for each in self._published if each[0] < t_ns]

    def begin_again(self) -> None:
        """Forget everything: the run is at its beginning."""
        self._moments = [each for each in self._moments if each.kept]
        self._published = []
        self.after_step()

    def close(self) -> None:
        """Stop taking notes."""
        self._run.loop.hooks.from_outside.remove(self._note)

    def _relive(self, t_ns: int, published: list[tuple[int, str, Any]]) -> None:
        loop, at = (
            self._run.loop,
            bisect_right(published, self._run.loop.now_ns - 1, key=lambda each: each[0]),
        )
        while loop.now_ns < t_ns:
            while at < len(published) and published[at][0] <= loop.now_ns:
                loop.publish(published[at][1], published[at][2])
                at += 1
            self._run.step()

    def _take(self, *, kept: bool) -> Moment:
        self._number += 1
        moment = Moment(f"s{self._number}", self._run.loop.now_ns, self._run.snapshot(), kept)
        self._moments.append(moment)
        self._moments.sort(key=lambda each: each.t_ns)
        self._thin_out()
        return moment

    def _thin_out(self) -> None:
        """Remove every second snapshot that was taken on its own, while they need too much room."""
        while sum(len(each.data) for each in self._moments) > MOST_BYTES:
            own = [each for each in self._moments[1:-1] if not each.kept][::2]
            if not own:
                return
            gone = {each.id for each in own}
            self._moments = [each for each in self._moments if each.id not in gone]

    def _note(self, topic: str, message: Any) -> None:
        if not self._reliving:
            self._published.append((self._run.loop.now_ns, topic, message))
