"""The bounded queue of messages to one client."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from nrp_cockpit.wire.channels import Kind, Sent

MOST_BYTES = 8_000_000
"""Bound for messages that must not be skipped; about four seconds of 20 000 spikes/s and all else."""


class Outbox:
    """Holds the messages to a client until it takes them, in order of arrival.

    On a channel where the latest wins at most one message waits: a newer one replaces it. On other channels
    all wait up to a bound; messages beyond it are dropped and counted. A message above the bound waits alone.
    Answers to the client's requests are never dropped and go first; only the latest time is kept. The past of
    a topic goes before all newer messages and has no bound of its own: its messages are in memory anyway.

    Args:
        most_bytes: the bound.

    Attributes:
        dropped: number of dropped messages since the beginning.
        lost: the subscriptions that have lost messages since their past was sent.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self.dropped = 0
        self.lost: set[int] = set()
        self._most_bytes, self._bytes = most_bytes, 0
        self._clock: bytes | None = None
        self._answers: deque[str | bytes] = deque()
        self._past: deque[tuple[int, Sent]] = deque()
        self._queue: deque[tuple[int, Sent | None]] = deque()  # None: the latest message of that subscription
        self._latest: dict[int, Sent] = {}

    def __bool__(self) -> bool:
        return bool(self._answers or self._past or self._queue or self._clock)

    def answer(self, frame: str | bytes) -> None:
        """Add an answer or an announcement."""
        self._answers.append(frame)

    def tick(self, frame: bytes) -> None:
        """Set the time."""
        self._clock = frame

    def add(self, subscription_id: int, sent: Sent) -> None:
        """Add a message for one of the client's subscriptions."""
        if sent.channel.kind is Kind.LATEST:
            if subscription_id in self._latest:
                self._drop(subscription_id)
            else:
                self._queue.append((subscription_id, None))
            self._latest[subscription_id] = sent
        elif self._bytes and self._bytes + sent.size > self._most_bytes:
            self._drop(subscription_id)
        else:
            self._bytes += sent.size
            self._queue.append((subscription_id, sent))

    def recall(self, subscription_id: int, past: Iterable[tuple[int, Sent]]) -> None:
        """Send the past of a subscription in place of its waiting messages.

        Args:
            subscription_id: the subscription.
            past: messages with their subscriptions.
        """
        self.forget(subscription_id)
        self._past.extend(past)

    def forget(self, subscription_id: int) -> None:
        """Remove the messages of a subscription that has ended."""
        self.lost.discard(subscription_id)
        self._latest.pop(subscription_id, None)
        self._past = deque(waiting for waiting in self._past if waiting[0] != subscription_id)
        self._queue = deque(waiting for waiting in self._queue if waiting[0] != subscription_id)
        self._bytes = sum(sent.size for _, sent in self._queue if sent is not None)

    def take(self) -> str | bytes | tuple[int, Sent]:
        """Remove and return the next message.

        Raises:
            IndexError: the queue is empty.
        """
        if self._answers:
            return self._answers.popleft()
        if self._clock is not None:
            clock, self._clock = self._clock, None
            return clock
        if self._past:
            return self._past.popleft()
        number, sent = self._queue.popleft()
        if sent is None:
            return number, self._latest.pop(number)
        self._bytes -= sent.size
        return number, sent

    def _drop(self, subscription_id: int) -> None:
        self.dropped += 1
        self.lost.add(subscription_id)
