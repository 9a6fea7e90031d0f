"""Conditions of many copies of an experiment, evaluated by arrays as long as nothing can change.

An event or criterion waits, is open, or is over. A copy in which a condition may change its outcome, now or
before the next step of the loop, evaluates the step itself; so all results are those of a run alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, nan
from numbers import Real
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.observables.bodies import Displacement, OfPositions
from nrp_core.observables.condition import Sentence
from nrp_core.observables.positions import FAST_M_S, distances
from nrp_core.observables.topics import Field
from nrp_core.world.physics_observer import unchanged_ns

BoolArray = npt.NDArray[np.bool_]

NEVER: Final = 2**62
_NS_PER_M: Final = unchanged_ns(1.0, FAST_M_S)
"""For how long a distance that is 1 m from a limit cannot pass it."""


@dataclass(frozen=True, slots=True)
class Lane:
    """The state of a condition in one copy.

    Args:
        wakes_ns: the time from which the copy has to evaluate it itself.
        is_open: whether its value counts until then.
        numbers: what changes while it is open: the least gap and its distance, or the number of steps, of
            those in which it held, and the largest distance.
        decides: whether a change of its outcome decides something.
    """

    wakes_ns: int = 0
    is_open: bool = False
    numbers: tuple[float, float, float] = (0.0, 0.0, 0.0)
    decides: bool = True


ALONE: Final = Lane()
"""Of a condition that a copy evaluates itself in each step."""


@dataclass(frozen=True, slots=True)
class LaneKind:
    """What the lanes of one condition have in common; copies with equal kinds share arrays.

    Args:
        counts: whether steps are counted in which it holds, and not the least gap noted.
        may_be_silent: whether a missing value counts as one that holds.
        reaches: whether the bounds belong to the range.
        corners: the number of corners of the footprint whose distance is the value; 0: a field of a topic.
        model: the number of the model whose distance it is, among those that move.
    """

    counts: bool = False
    may_be_silent: bool = False
    reaches: bool = False
    corners: int = 0
    model: int = -1

    @classmethod
    def of(cls, sentence: Sentence, moving: Sequence[str], **counting: bool) -> LaneKind | None:
        """Return the kind of a condition; None for one that arrays cannot evaluate."""
        observable, condition = sentence.observable, sentence.condition
        if condition.equals is not None or condition.above is condition.below is None:
            return None
        if isinstance(observable, Field):
            is_number = number_of(observable.example) is not None and observable.unchanged_ns(abs) is None
            return cls(**counting, reaches=condition.reaches) if is_number else None
        if not isinstance(observable, OfPositions) or observable.model not in moving:
            return None
        target = observable.distance_to()
        if target is None and not isinstance(observable, Displacement):
            return None
        corners = 1 if target is None else len(target.corners)
        model = moving.index(observable.model)
        return cls(**counting, reaches=condition.reaches, corners=corners, model=model)


def number_of(value: Any) -> float | None:
    """Return a value as a number: NaN for none; None for another kind of value."""
    if value is None:
        return nan
    return float(value) if isinstance(value, Real) and not isinstance(value, bool) else None


class Column:
    """One condition in all copies."""

    def __init__(self, kind: LaneKind | None) -> None:
        self.kind = kind
        self._arrays: dict[str, npt.NDArray[Any]] = {
            "wakes_ns": np.zeros(0, np.int64),
            "flags": np.zeros((0, 2), np.bool_),  # is_open, decides
            "bounds": np.zeros((0, 3)),  # above, below, the radius of the footprint
            "corners": np.zeros((0, kind.corners if kind else 0, 2)),
            "numbers": np.zeros((0, 3)),
            "values": np.zeros(0),
            "gaps": np.zeros(0),
        }
        self.fields: dict[int, Field] = {}

    def grow(self, more: int) -> None:
        """Make room for more copies."""
        for name, array in self._arrays.items():
            self._arrays[name] = np.concatenate([array, np.zeros((more, *array.shape[1:]), array.dtype)])

    def enter(self, row: int, lane: Lane, sentence: Sentence | None) -> None:
        """Set the state of a copy."""
        arrays = self._arrays
        arrays["wakes_ns"][row], arrays["flags"][row] = lane.wakes_ns, (lane.is_open, lane.decides)
        arrays["numbers"][row] = lane.numbers
        self.fields.pop(row, None)
        if not lane.is_open or sentence is None:
            return
        if self.kind is None:
            arrays["wakes_ns"][row] = 0  # arrays cannot evaluate it
            return
        condition, observable = sentence.condition, sentence.observable
        above, below, radius = condition.above, condition.below, 0.0
        if isinstance(observable, Field):
            self.fields[row] = observable
            arrays["values"][row] = number_of(observable.last)
        elif isinstance(observable, OfPositions):
            target = observable.distance_to()
            if target is None:  # it is not known before its first value
                arrays["wakes_ns"][row] = 0
                return
            arrays["corners"][row], radius = target.corners, target.radius
        arrays["bounds"][row] = -inf if above is None else above, inf if below is None else below, radius

    def hear(self, row: int, now_ns: int) -> None:
        """Receive the messages of a copy; one that came before now is left to the copy."""
        field = self.fields[row]
        times_ns = field.news_ns
        if not times_ns:
            return
        value = number_of(field.value(now_ns)) if min(times_ns) == now_ns else None
        if value is None:
            self._arrays["wakes_ns"][row] = 0
        else:
            self._arrays["values"][row] = value

    def are_quiet(self, rows: IntArray, now_ns: IntArray, points: FloatArray, period_ns: int) -> BoolArray:
        """Evaluate copies; return in which of them the outcome cannot change before the next step.

        Args:
            rows: the rows of the copies.
            now_ns: the time of each.
            points: the places of the models that move, shape ``(copies, models, 2)``.
            period_ns: one step of the loop.
        """
        kind, arrays = self.kind, self._arrays
        quiet: BoolArray = now_ns < arrays["wakes_ns"][rows]
        is_open, decides = arrays["flags"][rows].T
        if kind is None or not is_open.any():
            return quiet
        above, below, radius = arrays["bounds"][rows].T
        if kind.corners:
            values = distances(arrays["corners"][rows], radius, points[:, kind.model])
            arrays["values"][rows] = values
        else:
            values = arrays["values"][rows]
        gaps = np.maximum(above - values, values - below)
        holds = gaps <= 0.0 if kind.reaches else gaps < 0.0
        if kind.may_be_silent:
            holds |= np.isnan(values)
        arrays["gaps"][rows] = np.where(holds, -1.0, 1.0) if kind.counts else gaps
        stays = holds if kind.counts else ~holds
        if kind.corners:
            room = np.minimum(abs(values - above), abs(values - below))
            stays &= room * _NS_PER_M > period_ns + 1
        quiet &= ~is_open | ~decides | stays
        return quiet

    def count(self, rows: IntArray) -> None:
        """Count the step that was evaluated last in copies in which all is quiet."""
        arrays = self._arrays
        chosen = rows[arrays["flags"][rows, 0]]
        if self.kind is None or not len(chosen):
            return
        gaps, values = arrays["gaps"][chosen], arrays["values"][chosen]
        numbers = arrays["numbers"][chosen]
        if self.kind.counts:
            numbers[:, 0] += 1.0
            numbers[:, 1] += gaps < 0.0
            decides = arrays["flags"][chosen, 1]
            numbers[decides, 2] = np.fmax(numbers[decides, 2], values[decides])
        else:
            nearer = gaps < numbers[:, 0]
            numbers[nearer, 0], numbers[nearer, 1] = gaps[nearer], values[nearer]
        arrays["numbers"][chosen] = numbers

    def state(self, row: int) -> tuple[list[float], float | None] | None:
        """Return the numbers and the last value of a copy; None: they did not change."""
        if not self._arrays["flags"][row, 0]:
            return None
        value = self._arrays["values"].item(row)
        return self._arrays["numbers"][row].tolist(), None if value != value else value
