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
from nrp_core.brain.network.implausible import too_strong
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.running.run import Run
from nrp_core.gym.observing import neurons_of
from nrp_core.recording.reading.columns import numbers_in
from nrp_core.world.batch import layout_of, publish_rows
from nrp_core.world.topics import Direction

SOURCE = "source:"
_HIGHEST_HZ = 200.0
_WEIGHT = 1.0
Bounds = Mapping[str, tuple[float, float]]
"""The numbers of a message that an action sets, by their dotted names, with their bounds."""


class Acted(ABC):
    """One action.

    Attributes:
        space: its shape and bounds.
    """

    space: Box

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
        bounds: numbers of the message to set; the others are 0. By default all, with the limits of the topic.
    """

    def __init__(self, run: Run, name: str, bounds: Bounds | None) -> None:
        if name not in run.world.topics:
            known = [topic for topic, info in run.world.topics.items() if info.direction & Direction.IN]
            raise ExperimentError(f"there is no topic '{name}' to act on{did_you_mean(name, known)}")
        self._publication = run.world.advertise(name)
        info = self._publication.topic
        layout, example = layout_of(info.type()), info.type()
        if layout is None:
            raise ExperimentError(f"'{name}' carries not only numbers, so it cannot be an action")
        self._layout = layout
        fields = [path for path, _ in numbers_in(example)]
        if bounds is not None and not isinstance(bounds, Mapping):
            raise ExperimentError(f"the bounds of '{name}' are {{'field': (low, high)}}, not {bounds!r:.60}")
        chosen = bounds if bounds is not None else dict.fromkeys(fields, info.limits or (-1.0, 1.0))
        for field in chosen:
            if field not in fields:
                raise ExperimentError(
                    f"a message of '{name}' has no number '{field}'{did_you_mean(field, fields)}"
                )
        self._places = [fields.index(field) for field in chosen]
        low, high = np.array([_pair(f"'{field}' of '{name}'", chosen[field]) for field in chosen]).T
        self.space = Box(low, high, dtype=np.float64)

    def apply(self, values: Sequence[float]) -> None:
        row = [0.0] * self._layout.numbers
        for place, value in zip(self._places, values, strict=True):
            row[place] = value
        self._publication.publish(self._layout.made_of(iter(row)))

    @staticmethod
    def apply_all(copies: Sequence[ActedTopic], rows: FloatArray) -> None:
        layout = copies[0]._layout
        numbers = np.zeros((len(copies), layout.numbers))
        numbers[:, copies[0]._places] = rows
        publish_rows([acted._publication for acted in copies], layout, numbers)


class ActedSource(Acted):
    """The rate, Hz, of a Poisson source that drives a group of neurons."""

    def __init__(self, run: Run, group: str, bounds: tuple[float, float], weight: float) -> None:
        low, _ = _pair(f"the rate of '{group}'", bounds)
        if low < 0.0 or not isfinite(weight) or weight == 0.0:
            raise ExperimentError(
                f"'source:{group}' takes (lowest, highest, weight), with rates from 0 Hz on and a weight "
                f"that is not 0, not {(*bounds, weight)}"
            )
        neurons, network = neurons_of(run, group), run.brain.network
        self._port = run.brain.add_source(PoissonSource(weight=weight), neurons, name=f"gym/{group}")
        driven = (one for one in network.populations if np.isin(network.ids_of(one), neurons).any())
        if wrong := next(
            filter(None, (too_strong(abs(weight), network.populations[one]) for one in driven)), ""
        ):
            gymnasium.logger.warn(
                f"the weight of 'source:{group}' is {wrong} Bounds are (lowest, highest, weight)"
            )
        self.space = Box(*bounds, (1,), np.float64)

    def apply(self, values: Sequence[float]) -> None:
        self._port.rate = values[0]  # type: ignore[attr-defined]


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
