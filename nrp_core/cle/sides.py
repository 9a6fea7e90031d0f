"""Advance brain and world over one step, in parallel if that is faster."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from nrp_core._support.machine import cores
from nrp_core._support.stopwatch import work
from nrp_core.brain.interface import Brain
from nrp_core.cle.account import TimeAccount
from nrp_core.world.world import World

WORTH_A_THREAD_NS = 500_000
"""Both sides must take at least this long for a thread to pay off; a handover costs about 100 us."""


class Sides:
    """A brain and a world that advance together.

    The world stays on the calling thread, because its renderers are bound to one; the brain runs on a
    thread of its own. Neither sees the other within a step, so the result does not depend on this.

    Args:
        brain: the brain.
        world: the world.
        concurrent: whether to use a thread; None: if the brain releases the GIL and the duration of the
            last step makes it worthwhile.
    """

    def __init__(self, brain: Brain, world: World, *, concurrent: bool | None = None) -> None:
        self._brain, self._world = brain, world
        can = brain.capabilities.releases_gil and cores() > 1
        self._concurrent = False if concurrent is None and not can else concurrent
        self._thread = ThreadPoolExecutor(1, "brain")
        self._last_ns = 0

    def advance(self, t_ns: int, account: TimeAccount) -> None:
        """Bring both to ``t_ns``.

        Raises:
            BaseException: the exception of either side, after both have stopped.
        """
        began = work.now_ns()
        together = self._last_ns >= WORTH_A_THREAD_NS if self._concurrent is None else self._concurrent
        brain_ns, world_ns = self._together(t_ns) if together else self._in_turn(t_ns)
        self._last_ns = min(brain_ns, world_ns)
        account.brain_ns += brain_ns
        account.world_ns += world_ns
        account.both_ns += work.now_ns() - began

    def advance_in_turn(self, t_ns: int, account: TimeAccount) -> None:
        """Bring both to ``t_ns`` on the calling thread."""
        brain_ns, world_ns = self._in_turn(t_ns)
        account.brain_ns += brain_ns
        account.world_ns += world_ns
        account.both_ns += brain_ns + world_ns

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown()

    def _in_turn(self, t_ns: int) -> tuple[int, int]:
        return _timed(self._brain, t_ns), _timed(self._world, t_ns)

    def _together(self, t_ns: int) -> tuple[int, int]:
        brain = self._thread.submit(_timed, self._brain, t_ns)
        try:
            world_ns = _timed(self._world, t_ns)
        except BaseException as error:
            failure = brain.exception()
            if failure is not None:
                error.add_note(f"the brain failed too: {failure}")
            raise
        return brain.result(), world_ns


def _timed(side: Brain | World, t_ns: int) -> int:
    began = work.now_ns()
    side.run_until(t_ns)
    return work.now_ns() - began
