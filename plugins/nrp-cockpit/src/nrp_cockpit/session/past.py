"""The past of a run: snapshots, and the messages from outside since then, so that it can be repeated."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import lz4.block  # type: ignore[import-untyped]

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.errors import CapabilityError
from nrp_core.experiment import Run

WATCHED_NS, ALONE_NS = NS_PER_S, 5 * NS_PER_S
"""Simulated time between two automatic snapshots, with and without clients."""
RECENT_NS = 60 * NS_PER_S
"""Older automatic snapshots are kept as far apart as without clients, so long runs need little memory."""
BYTES_A_SECOND = 4_000_000
"""Maximum size of automatic snapshots per simulated second; those of a large network are slow, hence rare."""
MOST_KEPT = 100
"""Maximum number of requested snapshots; each report of the timeline lists all, in at most 4 kB."""
MOST_LEFT = 10
"""Maximum number of abandoned futures; the oldest is forgotten first."""
MOST_BYTES = 256_000_000
"""Maximum size of all snapshots, compressed; abandoned futures and automatic ones are removed first."""


@dataclass(slots=True)
class Moment:
    """A snapshot.

    Args:
        id: its name.
        t_ns: its time.
        data: the state, compressed.
        kept: whether a user requested it.
        edits: time and name of each change of the run from outside before it.
        was: whether it belongs to the past of the present run; else to an abandoned one.
    """

    id: str
    t_ns: int
    data: bytes = field(repr=False)
    kept: bool
    edits: tuple[tuple[int, str], ...]
    was: bool = True


class Past:
    """Takes snapshots of a run and returns to any time of its past.

    Going back forgets nothing: the run can be repeated up to the latest time reached, until it is
    changed from outside. The end of a future that is abandoned then stays as a snapshot, unless the run
    repeats it.

    Args:
        run: the run.
        can_save: whether it can be saved; otherwise the past is empty.
        halted: returns whether a repetition should stop.

    Attributes:
        due_ns: simulated time of the next automatic snapshot if no client is connected.
    """

    def __init__(self, run: Run, *, can_save: bool, halted: Callable[[], bool] = lambda: False) -> None:
        self._run, self._can_save, self._halted = run, can_save, halted
        self._lost = ""  # why it cannot be saved now
        self._moments: list[Moment] = []
        self._left: deque[Moment] = deque(maxlen=MOST_LEFT)  # the ends of abandoned futures
        self._repeated: Moment | None = (
            None  # the one of them that the run reaches again if nobody changes it
        )
        self._edits: list[tuple[int, str]] = []
        self._published: list[tuple[int, str, Any]] = []
        self._reach_ns, self._number, self._rarer = run.loop.now_ns, 0, 1.0
        self._last_was(-ALONE_NS)
        self._again: deque[Any] | None = None  # the messages to publish again, while the past is repeated
        run.loop.hooks.from_outside.append(self._note)
        self.after_step()

    def data(self) -> dict[str, Any]:
        """Return requested snapshots, ends of abandoned futures, automatic snapshots, and edits."""
        shown = [each for each in self._moments if each.kept]
        return {
            "snapshots": [
                {"id": each.id, "t_s": seconds(each.t_ns), "left": not each.kept}
                for each in (*shown, *self._left)
            ],
            "automatic_s": [seconds(each.t_ns) for each in self._moments if not each.kept],
            "edits": [{"t_s": seconds(t_ns), "name": name} for t_ns, name in self._edits],
        }

    @property
    def refused(self) -> dict[str, str]:
        """The capabilities that the run has lost since its last change, with the reason for each."""
        if not self._lost:
            return {}
        goes_back = any(each.was for each in self._moments)
        return dict.fromkeys(["snapshot"] if goes_back else ["snapshot", "step_back"], self._lost)

    def take(self) -> Moment:
        """Take a requested snapshot.

        Raises:
            CapabilityError: the run cannot be saved, or the memory for snapshots is full.
        """
        kept = [each for each in self._moments if each.kept]
        kept_bytes = sum(len(each.data) for each in kept)
        if len(kept) >= MOST_KEPT or kept_bytes >= MOST_BYTES:
            raise CapabilityError(
                f"{len(kept)} snapshots are kept, {kept_bytes / 1e6:.0f} MB, and there is no room for more: "
                "remove one first"
            )
        return self._take(kept=True)

    def forget(self, name: str) -> None:
        """Forget a snapshot.

        Raises:
            CapabilityError: no snapshot has this name.
        """
        gone = self.named(name)
        if gone in self._left:
            self._left.remove(gone)
            return
        gone.kept = False  # it remains as an automatic one, which helps to go back
        if not gone.was:
            self._moments.remove(gone)

    def after_step(self, every_ns: int = WATCHED_NS) -> None:
        """Take an automatic snapshot if it is due."""
        if self._again is None and self._run.loop.now_ns - self._last_ns >= every_ns * self._rarer:
            self._take_own()

    def mark(self, name: str) -> None:
        """Note that the run was changed in a way that a repetition would miss.

        Args:
            name: what was changed, and its value after ``=``; a second value replaces one of the last second.
        """
        now_ns = self._run.loop.now_ns
        self.forget_after(now_ns)
        self._lost, self._repeated = "", None
        target, is_value, _ = name.partition(" = ")
        self._edits = [
            each for each in self._edits
            if not is_value or each[0] <= now_ns - NS_PER_S or each[1].partition(" = ")[0] != target
        ]  # fmt: skip
        self._edits.append((now_ns, name))
        self._take_own()
        if self._lost:
            self._leave()  # a repetition from an earlier snapshot would miss the change

    def named(self, name: str) -> Moment:
        """Return a snapshot by its name.

        Raises:
            CapabilityError: the snapshot does not exist.
        """
        found = next((each for each in (*self._moments, *self._left) if each.id == name), None)
        if found is None:
            raise CapabilityError(f"there is no snapshot '{name}'")
        return found

    def restore(self, moment: Moment) -> None:
        """Return to a snapshot; one of an abandoned past makes that the past."""
        self.keep_end()
        self._run.restore(lz4.block.decompress(moment.data))
        self._run.error = None
        if not moment.was:
            self._leave()
            if moment in self._left:
                self._left.remove(moment)
                self._moments.append(moment)
            moment.was, self._edits = True, list(moment.edits)
            self._reach_ns = moment.t_ns
            self._last_was(moment.t_ns)

    def way_to(self, t_ns: int, lead_ns: int = 0) -> Callable[[], None]:
        """Return the repetition from the last snapshot before a time up to that time, or from now on.

        The messages from outside are published again. A time that was not reached yet is beyond
        the repetition.

        Args:
            t_ns: that time.
            lead_ns: the time to repeat at least, if an earlier snapshot exists.

        Raises:
            CapabilityError: no earlier snapshot exists.
        """
        self._note_reach()
        now_ns = self._run.loop.now_ns
        past = [each for each in self._moments if each.was and each.t_ns <= t_ns]
        early = [each for each in past if each.t_ns <= t_ns - lead_ns]
        before = (early or past)[-1] if past else None
        until_ns = min(t_ns, self._reach_ns)
        if t_ns >= now_ns and (before is None or before.t_ns <= now_ns):
            return lambda: self._relive(until_ns)
        if before is None:
            raise CapabilityError(f"there is no snapshot to return from to {seconds(t_ns):g} s")
        found = before

        def go() -> None:
            self.restore(found)
            self._relive(until_ns)

        return go

    def forget_after(self, t_ns: int) -> None:
        """Forget all after a time but requested snapshots, because the run continues differently."""
        self._abandon_after(t_ns)
        self._published = [each for each in self._published if each[0] < t_ns]
        self._edits = [each for each in self._edits if each[0] <= t_ns]
        self._reach_ns = t_ns
        self._last_was(max((each.t_ns for each in self._moments if each.was), default=-ALONE_NS))

    def reset(self) -> None:
        """Forget all but requested snapshots and ends of futures, because the run is at its beginning."""
        self._leave()
        self._edits = []
        self._lost, self._reach_ns = "", self._run.loop.now_ns
        self.after_step()

    def close(self) -> None:
        """Stop observing the run."""
        self._run.loop.hooks.from_outside.remove(self._note)

    def _last_was(self, t_ns: int) -> None:
        """Note the time of the last snapshot."""
        self._last_ns, self.due_ns = t_ns, t_ns + int(ALONE_NS * self._rarer)

    def keep_end(self) -> None:
        """Take a snapshot before the run leaves the latest time that it has reached."""
        if self._run.loop.now_ns >= self._reach_ns and self._run.error is None:
            self._take_own()
        self._note_reach()

    def _note_reach(self) -> None:
        """Record the latest time reached, before the run jumps to another time."""
        self._reach_ns = max(self._reach_ns, self._run.loop.now_ns)

    def _leave(self) -> None:
        """Abandon the present past."""
        self._abandon_after(-1)
        self._published = []
        self._last_was(-ALONE_NS)

    def _abandon_after(self, t_ns: int) -> None:
        """Remove the snapshots after a time from the past, and keep the last one as the end of a future."""
        later = [each for each in self._moments if each.was and each.t_ns > t_ns]
        for each in later:
            each.was = False
        self._moments = [each for each in self._moments if each.kept or each.was]
        if not later or later[-1].kept or not later[-1].t_ns:
            return
        steered = any(each[0] > t_ns for each in self._edits) or any(
            each[0] >= t_ns for each in self._published
        )
        if steered or self._repeated is None:
            self._left.append(later[-1])
            self._repeated = None if steered else later[-1]

    def _relive(self, t_ns: int) -> None:
        """Repeat up to a time, unless a message from outside makes the run continue differently."""
        loop, published = self._run.loop, self._published
        at = bisect_left(published, loop.now_ns, key=lambda each: each[0])
        again: deque[Any] = deque()
        self._again = again
        try:
            while loop.now_ns < t_ns and published is self._published and not self._halted():
                while at < len(published) and published[at][0] <= loop.now_ns:
                    _, topic, message = published[at]
                    again.append(message)
                    loop.publish(topic, message)
                    at += 1
                self._run.step()
        finally:
            self._again = None

    def _take_own(self) -> None:
        """Take an automatic snapshot, unless the run cannot be saved or could not since its last change."""
        if self._lost or not self._can_save:
            return
        now_ns = self._run.loop.now_ns
        self._moments = [each for each in self._moments if each.kept or each.t_ns != now_ns]
        try:
            self._take(kept=False)
        except CapabilityError as error:  # a variable of a function holds an object that cannot be saved
            self._lost = str(error)

    def _take(self, *, kept: bool) -> Moment:
        self._number += 1
        state = self._run.snapshot()
        self._rarer = max(1.0, len(state) / BYTES_A_SECOND)
        # a tenth of the size, in a fifth of the time that the snapshot itself takes
        now_ns, data = self._run.loop.now_ns, lz4.block.compress(state)
        moment = Moment(f"s{self._number}", now_ns, data, kept, tuple(self._edits))
        if self._repeated is not None and self._repeated.t_ns <= now_ns:
            with suppress(ValueError):  # others have taken its place
                self._left.remove(self._repeated)
            self._repeated = None
        self._moments.append(moment)
        self._moments.sort(key=lambda each: each.t_ns)
        self._last_was(max(self._last_ns, moment.t_ns))
        self._let_age()
        self._thin_out()
        return moment

    def _let_age(self) -> None:
        """Remove old automatic snapshots that are close to the one before."""
        recent_ns = self._run.loop.now_ns - RECENT_NS
        stays: list[Moment] = []
        for each in self._moments:
            is_close = bool(stays) and stays[-1].was and each.t_ns - stays[-1].t_ns < ALONE_NS
            if each.kept or each.t_ns >= recent_ns or not is_close:
                stays.append(each)
        self._moments = stays

    def _thin_out(self) -> None:
        """Remove every second automatic snapshot while all need too much memory."""
        while sum(len(each.data) for each in (*self._moments, *self._left)) > MOST_BYTES:
            if self._left:
                self._left.popleft()
                continue
            own = [each for each in self._moments[1:-1] if not each.kept][::2]
            if not own:
                return
            gone = {each.id for each in own}
            self._moments = [each for each in self._moments if each.id not in gone]

    def _note(self, topic: str, message: Any) -> None:
        now_ns = self._run.loop.now_ns
        if self._again and message is self._again[0]:
            self._again.popleft()
            if now_ns < self._reach_ns:
                return
        if now_ns < self._reach_ns:
            self.forget_after(now_ns)
        self._repeated = None
        self._published.append((now_ns, topic, message))
