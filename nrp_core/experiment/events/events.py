"""Events of a running experiment: each happens once, at its time or when its condition holds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from nrp_core.experiment.events.conditions import Condition, Times
from nrp_core.experiment.events.values import to_message
from nrp_core.experiment.model.event_schema import Publish
from nrp_core.world.world import World

Action = Callable[[], None]
"""What happens in an event."""


def action_of(publish: Publish, world: World) -> Action:
    """Return what publishes a message.

    Raises:
        TopicError: the topic does not exist, takes no messages, or cannot carry the value.
    """
    publication = world.advertise(publish.topic)
    message = to_message(publication.topic, publish.value)
    return partial(publication.publish, message)


class Events:
    """The events of a running experiment.

    They happen between two steps, so that what one publishes at ``t`` acts from ``t`` on. Those that fall
    on one time happen in the order in which they were added, but an event that waits for another one
    comes after it, wherever it stands.
    """

    def __init__(self) -> None:
        self._all: dict[str, tuple[Condition, Sequence[Action]]] = {}
        self.reset()

    def reset(self) -> None:
        """Begin anew at time 0: nothing has happened."""
        self._waiting = dict(self._all)
        self._times: dict[str, int] = {}

    @property
    def times(self) -> Times:
        """When each event that has happened did, ns, in the order in which they did."""
        return self._times

    def restore(self, times: Times) -> None:
        """Go back to when these events had happened, and no others."""
        self._times = dict(times)
        self._waiting = {name: event for name, event in self._all.items() if name not in times}

    def add(self, name: str, condition: Condition, actions: Sequence[Action] = ()) -> None:
        """Wait for an event from now on.

        Args:
            name: what it is called.
            condition: when it happens.
            actions: what happens then, in this order.
        """
        self._all[name] = self._waiting[name] = condition, actions

    def fire_due(self, now_ns: int) -> list[str]:
        """Let everything happen that is due now; return the names, in order."""
        fired: list[str] = []
        while due := [name for name, (holds, _) in self._waiting.items() if holds(now_ns, self._times)]:
            for name in due:
                _, actions = self._waiting.pop(name)
                self._times[name] = now_ns
                for action in actions:
                    action()
            fired += due
        return fired
