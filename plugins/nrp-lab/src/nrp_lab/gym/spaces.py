"""Observation and action spaces: messages, firing rates, commands and rates of sources, as bounded arrays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import ceil, isfinite, nan
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, flatdim, flatten_space

from nrp_core.brain import FloatArray, PoissonSource, PopulationRate
from nrp_core.clock import seconds
from nrp_core.errors import CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.messages.base import find_layout
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.recording import numbers_in
from nrp_core.world import Direction, Drive, Stamped, TopicInfo
from nrp_core.world.batch import commanded_elements

_LONGEST_WAIT_STEPS = 500


class Observed(ABC):
    """One observation.

    Attributes:
        space: its shape and bounds.
    """

    space: Box

    @abstractmethod
    def read(self) -> Any:
        """Return the current value, a new array in the space."""

    @staticmethod
    def read_all(copies: Sequence[Any], rows: Any) -> None:
        """Write the current values in copies of a run into the rows of an array."""
        for observed, row in zip(copies, rows, strict=True):
            row[...] = observed.read()


class ObservedRate(Observed):
    """The mean firing rate of a group of neurons, Hz, shape ``(1,)``."""

    def __init__(self, run: Run, group: str) -> None:
        neurons = neurons_of(run, group)
        self._port = run.brain.add_sink(PopulationRate(), neurons, name=f"gym/{group}")
        self._size = len(neurons)
        self.space = Box(0.0, np.inf, (1,), np.float64)

    def read(self) -> FloatArray:
        return np.array((self._port.rate / self._size,))  # type: ignore[attr-defined]

    @staticmethod
    def read_all(copies: Sequence[ObservedRate], rows: FloatArray) -> None:
        rows[:, 0] = [one._port.rate / one._size for one in copies]  # type: ignore[attr-defined]


class ObservedMotion(Observed):
    """Pose and velocity of a model in the frame of the world, shape ``(13,)``."""

    def __init__(self, run: Run, model: str) -> None:
        if not run.world.capabilities.poses:
            raise CapabilityError(f"the world does not report poses, so '{model}' cannot be observed")
        self._engine, self._model = run.world.engine, run.world.scene.model(model).name
        self.space = Box(-np.inf, np.inf, (13,), np.float64)

    def read(self) -> FloatArray:
        row = np.empty(13)
        self._engine.read_motion(self._model, row)
        return row

    @staticmethod
    def read_all(copies: Sequence[ObservedMotion], rows: FloatArray) -> None:
        first = copies[0]
        type(first._engine).read_motions([one._engine for one in copies], first._model, rows)


class ObservedJoints(Observed):
    """The positions, then the velocities of the joints of a model, shape ``(2 * joints,)``."""

    def __init__(self, run: Run, model: str) -> None:
        self._engine, self._model = run.world.engine, run.world.scene.model(model).name
        names = run.world.joint_states(self._model).names
        if not names:
            raise ExperimentError(f"the model '{model}' has no joints to observe")
        self._joints = len(names)
        self.space = Box(-np.inf, np.inf, (2 * len(names),), np.float64)

    def read(self) -> FloatArray:
        states = np.empty((3, self._joints))
        self._engine.read_joints(self._model, states)
        return states[:2].reshape(-1)

    @staticmethod
    def read_all(copies: Sequence[ObservedJoints], rows: FloatArray) -> None:
        first = copies[0]
        states = rows.reshape(len(copies), 2, first._joints)  # a view
        type(first._engine).read_joints_of([one._engine for one in copies], first._model, states)


class ObservedTopic(Observed):
    """The last message of a topic; all 0 before the first one arrives."""

    def __init__(self, run: Run, name: str) -> None:
        if name not in run.world.topics:
            known = [topic for topic, info in run.world.topics.items() if info.direction & Direction.OUT]
            raise ExperimentError(f"there is no topic '{name}' to observe{did_you_mean(name, known)}")
        self._subscription = run.world.subscribe(name)
        self.name = name

    def has_message(self) -> bool:
        """Return whether a message has arrived, so that the shape is known."""
        return self._subscription.latest is not None

    def learn(self) -> None:
        """Derive the shape and the bounds from the message that has arrived.

        Raises:
            ExperimentError: the messages have no numbers.
        """
        latest = self._subscription.latest
        assert latest is not None
        values = values_of(latest.message)
        if not values.size:
            raise ExperimentError(f"the messages of '{self.name}' have no numbers to observe")
        low, high = bounds_of(self._subscription.topic, latest.message)
        self.space = Box(low, high, values.shape, values.dtype.type)

    def read(self) -> Any:
        latest = self._subscription.latest
        if latest is None:
            return np.zeros_like(self.space.low)
        values = values_of(latest.message)
        return values if values.dtype == np.uint8 else values.clip(self.space.low, self.space.high)


class ObservedMessages(ObservedTopic):
    """All messages of a topic since the last observation, oldest first, shape ``(n, *shape of one)``.

    ``n`` is the largest number that a step of the environment can bring. After fewer messages, the first
    rows are 0.

    Args:
        run: the run.
        name: the topic, which must have a rate.
        steps: steps of the loop in one of the environment.
    """

    def __init__(self, run: Run, name: str, steps: int) -> None:
        super().__init__(run, name)
        rate_hz = self._subscription.topic.rate_hz
        if rate_hz is None:
            raise ExperimentError(f"the topic '{name}' has no rate; observe it as '{name}', without 'all:'")
        run.world.unsubscribe(self._subscription)
        self._subscription = run.world.subscribe(name, depth=None)
        self._world, self._last = run.world, (-1, list[Stamped]())
        self._most = ceil(rate_hz * seconds(run.experiment.timestep) * steps)

    def learn(self) -> None:
        super().learn()
        one = self.space
        low, high = (np.repeat(bound[np.newaxis], self._most, axis=0) for bound in (one.low, one.high))
        self.space = Box(low, high, low.shape, one.low.dtype.type)

    def read(self) -> Any:
        now_ns, taken = self._world.now_ns, self._subscription.take()
        if taken or now_ns != self._last[0]:  # otherwise it is read again, as when another copy is reset
            self._last = now_ns, taken
        rows = np.zeros_like(self.space.low)
        for row, stamped in zip(rows[::-1], self._last[1][::-1], strict=False):
            row[...] = values_of(stamped.message)
        return rows if rows.dtype == np.uint8 else rows.clip(self.space.low, self.space.high)


_ALL = "all:"
KINDS: dict[str, Callable[[Run, str], Observed]] = {
    "rate:": ObservedRate,
    "motion:": ObservedMotion,
    "joints:": ObservedJoints,
}
"""Observations that are not topics, by the beginning of their names."""


def _observed(run: Run, name: str, steps: int) -> Observed:
    if name.startswith(_ALL):
        return ObservedMessages(run, name.removeprefix(_ALL), steps)
    for prefix, kind in KINDS.items():
        if name.startswith(prefix):
            return kind(run, name.removeprefix(prefix))
    prefix, colon, _ = name.partition(":")
    if colon and name not in run.world.topics:
        raise ExperimentError(f"'{name}' cannot be observed{did_you_mean(prefix + colon, [*KINDS, _ALL])}")
    return ObservedTopic(run, name)


def observe(
    run: Run, names: Sequence[str], known: Mapping[str, Observed] | None = None, steps: int = 1
) -> dict[str, Observed]:
    """Subscribe to the observed topics only; the run is at time 0 before and after.

    Args:
        run: the run.
        names: names of the observations.
        known: the same observations of another run, whose messages have shown their shapes.
        steps: steps of the loop in one of the environment.

    Raises:
        ExperimentError: a topic, group or model does not exist, or no message arrives within 500 steps.
    """
    found = {name: _observed(run, name, steps) for name in names}
    if known is not None:
        for name, one in found.items():
            one.space = known[name].space
        return found
    topics = [one for one in found.values() if isinstance(one, ObservedTopic)]
    for _ in range(_LONGEST_WAIT_STEPS):
        silent = [one.name for one in topics if not one.has_message()]
        if not silent:
            break
        run.step()
    else:
        raise ExperimentError(f"no message arrives on {' and '.join(silent)}, so its shape is unknown")
    for one in topics:
        one.learn()
    run.loop.reset()
    return found


def neurons_of(run: Run, group: str) -> Any:
    """Return the neurons of a population or a named group.

    Raises:
        ExperimentError: the group does not exist.
    """
    network = run.brain.network
    if group in network.views:
        return network.views[group]
    if group in network.populations:
        return network.ids_of(group)
    hint = did_you_mean(group, [*network.views, *network.populations])
    raise ExperimentError(f"there is no group of neurons '{group}'{hint}")


def values_of(message: Any) -> Any:
    """Return the numbers of a message: an image or ranges unchanged, otherwise all its numbers."""
    if hasattr(message, "encoding"):
        return np.array(message.data, np.uint8).reshape(message.height, message.width, -1)
    if hasattr(message, "ranges"):
        return np.clip(np.asarray(message.ranges, np.float64), 0.0, message.range_max)
    values = getattr(message, "position", None)
    if isinstance(values, np.ndarray) and hasattr(message, "velocity"):
        return np.concatenate([values, np.asarray(message.velocity, np.float64)])
    return np.array([value for _, value in numbers_in(message)], np.float64)


def bounds_of(topic: TopicInfo, message: Any) -> tuple[Any, Any]:
    """Return the bounds of all numbers of :func:`values_of`."""
    if hasattr(message, "encoding"):
        return 0, 255
    if hasattr(message, "ranges"):
        return 0.0, float(message.range_max)
    return topic.limits or (-np.inf, np.inf)


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
        if ((rows >= self._low) & (rows <= self._high)).all() or not np.isfinite(rows).all():
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

    @property
    def topic(self) -> str | None:
        """The topic of an action that is the one number of its messages."""
        return None

    @staticmethod
    def apply_all(copies: Sequence[Any], rows: FloatArray) -> None:
        """Apply an action in several copies of a run, a row for each; only the first one warns."""
        for acted, values in zip(copies, copies[0]._rows_clipped(rows).tolist(), strict=True):
            acted.apply(values)


class ActedTopic(Acted):
    """Commands on a topic, published before each step.

    Args:
        run: the run.
        name: the topic.
        bounds: numbers of the message to set, by their names, or those of the muscles or joints of a group;
            the others are 0. By default all that a drive or group uses, with the limits of the topic.
    """

    def __init__(self, run: Run, name: str, bounds: Bounds | None) -> None:
        if name not in run.world.topics:
            known = [topic for topic, info in run.world.topics.items() if info.direction & Direction.IN]
            raise ExperimentError(f"there is no topic '{name}' to act on{did_you_mean(name, known)}")
        self._publication = run.world.advertise(name)
        info = self._publication.topic
        elements = commanded_elements(info)
        if find_layout(info.type) is None and not elements:
            raise ExperimentError(f"'{name}' carries not only numbers, so it cannot be an action")
        fields = [*elements] or [path for path, _ in numbers_in(info.type())]
        self._count, self._has_elements = len(fields), bool(elements)
        if bounds is not None and not isinstance(bounds, Mapping):
            raise ExperimentError(f"the bounds of '{name}' are {{'field': (low, high)}}, not {bounds!r:.60}")
        commanded = {
            drive.command_topic: (model.name, drive.components)
            for model in run.world.scene.models
            for drive in model.drives
            if isinstance(drive, Drive) and drive.components
        }
        model, used = commanded.get(info.name, ("", fields))
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

    @property
    def topic(self) -> str | None:
        return self._name if self._count == 1 and not self._has_elements else None

    def apply(self, values: Sequence[float]) -> None:
        numbers = [0.0] * self._count
        for place, value, (low, high) in zip(self._places, values, self._bounds, strict=True):
            within = low <= value <= high
            numbers[place] = value if within else self._clipped(self._places.index(place), value)
        if self._has_elements:
            self._publication.publish(Float64MultiArray(data=np.array(numbers)))
        else:
            self._publication.publish_numbers(numbers)


class ActedNumbers(Acted):
    """Several actions, each of which is the one number of the messages of a topic, published together.

    Args:
        run: the run.
        acted: the actions.
    """

    def __init__(self, run: Run, acted: Sequence[Acted]) -> None:
        self._acted = acted
        self._publication = run.world.advertise_together([one.topic for one in acted if one.topic])
        super().__init__("", [], [bound for one in acted for bound in one._bounds])

    def _rows_clipped(self, rows: FloatArray) -> FloatArray:
        if ((rows >= self._low) & (rows <= self._high)).all():
            return rows
        columns = [one._rows_clipped(rows[:, place : place + 1]) for place, one in enumerate(self._acted)]
        return np.concatenate(columns, axis=1)

    def apply(self, values: Sequence[float]) -> None:
        self.apply_all([self], np.array([values]))

    @staticmethod
    def apply_all(copies: Sequence[ActedNumbers], rows: FloatArray) -> None:
        publications = [one._publication for one in copies]
        publications[0].publish_all(publications, copies[0]._rows_clipped(rows))


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


class Layout:
    """Where the arrays of a space lie in the single one to which Gymnasium flattens them.

    Args:
        space: the arrays by their names.

    Attributes:
        space: the single array.

    Raises:
        ExperimentError: there are no arrays, so the space cannot be flattened.
    """

    def __init__(self, space: Dict) -> None:
        if not space.spaces:
            raise ExperimentError("flat=True needs at least one action; without it, the space is not a Box")
        self.space: Box = flatten_space(space)  # type: ignore[assignment]
        self._shapes = {name: one.shape or () for name, one in space.spaces.items()}
        self._places = places_of(space)

    def views(self, rows: Any) -> dict[str, Any]:
        """Return the arrays of all rows by their names, as views, shape ``(rows, *shape of one)``."""
        return {
            name: rows[:, place].reshape(len(rows), *self._shapes[name])
            for name, place in self._places.items()
        }

    def flatten(self, values: Mapping[str, Any]) -> Any:
        """Return arrays in one of their own."""
        return np.concatenate([np.ravel(values[name]) for name in self._places])


def places_of(space: Dict) -> dict[str, slice]:
    """Return the places of arrays in the single one to which Gymnasium flattens them."""
    places, end = {}, 0
    for name, one in space.spaces.items():
        places[name] = slice(end, end := end + flatdim(one))
    return places


def rows_of(actions: Any, space: Dict | Box) -> FloatArray:
    """Return actions as Gymnasium flattens them, a new array with a row for each copy.

    Args:
        actions: of all copies.
        space: what they must be.

    Raises:
        ExperimentError: one is missing, or has another shape.
    """
    if isinstance(space, Box):
        if np.shape(actions) != space.shape:
            given = f"{type(actions).__name__} of the shape {np.shape(actions)}"
            raise ExperimentError(f"flat actions are an array of the shape {space.shape}, not {given}")
        return np.array(actions, np.float64)
    rows = [np.empty((0, 0))]
    for name, one in space.spaces.items():
        if name not in actions:
            raise ExperimentError(f"there is no action for '{name}'; it is {one}")
        rows.append(np.asarray(actions[name], np.float64))
        if rows[-1].shape != one.shape:
            raise ExperimentError(f"the action '{name}' has the shape {one.shape}, not {rows[-1].shape}")
    return np.concatenate(rows[1:] or rows, axis=1)


class Actions:
    """The actions of a run, by name.

    Args:
        run: the run.
        acted: the actions; those that are numbers of topics are applied together.

    Attributes:
        space: the actions by their names.
    """

    def __init__(self, run: Run, acted: Mapping[str, Acted]) -> None:
        self.space = Dict({name: one.space for name, one in acted.items()})
        self._shapes = {name: acted[name].shape for name in self.space.spaces}
        places = places_of(self.space)
        numbers = [name for name in places if acted[name].topic is not None]
        together = numbers if len(numbers) > 1 else []
        names_of = [[name] for name in places if name not in together] + ([together] if together else [])
        self._parts: list[tuple[Acted, list[int]]] = []
        for names in names_of:
            columns = [column for name in names for column in range(places[name].start, places[name].stop)]
            several = ActedNumbers(run, [acted[name] for name in names]) if len(names) > 1 else None
            self._parts.append((several or acted[names[0]], columns))

    def apply(self, action: Any) -> None:
        """Apply a mapping with an array for each action.

        Raises:
            ExperimentError: one is missing, unknown, or has another shape.
        """
        # a dict is known without asking the abstract class
        if not isinstance(action, (dict, Mapping)) or action.keys() != self._shapes.keys():
            listed = ", ".join(map(repr, self._shapes)) or "nothing"
            raise ExperimentError(f"an action is a dict with an array for {listed}, not {action!r:.60}")
        values = [np.empty(0)]
        for name, shape in self._shapes.items():
            values.append(np.asarray(action[name], float))
            if values[-1].shape != shape:
                raise ExperimentError(f"the action '{name}' has the shape {shape}, not {values[-1].shape}")
        self.apply_all([self], np.concatenate(values)[np.newaxis])

    @staticmethod
    def apply_all(copies: Sequence[Actions], rows: FloatArray) -> None:
        """Apply actions in several copies of a run.

        Args:
            copies: the actions of the copies.
            rows: a row for each copy, as Gymnasium flattens its actions.
        """
        for place, (first, columns) in enumerate(copies[0]._parts):
            parts = [one._parts[place][0] for one in copies]
            first.apply_all(parts, rows if len(columns) == rows.shape[1] else rows[:, columns])
