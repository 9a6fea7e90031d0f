"""Events of a running experiment: each happens once, at its time or when its condition holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from nrp_core.experiment.events.conditions import Condition, Times
from nrp_core.experiment.events.values import to_message
from nrp_core.experiment.model.event_schema import Publish
from nrp_core.world.world import World

Action = Callable[[], None]
"""An action of an event."""


def action_of(publish: Publish, world: World) -> Action:
    """Return a function that publishes a message.

    Raises:
        TopicError: the topic does not exist, cannot be published on, or the value does not fit it.
    """
    publication = world.advertise(publish.topic)
    message = to_message(publication.topic, publish.value)
    return partial(publication.publish, message)


class Events:
    """The events of a running experiment.

    They happen between two steps, so that a message published at ``t`` acts from ``t`` on. Events at the same
    time happen in the order in which they were added, but an event that waits for another one comes after it.
    """

    def __init__(self) -> None:
        self._all: dict[str, tuple[Condition, Sequence[Action]]] = {}
        self.reset()

    def reset(self) -> None:
        """Reset to time 0, without past events."""
        self._waiting = dict(self._all)
        self._times: dict[str, int] = {}

    @property
    def names(self) -> list[str]:
        """Names of all events, in the order in which they were added."""
        return list(self._all)

    @property
    def times(self) -> Times:
        """Times of past events, ns, in order."""
        return self._times

    def restore(self, times: Times) -> None:
        """Restore the state after these events."""
        self._times = dict(times)
        self._waiting = {name: event for name, event in self._all.items() if name not in times}

    def add(self, name: str, condition: Condition, actions: Sequence[Action] = ()) -> None:
        """Add an event.

        Args:
            name: its name.
            condition: its condition.
            actions: its actions, in order.
        """
        self._all[name] = self._waiting[name] = condition, actions

    def fire_due(self, now_ns: int) -> list[str]:
        """Execute all events that are due now; return their names, in order."""
        fired: list[str] = []
        while due := [name for name, (holds, _) in self._waiting.items() if holds(now_ns, self._times)]:
            for name in due:
                _, actions = self._waiting.pop(name)
                self._times[name] = now_ns
                for action in actions:
                    action()
            fired += due
        return fired
