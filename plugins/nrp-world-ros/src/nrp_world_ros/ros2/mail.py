"""What others send in ROS 2, taken by a thread of ours as it comes."""

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
"""How many messages of a topic are taken at a time."""

_GONE = "somebody who has left"


class Mail(Closing):
    """Puts what comes on topics into an inbox.

    DDS delivers in threads of its own, which nothing should hold up: a thread of ours waits for them.

    Args:
        participant: of DDS.
        inbox: where messages go.
        codec: reads them.
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
        """Return what counts those who publish, by topic."""
        return {topic: reader.peers for topic, reader in self._readers.items()}

    def __contains__(self, topic: str) -> bool:
        return topic in self._readers

    def open(self, topic: str, kind: str, subject: Any, qos: Any) -> None:
        """Listen to a topic.

        Args:
            topic: its name.
            kind: type of its messages.
            subject: the topic of DDS.
            qos: what is asked of those who send.
        """
        reader = _Reader(topic, kind, subject, qos, self._participant)
        self._readers[topic] = reader
        self._waiting.attach(reader.condition)

    def adapt(self) -> None:
        """Ask less of those who promise less, as drivers of sensors do: their best effort is enough."""
        for topic, reader in list(self._readers.items()):
            if reader.asks_too_much():
                self._waiting.detach(reader.condition)
                self.open(topic, reader.kind, reader.subject, reader.modest())

    def senders(self, topic: str) -> set[str]:
        """Return the participants that publish on a topic that is listened to."""
        return self._readers[topic].senders()

    def check(self) -> None:
        """Look whether messages are still taken.

        Raises:
            SimulationError: they are not.
        """
        if self._error is not None:
            raise SimulationError(f"DDS delivers no more: {self._error}") from self._error

    def _run(self) -> None:
        try:
            while not self._end.read():
                self._waiting.wait(10 * NS_PER_S)
                self._deliver()
        except Exception as error:  # noqa: BLE001  told to the loop, which runs in another thread
            self._error = error

    def _deliver(self) -> None:
        with self._taking:
            for reader in list(self._readers.values()):
                for data, sender in reader.take():
                    self._inbox.add(Letter(reader.topic, reader.kind, data, sender, self._codec))

    def clear(self) -> None:
        """Listen to no topic any more."""
        with self._taking:
            for reader in self._readers.values():
                self._waiting.detach(reader.condition)
            self._readers.clear()

    def close(self) -> None:
        """Listen no more."""
        if self._end is None:
            return
        self._end.set(True)
        self._thread.join()
        self.clear()
        self._waiting = self._end = self._participant = None


def participants(handles: Iterable[int], known: dict[int, str], look_up: Callable[[int], Any]) -> set[str]:
    """Return to which participants others belong.

    Args:
        handles: by which DDS names the others.
        known: those who were looked up before; those who were not are added.
        look_up: asks DDS, which takes its time.
    """
    for handle in set(handles) - known.keys():
        if (other := look_up(handle)) is not None:  # else it has left meanwhile
            known[handle] = str(other.participant_key)
    return {known[handle] for handle in handles if handle in known}


class _Reader:
    """Takes what comes on one topic."""

    def __init__(self, topic: str, kind: str, subject: Any, qos: Any, participant: Any) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader

        self.topic, self.kind, self.subject, self._qos = topic, kind, subject, qos
        self._reader = DataReader(participant, subject, qos=qos)
        self.condition = ReadCondition(self._reader, SampleState.Any | ViewState.Any | InstanceState.Any)
        self._known: dict[int, str] = {}

    def take(self) -> Iterator[tuple[bytes, str]]:
        """Yield the bytes that have come, and who sent them."""
        from cyclonedds.internal import InvalidSample

        while samples := self._reader.take(_AT_ONCE):
            for sample in samples:
                if not isinstance(sample, InvalidSample):  # those tell that somebody has left
                    yield sample.data, self._sender(sample.sample_info.publication_handle)

    def _sender(self, handle: int) -> str:
        look_up = self._reader.get_matched_publication_data
        return next(iter(participants([handle], self._known, look_up)), _GONE)

    def peers(self) -> int:
        """Return how many publish here."""
        return int(self._reader.get_subscription_matched_status().current_count)

    def senders(self) -> set[str]:
        """Return the participants that publish here."""
        handles = self._reader.get_matched_publications()
        return participants(handles, self._known, self._reader.get_matched_publication_data)

    def asks_too_much(self) -> bool:
        """Whether all who publish here promise less than is asked."""
        refused = self._reader.get_requested_incompatible_qos_status().total_count
        return bool(refused) and not self.peers()

    def modest(self) -> Any:
        """Return what asks for no more than the best effort of others."""
        from cyclonedds.core import Policy, Qos

        asked = [each for each in self._qos if not isinstance(each, Policy.Reliability.Reliable)]
        return Qos(Policy.Reliability.BestEffort, *asked)
