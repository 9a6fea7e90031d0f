"""The topics of an environment: observations, actions, rewards, ends of episodes, and its image."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import inf, nextafter
from typing import Any

import numpy as np

from nrp_core.clock import NS_PER_S
from nrp_core.errors import CapabilityError, ExperimentError, TopicError
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Bool, Float64, Int32
from nrp_core.world import Direction, Part, TopicInfo
from nrp_world_gymnasium.channels import Channel, assembled, channels_of, image_of, value_at
from nrp_world_gymnasium.episodes import Episodes
from nrp_world_gymnasium.options import GymnasiumOptions

ROOT = "/env"
OBSERVATION, ACTION, IMAGE = f"{ROOT}/observation", f"{ROOT}/action", f"{ROOT}/image"


class EnvironmentPart(Part):
    """Publishes every observation, and receives actions, which hold until the next ones.

    A space that consists of others has a topic for each, such as ``/env/observation/direction``.

    Args:
        episodes: the environment; receives its first action.
        options: the options of the experiment.
    """

    def __init__(self, episodes: Episodes, options: GymnasiumOptions) -> None:
        self._episodes = episodes
        self._space = episodes.env.action_space
        self._rate_hz = _rate(options.timestep)
        self._reads: dict[str, Callable[[], Any]] = {}
        topics = [self._observed(each) for each in self._channels(OBSERVATION)]
        self._acted = {_topic(ACTION, each): each for each in self._channels(ACTION)}
        topics += [
            TopicInfo(name, each.type, Direction.IN, None, "action of the next steps", limits=each.limits)
            for name, each in self._acted.items()
        ]
        topics += self._about_the_episode()
        if options.image:
            topics.append(self._published(IMAGE, Image, "the environment", self._image))
        self.topics = tuple(topics)
        self._values = {each.path: each.first for each in self._acted.values()}
        if options.first_action is not None:
            self._set_first(options.first_action)
        episodes.first = episodes.action = assembled(self._space, self._values)

    def read(self, topic: str, now_ns: int) -> Any:
        return self._reads[topic]()

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self._values[self._acted[topic].path] = self._decoded(topic, message)
        self._episodes.action = assembled(self._space, self._values)

    def reset(self) -> None:
        self._values = {path: value_at(self._episodes.action, path) for path in self._values}

    def restore(self, saved: Any) -> None:
        self.reset()

    def _channels(self, root: str) -> list[Channel]:
        if root == ACTION:
            found = list(channels_of(self._space, self._space.sample()))
            lacking = [each for each in found if each.first is None]
            if lacking:
                raise CapabilityError(f"no action is a {lacking[0].type.__name__} ({self._space})")
            return found
        return list(channels_of(self._episodes.env.observation_space, self._episodes.observation))

    def _observed(self, channel: Channel) -> TopicInfo:
        def read() -> Any:
            return channel.encode(value_at(self._episodes.observation, channel.path))

        return self._published(_topic(OBSERVATION, channel), channel.type, "observation", read)

    def _about_the_episode(self) -> list[TopicInfo]:
        episodes = self._episodes
        return [
            self._published(f"{ROOT}/{name}", kind, what, read)
            for name, kind, what, read in (
                ("reward", Float64, "reward of the last step", lambda: Float64(episodes.reward)),
                ("return", Float64, "sum of rewards in the episode", lambda: Float64(episodes.total)),
                ("episode", Int32, "number of the episode, from 0", lambda: Int32(episodes.number)),
                ("terminated", Bool, "whether a final state is reached", lambda: Bool(episodes.terminated)),
                ("truncated", Bool, "whether the episode was cut", lambda: Bool(episodes.truncated)),
            )
        ]

    def _published(self, name: str, kind: type, what: str, read: Callable[[], Any]) -> TopicInfo:
        self._reads[name] = read
        return TopicInfo(name, kind, Direction.OUT, self._rate_hz, what)

    def _image(self) -> Image:
        pixels: Any = self._episodes.env.render()
        return image_of(pixels)

    def _decoded(self, topic: str, message: Any) -> Any:
        try:
            return self._acted[topic].decode(message)
        except TopicError as error:
            raise TopicError(f"{topic}: {error.message}") from None

    def _set_first(self, given: float | list[float]) -> None:
        """Set the first action from the options."""
        if len(self._acted) != 1:
            raise ExperimentError(f"'first_action' is for an action of one topic, not {len(self._acted)}")
        ((path, first),) = self._values.items()
        values = np.asarray(given, np.float64)
        if values.size != np.size(first):
            raise ExperimentError(f"'first_action' needs {np.size(first)} numbers, not {values.size}")
        action = values.reshape(np.shape(first)).astype(first.dtype)[()]
        if not np.array_equal(action, values.reshape(np.shape(first))) or action not in self._space:
            raise ExperimentError(f"'first_action' must be in {self._space}, not {given}")
        self._values[path] = action


def _topic(root: str, channel: Channel) -> str:
    return "/".join((root, *map(str, channel.path)))


def _rate(step_ns: int) -> float:
    """Return the rate that samples each step, Hz: rounded up, so that rounding omits no sample."""
    rate_hz = NS_PER_S / step_ns
    exact = Fraction(NS_PER_S, step_ns)
    return rate_hz if Fraction(repr(rate_hz)) >= exact else nextafter(rate_hz, inf)
