"""A cockpit in this process, and visitors who speak with it over a real websocket."""

from __future__ import annotations

import base64
import json
import struct
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from typing import Any, NamedTuple

from nrp_cockpit.designer.services import offer_services
from nrp_cockpit.session.live import LiveSession
from nrp_cockpit.session.opening import Opening
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.server import Server
from requests_of_clients import client_message, service_request
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

SMALL = "world.options.image_scale=0.25"
PATIENCE_S = 180.0
"""Wall time for an answer, s: a first step may have to compile the kernels of a brain, on a busy machine."""
_LOOK_S = 0.2
_DATA = struct.Struct("<BIQ")
_ANSWER = struct.Struct("<BIII")
_TICK = struct.Struct("<BQ")
_PLAYBACK = struct.Struct("<BBQf?I")


class RefusedError(Exception):
    """The server refused a call; the text is what it said."""


class Heard(NamedTuple):
    """A message on a topic."""

    t_ns: int
    payload: bytes


class Visitor:
    """One client of a server.

    Args:
        connection: to the server.

    Attributes:
        channels: all announced, by topic.
        services: the numbers of all services, by name.
        heard: the messages so far, by topic.
        warnings: what the server complained about.
        ticks: the simulated times that the server told, ns.
        playbacks: status and time of each answer to a request for playback, by its name.
    """

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, int] = {}
        self.heard: defaultdict[str, list[Heard]] = defaultdict(list)
        self.warnings: list[str] = []
        self.ticks: list[int] = []
        self.playbacks: dict[str, tuple[int, int]] = {}
        self._answers: dict[int, Any] = {}
        self._topics: dict[int, str] = {}
        self._calls = self._ids = 0
        self.until(lambda: self.services)

    def until(self, done: Callable[[], Any], patience_s: float = PATIENCE_S) -> Any:
        """Receive until something is so, and return it; what is looked at may change without a message."""
        end_s = time.monotonic() + patience_s
        while not (found := done()):
            assert time.monotonic() < end_s, "it did not happen in time"
            with suppress(TimeoutError):
                self._receive(min(_LOOK_S, end_s - time.monotonic()))
        return found

    def listen(self, wall_s: float) -> None:
        """Receive for some time."""
        end_s = time.monotonic() + wall_s
        while (left_s := end_s - time.monotonic()) > 0:
            try:
                self._receive(left_s)
            except TimeoutError:
                return

    def subscribe(self, *topics: str) -> None:
        for topic in topics:
            self._ids += 1
            self._topics[self._ids] = topic
            self.tell("subscribe", subscriptions=[{"id": self._ids, "channelId": self.channels[topic]["id"]}])

    def unsubscribe(self, topic: str) -> None:
        number = max(number for number, known in self._topics.items() if known == topic)
        self.tell("unsubscribe", subscriptionIds=[number])

    def tell(self, operation: str, **fields: Any) -> None:
        self.connection.send(json.dumps({"op": operation, **fields}))

    def call(self, name: str, /, **arguments: Any) -> Any:
        """Call a service and return its answer."""
        return self.answer(self.ask(name, **arguments))

    def ask(self, name: str, /, **arguments: Any) -> int:
        """Call a service and do not wait."""
        return self.ask_raw(self.services[f"/cockpit/{name}"], json.dumps(arguments).encode())

    def ask_raw(self, service: int, payload: bytes) -> int:
        self._calls += 1
        self.connection.send(service_request(service, self._calls, payload))
        return self._calls

    def answer(self, call: int) -> Any:
        self.until(lambda: call in self._answers)
        found = self._answers.pop(call)
        if isinstance(found, Exception):
            raise found
        return found

    def publish(self, topic: str, *values: Any) -> None:
        """Publish as other programs do, on a channel of its own."""
        self.tell("advertise", channels=[{"id": 7, "topic": topic, "encoding": "json", "schemaName": ""}])
        for value in values:
            self.connection.send(client_message(7, json.dumps(value).encode()))

    def last(self, report: str) -> Any:
        """Return the newest report of that name; None if there is none yet."""
        heard = self.heard[f"/cockpit/{report}"]
        return json.loads(heard[-1].payload) if heard else None

    def status(self, **wanted: Any) -> dict[str, Any]:
        """Wait for a state with these values."""

        def found() -> dict[str, Any] | None:
            status = self.last("status")
            fits = status is not None and all(status[name] == value for name, value in wanted.items())
            return dict(status) if fits else None

        return dict(self.until(found))

    def _receive(self, patience_s: float) -> None:
        frame = self.connection.recv(max(patience_s, 0.001))
        if isinstance(frame, str):
            self._read(json.loads(frame))
        elif frame[0] == 1:
            _, subscription, t_ns = _DATA.unpack_from(frame)
            self.heard[self._topics[subscription]].append(Heard(t_ns, frame[_DATA.size :]))
        elif frame[0] == 2:
            self.ticks.append(_TICK.unpack_from(frame)[1])
        elif frame[0] == 5:
            _, status, t_ns, _, _, length = _PLAYBACK.unpack_from(frame)
            self.playbacks[frame[-length:].decode()] = status, t_ns
        else:
            _, _, call, length = _ANSWER.unpack_from(frame)
            self._answers[call] = json.loads(frame[_ANSWER.size + length :])

    def _read(self, message: dict[str, Any]) -> None:
        match message["op"]:
            case "advertise":
                self.channels.update({one["topic"]: one for one in message["channels"]})
            case "unadvertise":
                gone = message["channelIds"]
                self.channels = {name: one for name, one in self.channels.items() if one["id"] not in gone}
            case "advertiseServices":
                self.services = {one["name"]: one["id"] for one in message["services"]}
            case "serviceCallFailure":
                self._answers[message["callId"]] = RefusedError(message["message"])
            case "status":
                self.warnings.append(message["message"])


def portions(call: Callable[..., Any], topic: str) -> list[Heard]:
    """Return all messages of a topic that a server knows, asked for portion by portion."""
    found: list[Heard] = []
    portion: dict[str, Any] = {"until_ns": -1, "is_all": False}
    while not portion["is_all"]:
        portion = call("messages", topic=topic, after_ns=portion["until_ns"])
        packed = base64.b64decode(portion["packed"])
        (count,) = struct.unpack_from("<Q", packed)
        times_ns = struct.unpack_from(f"<{count}d", packed, 8)
        lengths = struct.unpack_from(f"<{count}I", packed, 8 + 8 * count)
        data = BytesIO(packed[8 + 12 * count :])
        found += [Heard(int(t_ns), data.read(n)) for t_ns, n in zip(times_ns, lengths, strict=True)]
        assert data.read() == b""
    return found


class Cockpit:
    """A session in a thread of its own, with a server.

    Args:
        session: the session.
        server: serves its hub.
        guard: of the server.
    """

    def __init__(self, session: LiveSession, server: Server, guard: Guard) -> None:
        self.session, self.server, self.guard = session, server, guard
        self.run = session.run

    @property
    def address(self) -> str:
        """The address of its page."""
        return f"http://127.0.0.1:{self.server.port}/?token={self.guard.token}"

    @contextmanager
    def visit(
        self,
        *,
        steers: bool = True,
        protocols: tuple[str, ...] = ("foxglove.websocket.v1",),
        run: str = "",
    ) -> Iterator[Visitor]:
        """Let somebody in; ``run="beside"``: to the second run."""
        token = self.guard.token if steers else self.guard.watch_token
        with visit(f"http://127.0.0.1:{self.server.port}/?token={token}&run={run}", protocols) as visitor:
            yield visitor


@contextmanager
def visit(page: str, protocols: tuple[str, ...] = ("foxglove.websocket.v1",)) -> Iterator[Visitor]:
    """Let somebody in where a page has its address."""
    address = page.partition("#")[0].replace("http:", "ws:", 1)
    names = [Subprotocol(name) for name in protocols]
    with connect(address, subprotocols=names, max_size=None, proxy=None, close_timeout=0.5) as connection:
        yield Visitor(connection)


@contextmanager
def cockpit(*overrides: str, experiment: str = "braitenberg_husky") -> Iterator[Cockpit]:
    """Open a cockpit; it is closed as the command closes it."""
    guard, hub = Guard(), Hub()
    with Run(load_experiment(experiment, [SMALL, *overrides])) as run:
        session = LiveSession(run, hub)
        opening = Opening(session, lambda more: load_experiment(experiment, [SMALL, *overrides, *more]))
        offer_services(opening)
        server = Server(hub, guard=guard)
        owner = threading.Thread(target=session.serve)
        owner.start()
        try:
            yield Cockpit(session, server, guard)
        finally:
            session.close()
            owner.join()
            server.close()
            session.run.close()
