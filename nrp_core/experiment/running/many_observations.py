"""Observations of the runs of many copies of an experiment, by one pass over arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.experiment.events.lanes import BoolArray, Column
from nrp_core.experiment.running.observation import Observation

_PATIENCE: Final = 8
"""Most steps that a copy evaluates itself where arrays cannot; fewer after a step in which they could."""

Kinds: TypeAlias = tuple[Any, ...]


class ManyObservations:
    """Evaluates the present time of those of many copies in which nothing happens.

    The others are left as they are; each evaluates the step itself, with the same results.
    """

    def __init__(self) -> None:
        self._tables: dict[Kinds, Table] = {}

    def evaluate(self, observations: Sequence[Observation]) -> None:
        """Evaluate the time that each has reached."""
        batches: dict[Table, list[Observation]] = {}
        for one in observations:
            if not one.watch.is_lent or one.trail is None or one.trail.scene is not one.engine.scene:
                one.table = self._lend(one)
            if one.table is not None:
                batches.setdefault(one.table, []).append(one)
        for table, some in batches.items():
            table.evaluate(some)

    def _lend(self, one: Observation) -> Table | None:
        """Give the state of a copy to arrays; None: it continues alone."""
        if one.waits_alone():
            return None
        trail = one.find_trail()
        if trail is None:
            return None
        kinds = one.period_ns, trail.kind, one.watch.lane_kinds()
        if kinds not in self._tables:
            self._tables[kinds] = Table(*kinds)
        table = self._tables[kinds]
        table.enter(one)
        return table


class Table:
    """The states of copies whose observations are alike; a row for each copy.

    Args:
        period_ns: one step of the loop.
        trail: the number of models that move, and of their joints.
        kinds: how arrays can evaluate each event and criterion.
    """

    def __init__(self, period_ns: int, trail: tuple[int, bytes], kinds: Kinds) -> None:
        self._period_ns = period_ns
        self._models = trail[0]
        self._columns = [Column(kind) for kind in kinds]
        self._rows: dict[Observation, int] = {}
        self._least_m = np.empty((0, self._models))
        self._known: list[Observation] = []
        self._places: tuple[IntArray, list[FloatArray], IntArray] = (np.empty(0, int), [], np.empty(0, int))

    def enter(self, one: Observation) -> None:
        """Enter the present state of a copy."""
        row = self._rows.setdefault(one, len(self._rows))
        if row >= len(self._least_m):
            more = max(64, len(self._least_m))
            self._least_m = np.concatenate([self._least_m, np.empty((more, self._models))])
            for column in self._columns:
                column.grow(more)
        self._least_m[row] = one.falls.limits_m(one.watch.where.moving)
        one.watch.lend(self._columns, row, one.engine.now_ns)
        self._known = []

    def evaluate(self, observations: list[Observation]) -> None:
        """Evaluate the present time of copies."""
        if observations != self._known:
            self._known = observations
            rows = np.array([self._rows[one] for one in observations])
            trails = [one.trail for one in observations if one.trail is not None]
            self._places = rows, [trail.positions for trail in trails], trails[0].places
        rows, positions, places = self._places
        now_ns = np.array([one.engine.now_ns for one in observations])
        numbers = np.concatenate(positions).reshape(len(rows), -1).take(places, axis=1)
        poses = numbers[:, : 7 * self._models].reshape(len(rows), self._models, 7)
        quiet = self._are_quiet(observations, rows, now_ns, poses)
        chosen = rows[quiet]
        for column in self._columns:
            column.count(chosen)
        whole, size = numbers.tobytes(), numbers.strides[0]
        for number, is_quiet in enumerate(quiet.tolist()):
            one = observations[number]
            if is_quiet:
                one.pass_quietly(whole[number * size : (number + 1) * size], poses[number])
            else:
                one.watch.take_back()
                one.alone_for, one.patience = one.patience, min(2 * one.patience, _PATIENCE)

    def _are_quiet(
        self, observations: Sequence[Observation], rows: IntArray, now_ns: IntArray, poses: FloatArray
    ) -> BoolArray:
        quiet: BoolArray = np.all(poses[:, :, 2] >= self._least_m[rows], axis=1)
        for column in self._columns:
            if column.fields:
                for row, t_ns in zip(rows.tolist(), now_ns.tolist(), strict=True):
                    if row in column.fields:
                        column.hear(row, t_ns)
            quiet &= column.are_quiet(rows, now_ns, poses[:, :, :2], self._period_ns)
        quiet &= np.array([not one.watch.has_looked for one in observations])
        return quiet
