"""Receive messages in ROS 2 in a separate thread."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from nrp_core.clock import NS_PER_S
from nrp_core.errors import SimulationError
from nrp_core.world import Closing
from nrp_core.world.messages.cdr import Codec

from nrp_world_ros.inbox import Inbox, Letter

_AT_ONCE = 64
"""Number of messages of a topic that are taken at a time."""

_GONE = "a node that has left"


class Mail(Closing):
    """Puts received messages into an inbox.

    DDS delivers in its own threads, which must not be blocked, so a separate thread waits for messages.

    Args:
        participant: the participant of DDS.
        inbox: receives the messages.
        codec: decodes them.
    """

    def __init__(self, participant: Any, inbox: Inbox, codec: Codec) -> None:
        from cyclonedds.core import GuardCondition, WaitSet

        self._participant, self._inbox, self._codec = participant, inbox, codec
        self._readers: dict[str, _Reader] = {}
        self._taking = threading.Lock()
        self._waiting = WaitSet(participant)
        self._end = GuardCondition(participant)
        self._waiting.attach(self._end)
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="ros2", daemon=True)
        self._thread.start()

    def ends(self) -> dict[str, Callable[[], int]]:
        """Return the readers that count publishers, by topic."""
        return {topic: reader.peers for topic, reader in self._readers.items()}

    def __contains__(self, topic: str) -> bool:
        return topic in self._readers

    def open(self, topic: str, kind: str, subject: Any, qos: Any) -> None:
        """Subscribe to a topic.

        Args:
            topic: its name.
            kind: type of its messages.
            subject: the DDS topic.
            qos: the quality of service requested of publishers.
        """
        reader = _Reader(topic, kind, subject, qos, self._participant)
        self._readers[topic] = reader
        self._waiting.attach(reader.condition)

    def adapt(self) -> None:
        """Request only best effort from publishers that offer less, as drivers of sensors do."""
        for topic, reader in list(self._readers.items()):
            if reader.asks_too_much():
                self._waiting.detach(reader.condition)
                self.open(topic, reader.kind, reader.subject, reader.modest())

    def senders(self, topic: str) -> set[str]:
        """Return the participants that publish on a subscribed topic."""
        return self._readers[topic].senders()

    def check(self) -> None:
        """Check that messages are still received.

        Raises:
            SimulationError: they are not.
        """
        if self._error is not None:
            raise SimulationError(f"DDS has stopped delivering messages: {self._error}") from self._error

    def _run(self) -> None:
        try:
            while not self._end.read():
                self._waiting.wait(10 * NS_PER_S)
                self._deliver()
        except Exception as error:  # noqa: BLE001  reported to the loop, which runs in another thread
            self._error = error

    def _deliver(self) -> None:
        with self._taking:
            for reader in list(self._readers.values()):
                for data, sender in reader.take():
                    self._inbox.add(Letter(reader.topic, reader.kind, data, sender, self._codec))

    def clear(self) -> None:
        """End all subscriptions."""
        with self._taking:
            for reader in self._readers.values():
                self._waiting.detach(reader.condition)
            self._readers.clear()

    def close(self) -> None:
        """End the subscription."""
        if self._end is None:
            return
        self._end.set(True)
        self._thread.join()
        self.clear()
        self._waiting = self._end = self._participant = None


def participants(handles: Iterable[int], known: dict[int, str], look_up: Callable[[int], Any]) -> set[str]:
    """Return the participants of other publishers.

    Args:
        handles: DDS handles of the publishers.
        known: cache of earlier look-ups; new ones are added.
        look_up: queries DDS, which is slow.
    """
    for handle in set(handles) - known.keys():
        if (other := look_up(handle)) is not None:  # otherwise it has left meanwhile
            known[handle] = str(other.participant_key)
    return {known[handle] for handle in handles if handle in known}


class _Reader:
    """Receives the messages of one topic."""

    def __init__(self, topic: str, kind: str, subject: Any, qos: Any, participant: Any) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader

        self.topic, self.kind, self.subject, self._qos = topic, kind, subject, qos
        self._reader = DataReader(participant, subject, qos=qos)
        self.condition = ReadCondition(self._reader, SampleState.Any | ViewState.Any | InstanceState.Any)
        self._known: dict[int, str] = {}

    def take(self) -> Iterator[tuple[bytes, str]]:
        """Yield the received bytes with their senders."""
        from cyclonedds.internal import InvalidSample

        while samples := self._reader.take(_AT_ONCE):
            for sample in samples:
                if not isinstance(sample, InvalidSample):  # those report that a publisher has left
                    yield sample.data, self._sender(sample.sample_info.publication_handle)

    def _sender(self, handle: int) -> str:
        look_up = self._reader.get_matched_publication_data
        return next(iter(participants([handle], self._known, look_up)), _GONE)

    def peers(self) -> int:
        """Return the number of publishers."""
        return int(self._reader.get_subscription_matched_status().current_count)

    def senders(self) -> set[str]:
        """Return the publishing participants."""
        handles = self._reader.get_matched_publications()
        return participants(handles, self._known, self._reader.get_matched_publication_data)

    def asks_too_much(self) -> bool:
        """Return whether all publishers offer less than is requested."""
        refused = self._reader.get_requested_incompatible_qos_status().total_count
        return bool(refused) and not self.peers()

    def modest(self) -> Any:
        """Return a quality of service that requests only best effort."""
        from cyclonedds.core import Policy, Qos

        asked = [each for each in self._qos if not isinstance(each, Policy.Reliability.Reliable)]
        return Qos(Policy.Reliability.BestEffort, *asked)
