"""One client of the server: its subscriptions and its messages."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Coroutine, Iterable
from contextlib import suppress
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.protocol import State

from nrp_cockpit.wire import protocol
from nrp_cockpit.wire.calls import Calls
from nrp_cockpit.wire.channels import Channel, Sent
from nrp_cockpit.wire.frames import Pieces, frame
from nrp_cockpit.wire.hub import Hub, to_json
from nrp_cockpit.wire.memory import PAST, past_data
from nrp_cockpit.wire.outbox import Outbox
from nrp_cockpit.wire.protocol import ClientMessage, PlaybackRequest, ProtocolError, ServiceRequest

EXPERIMENT = "/cockpit/experiment"
"""The topic that describes the session, with the permissions of each client."""

BUNDLE_BYTES = 1 << 18
"""Messages are written together up to this size; all of a step usually are less."""


class Client:
    """Serves one connection: subscriptions, calls and published messages.

    Args:
        connection: an open connection.
        hub: the run's side.
        may_steer: whether it may change the run.
        is_embedded: whether it is part of a page that is a client too.
    """

    def __init__(
        self, connection: ServerConnection, hub: Hub, *, may_steer: bool, is_embedded: bool = False
    ) -> None:
        self._connection, self._hub = connection, hub
        self.may_steer, self.is_embedded = may_steer, is_embedded
        self._outbox, self._wake = Outbox(), asyncio.Event()
        self._announced: set[int] = set()
        self._subscribed: dict[int, Channel] = {}
        self._subscriptions: dict[int, list[int]] = {}
        self._topics: dict[int, str] = {}
        self._past: int | None = None  # its subscription to the announcements of pasts
        self._calls = Calls(lambda: hub.services, may_steer=may_steer)
        self._tasks: set[asyncio.Task[None]] = set()

    @property
    def dropped(self) -> int:
        """Number of messages dropped because the client was too slow."""
        return self._outbox.dropped

    async def serve(self, session_id: str) -> None:
        """Serve the client until it disconnects."""
        self._say(protocol.server_info("nrp-cockpit", session_id, self._hub.playback.end_ns))
        self.announce(self._hub.channels)
        self._say(protocol.advertise_services(enumerate(self._hub.services.names, 1)))
        self._hub.enter(self)
        sender = asyncio.create_task(self._send())
        try:
            async for message in self._connection:
                self._receive(message)
        except ConnectionClosed:
            pass
        finally:
            sender.cancel()
            self._hub.leave(self, [channel.topic for channel in self._subscribed.values()])

    # -- called by the hub

    def announce(self, channels: Iterable[Channel]) -> None:
        """Advertise channels, each once."""
        new = [channel for channel in channels if channel.id not in self._announced]
        self._announced.update(channel.id for channel in new)
        if new:
            self._say(protocol.advertise([channel.to_dict() for channel in new]))

    def withdraw(self, channels: Iterable[Channel]) -> None:
        """Withdraw channels, and end the subscriptions to them."""
        gone = {channel.id for channel in channels} & self._announced
        for subscription, channel in tuple(self._subscribed.items()):
            if channel.id in gone:
                self._unsubscribe(subscription)
        self._announced -= gone
        if gone:
            self._say(protocol.unadvertise(sorted(gone)))

    def receive(self, sent: Sent) -> None:
        """Queue a message, if the client subscribes to its channel."""
        for subscription in self._subscriptions.get(sent.channel.id, ()):
            self._outbox.add(subscription, sent)

    def recall(self, topics: Iterable[str], *, are_new: bool) -> None:
        """Queue the past of these topics, and of those of which messages were lost.

        Args:
            topics: the topics.
            are_new: whether all that was known of them before is invalid.
        """
        wanted, memory = set(topics), self._hub.memory
        for subscription, channel in self._subscribed.items():
            if channel.topic in memory and (channel.topic in wanted or subscription in self._outbox.lost):
                self._recall(subscription, channel.topic, is_new=are_new)

    def tick(self, t_ns: int) -> None:
        """Queue the time."""
        self._outbox.tick(protocol.clock(t_ns))

    def flush(self) -> None:
        """Send the waiting messages; later if the client has not read the earlier ones."""
        connection, outbox = self._connection, self._outbox
        if connection.state is not State.OPEN:
            return
        if connection.paused:
            self._wake.set()  # perhaps nothing is sent after this
            return
        pieces: list[bytes | memoryview] = []
        size = 0
        while outbox and size < BUNDLE_BYTES:
            framed = frame(self._message(outbox.take()))
            size += sum(map(len, framed))
            pieces += framed
        connection.transport.writelines(pieces)
        if outbox:
            self._wake.set()

    # -- sending

    def _say(self, message: str | bytes) -> None:
        self._outbox.answer(message)
        self._wake.set()

    async def _send(self) -> None:
        """Send the remaining messages; a client that does not read delays only itself."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            with suppress(OSError):  # the end of the connection is noticed where it is read
                await self._connection.drain()
            self.flush()

    def _message(self, waiting: str | bytes | tuple[int, Sent]) -> str | Pieces:
        """Return a waiting message as a text, or as pieces."""
        if isinstance(waiting, str):
            return waiting
        if isinstance(waiting, bytes):
            return (waiting,)
        subscription, sent = waiting
        head = protocol.data_head(subscription, sent.t_ns)
        if sent.channel.topic != EXPERIMENT:
            return head, *sent.pieces
        own = {**json.loads(sent.payload), "may_steer": self.may_steer}
        return head, json.dumps(own).encode()

    # -- receiving

    def _receive(self, message: str | bytes) -> None:
        try:
            if isinstance(message, str):
                self._obey(protocol.read_text(message))
                return
            match protocol.read_binary(message):
                case ServiceRequest() as request:
                    self._begin(self._answer(request))
                case ClientMessage() as published:
                    self._begin(self._publish(published))
                case PlaybackRequest() as wanted:
                    self._begin(self._play_back(wanted))
        except (KeyError, TypeError) as error:
            self._warn(f"not understood: a field is missing or of another type ({error})")
        except ProtocolError as error:
            self._warn(f"not understood: {error}")

    def _obey(self, message: dict[str, Any]) -> None:
        match message["op"]:
            case "subscribe":
                for one in message["subscriptions"]:
                    self._subscribe(one["id"], one["channelId"])
            case "unsubscribe":
                for subscription in message["subscriptionIds"]:
                    self._unsubscribe(subscription)
            case "advertise":
                self._topics.update({one["id"]: one["topic"] for one in message["channels"]})
            case "unadvertise":
                for channel in message["channelIds"]:
                    self._topics.pop(channel, None)
            case other:
                self._warn(f"this server does not support '{other}'")

    def _subscribe(self, subscription: int, channel_id: int) -> None:
        channel = next((one for one in self._hub.channels if one.id == channel_id), None)
        if channel is None:
            raise ProtocolError(f"there is no channel {channel_id}")
        if subscription in self._subscribed or not protocol.is_id(subscription):
            raise ProtocolError(f"{subscription!r} is not a valid id of a new subscription")
        self._subscribed[subscription] = channel
        self._subscriptions.setdefault(channel_id, []).append(subscription)
        last = self._hub.subscribe(channel.topic)
        if channel.topic == PAST:
            self._past = subscription
            self.recall([each.topic for each in self._subscribed.values()], are_new=False)
        elif self._past is not None and channel.topic in self._hub.memory:
            self._recall(subscription, channel.topic)
        elif last is not None:
            self._outbox.add(subscription, last)
            self._wake.set()

    def _unsubscribe(self, subscription: int) -> None:
        channel = self._subscribed.pop(subscription, None)
        if channel is None:
            raise ProtocolError(f"there is no subscription {subscription!r}")
        self._subscriptions[channel.id].remove(subscription)
        self._outbox.forget(subscription)
        if subscription == self._past:
            self._past = None
        self._hub.unsubscribe(channel.topic)

    def _recall(self, subscription: int, topic: str, *, is_new: bool = False) -> None:
        if self._past is None:
            return
        from_ns, messages = self._hub.memory.of(topic)
        about = to_json(past_data(topic, from_ns, len(messages), is_new=is_new))
        announced = Sent(self._hub.channels[PAST], self._hub.playback.t_ns, (about,))
        self._outbox.recall(
            subscription, [(self._past, announced), *((subscription, sent) for sent in messages)]
        )
        self._wake.set()

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _answer(self, request: ServiceRequest) -> None:
        self._say(await self._calls.answer(request))

    async def _publish(self, message: ClientMessage) -> None:
        topic = self._topics.get(message.channel_id)
        failure = (
            f"channel {message.channel_id} was not advertised"
            if topic is None
            else await self._calls.publish(topic, message.payload)
        )
        if failure is not None:
            self._warn(failure)

    async def _play_back(self, request: PlaybackRequest) -> None:
        for service, arguments in self._hub.playback.calls_for(request):
            failure = await self._calls.make(service, arguments)
            if failure is not None:
                self._warn(failure)
        now = self._hub.playback
        self._say(
            protocol.playback_state(
                now.status, now.t_ns, now.speed,
                did_seek=request.seek_ns is not None, request_id=request.request_id,
            )
        )  # fmt: skip

    def _warn(self, text: str) -> None:
        self._say(protocol.status(text))
