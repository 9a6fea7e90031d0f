"""The observations of an environment: messages and firing rates, as arrays of known shape and bounds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.devices.sinks import PopulationRate
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.events.ground_positions import require_poses
from nrp_core.experiment.running.run import Run
from nrp_core.recording.reading.tables import numbers_in
from nrp_core.world.batch_engine import batch_engine_of
from nrp_core.world.topics import Direction, TopicInfo

_IMAGE = "sensor_msgs/msg/Image"
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
        require_poses(run.world)
        self._engine, self._model = run.world.engine, run.world.scene.model(model).name
        self.space = Box(-np.inf, np.inf, (13,), np.float64)

    def read(self) -> FloatArray:
        row = np.empty(13)
        self._engine.read_motion(self._model, row)
        return row

    @staticmethod
    def read_all(copies: Sequence[ObservedMotion], rows: FloatArray) -> None:
        batch_engine_of([observed._engine for observed in copies]).read_motions(copies[0]._model, rows)


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


KINDS: dict[str, Callable[[Run, str], Observed]] = {
    "rate:": ObservedRate,
    "motion:": ObservedMotion,
    "joints:": ObservedJoints,
}
"""Observations that are not topics, by the beginning of their names."""


def _observed(run: Run, name: str) -> Observed:
    for prefix, kind in KINDS.items():
        if name.startswith(prefix):
            return kind(run, name.removeprefix(prefix))
    prefix, colon, _ = name.partition(":")
    if colon and name not in run.world.topics:
        raise ExperimentError(f"'{name}' cannot be observed{did_you_mean(prefix + colon, KINDS)}")
    return ObservedTopic(run, name)


def observe(
    run: Run, names: Sequence[str], known: Mapping[str, Observed] | None = None
) -> dict[str, Observed]:
    """Subscribe to the observed topics only; the run is at time 0 before and after.

    Args:
        run: the run.
        names: names of the observations.
        known: the same observations of another run, whose messages have shown their shapes.

    Raises:
        ExperimentError: a topic, group or model does not exist, or no message arrives within 500 steps.
    """
    found = {name: _observed(run, name) for name in names}
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
        return np.minimum(np.asarray(message.ranges, np.float64), message.range_max)
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
