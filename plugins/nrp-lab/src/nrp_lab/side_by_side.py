"""Steps of many loops at once, for copies of an experiment in one process."""

from __future__ import annotations

import gc
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial

from nrp_core.brain import Closing
from nrp_core.cle.loop import ClosedLoop
from nrp_core.cle.together import BrainBatch, EndsOfSteps
from nrp_core.utilities import time_limit
from nrp_core.world.batch import advance_together


class SideBySide(Closing):
    """Steps independent loops together; each takes the step that it would take alone.

    Brains and worlds of all loops advance on threads. Transfer functions and hooks run on the calling thread,
    because users' code may share values; vectorised functions are called once for all loops.
    The pace of a loop is ignored, and calls that other threads make on a loop are not held back until the end
    of a step.

    Args:
        threads: number of threads; 1: the calling one.
    """

    def __init__(self, threads: int = 1) -> None:
        self.threads = threads
        self._pool = ThreadPoolExecutor(threads, "copies") if threads > 1 else None
        self._brains = [BrainBatch() for _ in range(threads)]
        self._has_frozen = False
        self._ends = EndsOfSteps()
        self._limits: dict[float | None, time_limit.TimeLimit] = {}

    def step(self, loops: Sequence[ClosedLoop]) -> dict[int, Exception]:
        """Take one step of each loop; one that fails does not stop the others.

        Returns:
            The errors of the loops that failed, by their numbers.
        """
        if not loops:
            return {}
        if not self._has_frozen:
            _frozen.begin()
            self._has_frozen = True
        for loop in loops:  # a limit of its own for each would be a thread for each
            loop.time_limit = self._limits.setdefault(loop.time_limit.limit_s, loop.time_limit)
        failed: dict[int, Exception] = {}
        with time_limit.DeferredInterrupt(), ExitStack() as watching:
            for limit in {loop.time_limit for loop in loops}:
                watching.enter_context(limit.watching())
            for number, loop in enumerate(loops):
                try:
                    loop.begin_step()
                except Exception as error:  # noqa: BLE001 - the caller decides about each loop
                    failed[number] = error
            going = [n for n in range(len(loops)) if n not in failed]
            shares = [going[first :: self.threads] for first in range(self.threads)]
            work = partial(self._advance, loops, failed)
            list((map if self._pool is None else self._pool.map)(work, self._brains, shares))
            self._ends.end({n: loop for n, loop in enumerate(loops) if n not in failed}, failed)
        for number in failed:
            loops[number].is_stepping = False
        return dict(sorted(failed.items()))

    def _advance(
        self,
        loops: Sequence[ClosedLoop],
        failed: dict[int, Exception],
        together: BrainBatch,
        share: Sequence[int],
    ) -> None:
        """Advance the brains of some loops together, then the world of each."""
        chosen = [loops[number] for number in share]
        began = time.perf_counter_ns()
        ends_ns = [loop.now_ns + loop.plan.period_ns for loop in chosen]
        errors = together.run_until([loop.brain for loop in chosen], ends_ns)
        failed |= {share[place]: error for place, error in errors.items()}
        between = time.perf_counter_ns()
        going = [number for number in share if number not in failed]
        worlds, times_ns = [loops[n].world for n in going], [loops[n].brain.now_ns for n in going]
        failed |= {going[place]: error for place, error in advance_together(worlds, times_ns).items()}
        brain_ns, world_ns = between - began, time.perf_counter_ns() - between
        for number in going:
            loops[number].account.add(brain_ns // len(share), world_ns // len(share))

    def close(self) -> None:
        """End the threads."""
        if self._has_frozen:
            _frozen.end()
            self._has_frozen = False
        if self._pool is not None:
            self._pool.shutdown()


class _FrozenObjects:
    """Objects that the garbage collector leaves out: it would visit those of all copies again and again."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0
        self._is_shared = False

    def begin(self) -> None:
        """Freeze all objects that exist."""
        with self._lock:
            if not self._users:
                self._is_shared = gc.get_freeze_count() > 0  # the program itself has frozen objects
            self._users += 1
            gc.freeze()

    def end(self) -> None:
        """Return the objects to the collector, unless others need them to stay frozen."""
        with self._lock:
            self._users -= 1
            if not self._users and not self._is_shared:
                gc.unfreeze()


_frozen = _FrozenObjects()
