"""The actions of an environment: commands on topics, and rates of sources that drive neurons."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from math import isfinite, nan
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.devices.trains import PoissonSource
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.running.run import Run
from nrp_core.recording.reading.tables import numbers_in
from nrp_core.world.batch import publish_rows
from nrp_core.world.drives.drive import commanded_components
from nrp_core.world.messages.base import find_layout
from nrp_core.world.topics import Direction
from nrp_lab.gym.observing import neurons_of

SOURCE = "source:"
_HIGHEST_HZ = 200.0
_WEIGHT = 1.0
_ROUNDING = 1e-6
"""Share of a span by which single precision may miss its end."""
Bounds = Mapping[str, tuple[float, float]]
"""The numbers of a message that an action sets, by their dotted names, with their bounds."""


class Acted(ABC):
    """One action.

    Args:
        name: its name in messages.
        fields: the names of its numbers.
        bounds: the lowest and highest value of each number.

    Attributes:
        space: its shape and bounds.
        shape: its shape, for a check in each step.
    """

    def __init__(self, name: str, fields: Sequence[str], bounds: Sequence[tuple[float, float]]) -> None:
        self._name, self._fields, self._bounds = name, fields, bounds
        self._low, self._high = np.array(bounds).T
        self.space = Box(self._low, self._high, dtype=np.float64)
        self.shape = (len(bounds),)
        self._has_warned = False

    def _clipped(self, field: int, value: float) -> float:
        """Return a value beyond its bounds clipped to them, as Gymnasium's own environments do."""
        if not isfinite(value):
            return value  # which is refused
        low, high = self._bounds[field]
        clipped = min(max(value, low), high)
        if abs(value - clipped) > _ROUNDING * (high - low):
            self._warn(field, value)
        return clipped

    def _rows_clipped(self, rows: FloatArray) -> FloatArray:
        """Return rows of values within their bounds, each as :meth:`_clipped` returns it."""
        if not np.isfinite(rows).all():
            return rows
        clipped = np.clip(rows, self._low, self._high)
        if not self._has_warned:
            beyond = np.abs(rows - clipped) > _ROUNDING * (self._high - self._low)
            for row, field in np.argwhere(beyond)[:1]:
                self._warn(field, rows[row, field])
        return clipped

    def _warn(self, field: int, value: float) -> None:
        """Warn of the first value that is clearly beyond its bounds."""
        if not self._has_warned:
            self._has_warned = True
            low, high = self._bounds[field]
            gymnasium.logger.warn(
                f"'{self._fields[field]}' of the action '{self._name}' is {value:g}; it is "
                f"clipped to its bounds, {low:g} to {high:g}, now and later"
            )

    @abstractmethod
    def apply(self, values: Sequence[float]) -> None:
        """Apply the action; it takes effect in the next step."""

    @staticmethod
    def apply_all(copies: Sequence[Any], rows: FloatArray) -> None:
        """Apply an action in several copies of a run, a row for each."""
        for acted, values in zip(copies, rows.tolist(), strict=True):
            acted.apply(values)


class ActedTopic(Acted):
    """Commands on a topic, published before each step.

    Args:
        run: the run.
        name: the topic.
        bounds: numbers of the message to set; the others are 0. By default all that a drive uses, with the
            limits of the topic.
    """

    def __init__(self, run: Run, name: str, bounds: Bounds | None) -> None:
        if name not in run.world.topics:
            known = [topic for topic, info in run.world.topics.items() if info.direction & Direction.IN]
            raise ExperimentError(f"there is no topic '{name}' to act on{did_you_mean(name, known)}")
        self._publication = run.world.advertise(name)
        info = self._publication.topic
        layout, example = find_layout(info.type), info.type()
        if layout is None:
            raise ExperimentError(f"'{name}' carries not only numbers, so it cannot be an action")
        self._count = len(layout.paths)
        fields = [path for path, _ in numbers_in(example)]
        if bounds is not None and not isinstance(bounds, Mapping):
            raise ExperimentError(f"the bounds of '{name}' are {{'field': (low, high)}}, not {bounds!r:.60}")
        model, used = commanded_components(run.world.scene).get(info.name, ("", fields))
        chosen = bounds if bounds is not None else dict.fromkeys(used, info.limits or (-1.0, 1.0))
        for field in chosen:
            if field not in fields:
                raise ExperimentError(
                    f"a message of '{name}' has no number '{field}'{did_you_mean(field, fields)}"
                )
            if field not in used:
                raise ExperimentError(
                    f"'{field}' of '{name}' moves nothing: the drive of '{model}' takes {' and '.join(used)}"
                )
        self._places = [fields.index(field) for field in chosen]
        super().__init__(name, [*chosen], [_pair(f"'{one}' of '{name}'", chosen[one]) for one in chosen])

    def apply(self, values: Sequence[float]) -> None:
        numbers = [0.0] * self._count
        for place, value, (low, high) in zip(self._places, values, self._bounds, strict=True):
            within = low <= value <= high
            numbers[place] = value if within else self._clipped(self._places.index(place), value)
        self._publication.publish_numbers(numbers)

    @staticmethod
    def apply_all(copies: Sequence[ActedTopic], rows: FloatArray) -> None:
        numbers = np.zeros((len(copies), copies[0]._count))
        numbers[:, copies[0]._places] = copies[0]._rows_clipped(rows)
        publish_rows([acted._publication for acted in copies], numbers)


class ActedSource(Acted):
    """The rate, Hz, of a Poisson source that drives a group of neurons."""

    def __init__(self, run: Run, group: str, bounds: tuple[float, float], weight: float) -> None:
        rates = _pair(f"the rate of '{group}'", bounds)
        if rates[0] < 0.0 or not isfinite(weight) or weight == 0.0:
            raise ExperimentError(
                f"'source:{group}' takes (lowest, highest, weight), with rates from 0 Hz on and a weight "
                f"that is not 0, not {(*bounds, weight)}"
            )
        neurons = neurons_of(run, group)
        self._port = run.brain.add_source(PoissonSource(weight=weight), neurons, name=f"gym/{group}")
        super().__init__(f"source:{group}", ["rate"], [rates])

    def apply(self, values: Sequence[float]) -> None:
        (rate,), ((low, high),) = values, self._bounds
        self._port.rate = rate if low <= rate <= high else self._clipped(0, rate)  # type: ignore[attr-defined]


def _pair(owner: str, bounds: Any) -> tuple[float, float]:
    """Return the bounds of an action.

    Raises:
        ExperimentError: they are no two finite numbers, the lower one first.
    """
    try:
        low, high = (float(bound) for bound in bounds)
    except (TypeError, ValueError):
        low = high = nan
    if not (isfinite(low) and isfinite(high) and low < high):
        raise ExperimentError(
            f"the bounds of {owner} are two numbers, the lower one first, not {bounds!r:.60}"
        )
    return low, high


def act_on(run: Run, names: Mapping[str, Any]) -> dict[str, Acted]:
    """Return the actions by their names.

    Raises:
        ExperimentError: a topic or group does not exist, or cannot be set by numbers.
    """
    found: dict[str, Acted] = {}
    for name, given in names.items():
        if name.startswith(SOURCE):
            low, high, weight = (*(given or (0.0, _HIGHEST_HZ)), _WEIGHT)[:3]
            found[name] = ActedSource(run, name.removeprefix(SOURCE), (low, high), weight)
        else:
            found[name] = ActedTopic(run, name, given)
    return found
