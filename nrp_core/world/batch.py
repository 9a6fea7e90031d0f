"""Many copies of one scene in one process, for sweeps, evolution and learning.

Each copy is an ordinary world with its own state, topics, seed and random streams; its results are bit for
bit those of a world that runs alone. If the engine releases the GIL while it steps, threads share the copies.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.closing import Closing
from nrp_core.errors import NrpError, TopicError
from nrp_core.messages.base import find_layout, type_name
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.rigid import JointStates
from nrp_core.simulation import Failures, State, note_failure
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import SHARED
from nrp_core.world.switchboard import release_all
from nrp_core.world.topics import Publication, Subscription, TopicInfo
from nrp_core.world.world import World


class WorldBatch(Closing):
    """Copies of one scene.

    Args:
        worlds: one for each copy, at time 0.
        threads: number of threads that step them; 0: one for each processor of this process, if the engine
            allows it.

    Attributes:
        worlds: the copies, for operations that the batch does not have.
        failures: errors of failed copies since the last reset, by number. Failed copies are not stepped.
    """

    def __init__(self, worlds: Sequence[World], threads: int = 0) -> None:
        self.worlds = tuple(worlds)
        self.failures: dict[int, NrpError] = {}
        self._now_ns = 0
        self._threads = min(threads or threads_for(self.worlds), len(self.worlds))
        self._pool = ThreadPoolExecutor(self._threads) if self._threads > 1 else None

    @classmethod
    def open(cls, worlds: Iterable[World], threads: int = 0) -> WorldBatch:
        """Collect opened worlds; if one fails to open, close all."""
        with ExitStack() as opened:
            batch = cls([opened.enter_context(world) for world in worlds], threads)
            opened.pop_all()
        return batch

    def __len__(self) -> int:
        return len(self.worlds)

    @property
    def now_ns(self) -> int:
        """The time of all copies, those that failed or were reset alone excepted."""
        return self._now_ns

    def run_until(self, t_ns: int) -> None:
        """Advance every copy by the time remaining to ``t_ns``; one that fails does not stop the others.

        All reach ``t_ns``, but those that were reset alone are behind by the time of their reset.

        Raises:
            NrpError: all copies have failed; the error of the first one.
        """
        lasts_ns = t_ns - self._now_ns
        shares = [
            [number for number in range(first, len(self), self._threads) if number not in self.failures]
            for first in range(self._threads)
        ]

        def advance(share: Sequence[int]) -> None:
            worlds = [self.worlds[number] for number in share]
            failed = advance_together(worlds, [world.now_ns + lasts_ns for world in worlds])
            for place, error in sorted(failed.items()):
                if worlds[place].state is not State.FAILED or not isinstance(error, NrpError):
                    raise error  # an error of the caller, the same for all copies
                self.failures[share[place]] = error

        list(map(advance, shares) if self._pool is None else self._pool.map(advance, shares))
        if len(self.failures) == len(self):
            raise self.failures[min(self.failures)]
        self._now_ns = t_ns

    def reset(self, seeds: Sequence[int] | None = None) -> None:
        """Reset all copies to time 0, with new seeds if given; failed copies are usable again."""
        self._now_ns = 0
        for number in range(len(self)):
            self.reset_copy(number, None if seeds is None else seeds[number])

    def reset_copy(self, number: int, seed: int | None = None) -> None:
        """Reset one copy to its time 0 without the others; a failed one is usable again.

        Args:
            number: the number of the copy.
            seed: a new seed; by default the copy's own.
        """
        self.failures.pop(number, None)
        self.worlds[number].reset(seed=seed)

    def advertise(self, topic: str) -> BatchPublication:
        """Return the right to publish on a topic of every copy.

        Raises:
            TopicError: the topic does not exist, or it cannot be published on.
        """
        return BatchPublication(self, [world.advertise(topic) for world in self.worlds])

    def subscribe(self, topic: str, *, depth: int | None = 1) -> tuple[Subscription, ...]:
        """Subscribe to a topic of every copy; see :meth:`World.subscribe`."""
        return tuple(world.subscribe(topic, depth=depth) for world in self.worlds)

    def motions(self, model: str) -> FloatArray:
        """Return pose and velocity of a model in every copy, in the frame of the world.

        Returns:
            Shape ``(copies, 13)``: position (m), orientation (quaternion, x y z w), linear velocity (m/s) and
            angular velocity (rad/s).
        """
        rows = np.empty((len(self), 13))
        type(self.worlds[0].engine).read_motions([world.engine for world in self.worlds], model, rows)
        return rows

    def joint_states(self, model: str) -> JointStates:
        """Return the joints of a model in every copy; the arrays have shape ``(copies, joints)``."""
        names = self.worlds[0].joint_states(model).names
        rows = np.empty((len(self), 3, len(names)))
        type(self.worlds[0].engine).read_joints_of([world.engine for world in self.worlds], model, rows)
        return JointStates(names, rows[:, 0], rows[:, 1], rows[:, 2])

    def close(self) -> None:
        """Close every copy."""
        if self._pool is not None:
            self._pool.shutdown()
        for world in self.worlds:
            world.close()


class BatchPublication:
    """The right to publish on one topic of every copy.

    Args:
        batch: the copies.
        publications: one for each copy.
    """

    def __init__(self, batch: WorldBatch, publications: Sequence[Publication]) -> None:
        self._batch, self._publications = batch, publications
        self._layout = find_layout(self.topic.type)

    @property
    def topic(self) -> TopicInfo:
        """The topic, the same in every copy."""
        return self._publications[0].topic

    def publish(self, messages: Sequence[Any] | FloatArray) -> None:
        """Publish a message in each copy except failed ones.

        Args:
            messages: one for each copy; or, for messages that consist of numbers only, an array of these in
                the order of the fields: a ``Twist`` for each copy has shape ``(copies, 6)``, and commands for
                a group of joints or muscles ``(copies, elements)``.

        Raises:
            TopicError: the numbers of messages and copies differ, or the topic cannot carry one.
        """
        if len(messages) != len(self._publications):
            copies = len(self._publications)
            raise TopicError(f"{self.topic.name}: {len(messages)} messages for {copies} copies of the world")
        rows = messages if isinstance(messages, np.ndarray) else None
        if rows is not None:
            self._check_shape(rows)
        for number, publication in enumerate(self._publications):
            if number in self._batch.failures:
                continue
            if rows is None:
                publication.publish(messages[number])
            elif self._layout:
                publication.publish_numbers(rows[number].tolist())
            else:
                publication.publish(Float64MultiArray(data=rows[number].copy()))

    def _check_shape(self, rows: FloatArray) -> None:
        numbers = len(self._layout.paths) if self._layout else len(commanded_elements(self.topic))
        if not numbers or rows.shape[1:] != (numbers,):
            needs = f"{numbers} numbers" if numbers else "more than numbers"
            kind = type_name(self.topic.type)
            raise TopicError(f"{self.topic.name}: a {kind} needs {needs}; got an array of shape {rows.shape}")


def advance_together(worlds: Sequence[World], times_ns: Sequence[int]) -> Failures:
    """Advance each world to its time; one that fails does not stop the others.

    Engines of one kind that take as many steps to their next samples take them with one call.

    Returns:
        The errors of the worlds that failed, by number, as their own ``run_until`` raises them.
    """
    failed: Failures = {}
    begun = [
        n
        for n, world in enumerate(worlds)
        if world.state is State.READY and not world.paused and world.now_ns < times_ns[n]
    ]
    for number in {*range(len(worlds))} - {*begun}:
        note_failure(failed, number, partial(worlds[number].run_until, times_ns[number]))
    for number in begun:
        note_failure(failed, number, partial(worlds[number].begin_advance, times_ns[number]))
    going = [number for number in begun if number not in failed]
    while going:
        for (kind, steps), chosen in _next_steps(worlds, times_ns, going).items():
            errors = kind.advance_all([worlds[number].engine for number in chosen], steps)
            failed |= {chosen[place]: error for place, error in errors.items()}
        for number in going:
            if number not in failed:
                try:
                    worlds[number].end_advance()
                except Exception as error:  # noqa: BLE001 - the caller decides about each copy
                    failed[number] = error
        going = [n for n in going if n not in failed and worlds[n].now_ns < times_ns[n]]
    for number in begun if failed else ():
        if number in failed:
            note_failure(failed, number, partial(worlds[number].fail, "advance", failed[number]))
    return failed


def release_together(worlds: Sequence[World]) -> Failures:
    """Release the messages that each world holds; return the errors by the numbers of the worlds."""
    return release_all([world._board for world in worlds])


def _next_steps(
    worlds: Sequence[World], times_ns: Sequence[int], going: Sequence[int]
) -> dict[tuple[type[Engine], int], list[int]]:
    """Return the numbers of the worlds by the kind of engine and the steps to its next stop."""
    found: dict[tuple[type[Engine], int], list[int]] = {}
    for number in going:
        world = worlds[number]
        engine = world.engine
        steps = (world.next_stop(times_ns[number]) - engine.now_ns) // engine.step_ns
        found.setdefault((type(engine), steps), []).append(number)
    return found


def commanded_elements(topic: TopicInfo) -> tuple[str, ...]:
    """Return the joints or muscles of a topic that commands a group, in the order of its numbers."""
    return topic.elements if topic.type is Float64MultiArray else ()


def threads_for(worlds: Sequence[World]) -> int:
    """Return the number of processors, or 1 if the engine or its renderer is bound to one thread."""
    for world in worlds:
        has = world.capabilities
        if not has.releases_gil or not set(has.renderers[:1]) <= set(SHARED):
            return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
