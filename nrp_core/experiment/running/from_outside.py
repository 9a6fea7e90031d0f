"""Messages from outside that are never delivered, or that a function replaces at once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from typing import Any, Final

from nrp_core.cle.engine import ClosedLoop
from nrp_core.clock import seconds
from nrp_core.experiment.running.problems import Reporter
from nrp_core.findings import Code, Finding, Level

_logger = logging.getLogger(__name__)
_EVERY_OTHER: Final = 2
"""Who publishes in every other step or more replaces the commands of functions deliberately."""


def watch_outside(loop: ClosedLoop, reporters: list[Reporter], on_close: list[Callable[[], None]]) -> None:
    """Add messages from outside that are lost to the findings of a run, and log them as it is closed."""
    outside = FromOutside(loop)
    reporters.append(outside.findings)
    on_close.append(outside.tell)


class FromOutside:
    """Finds messages from outside without the effect that they were meant to have.

    Args:
        loop: the loop that delivers them.
    """

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self._counts: dict[str, int] = {}
        self._first: dict[str, int] = {}
        loop.hooks.from_outside.append(self._count)
        loop.hooks.after_reset.append(self._reset)

    def _reset(self, loop: ClosedLoop) -> None:
        self._counts.clear()
        self._first.clear()

    def _count(self, topic: str, message: Any) -> None:
        self._counts[topic] = self._counts.get(topic, 0) + 1
        self._first.setdefault(topic, self._loop.steps)

    def findings(self) -> Iterator[Finding]:
        """Yield a finding for each topic with such messages so far."""
        loop = self._loop
        yield from self._undelivered()
        for topic, count in self._counts.items():
            names = self._publishers(topic)
            if names and count * _EVERY_OTHER < loop.steps - self._first[topic]:
                message = (
                    f"{count} message{'s' * (count != 1)} on '{topic}' from outside lasted until "
                    f"{', '.join(names)} published on it, too, at the end of the step"
                )
                yield Finding(Code.NRP282, message, Level.NOTE, subject=topic)

    def tell(self) -> None:
        """Log the messages that no step has taken, as the run is closed."""
        for finding in self._undelivered():
            _logger.warning("%s", finding.message)

    def _undelivered(self) -> Iterator[Finding]:
        """Yield a finding for each topic with messages that wait for a step."""
        for topic in sorted(set(self._loop.waiting)):
            message = (
                f"a message on '{topic}' was published at {seconds(self._loop.now_ns):g} s, and no step was "
                "taken since: publish before the step in which it is to act"
            )
            yield Finding(Code.NRP282, message, Level.WARNING, subject=topic)

    def _publishers(self, topic: str) -> list[str]:
        """Return the active functions that publish on a topic, quoted."""
        world = self._loop.world
        return [
            f"'{one.name}'"
            for one in self._loop.functions
            if one.active and any(world.advertise(each.name).topic.name == topic for each in one.published)
        ]
