"""The process that simulates bodies for another one: ``python -m nrp_world_ros.hosted.host DOMAIN``."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread
from typing import BinaryIO

from nrp_core.errors import BackendLoadError

from nrp_world_ros.hosted.body import HostedBody
from nrp_world_ros.hosted.hosts import HostNamespace, Opened, Order, await_other
from nrp_world_ros.hosted.notes import Answer, Notes, portable
from nrp_world_ros.lockstep import DONE, GO, Turns
from nrp_world_ros.ros2.node import Ros2Node
from nrp_world_ros.simulator import Simulator

Orders = SimpleQueue[tuple[Order, HostNamespace]]


def main() -> None:
    """Simulate the requested worlds, one after the other, until the other process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the loop, which ends this process
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # output of engines must not mix with answers
    orders: Orders = SimpleQueue()
    Thread(target=_listen, args=(sys.stdin.buffer, orders), daemon=True).start()

    def tell(answer: Answer) -> None:
        pickle.dump(answer, answers)
        answers.flush()

    try:
        node = Ros2Node("nrp_body", domain=int(sys.argv[1]))
    except BackendLoadError as error:
        orders.get()
        tell(Answer(error=error))
        return
    while True:
        _simulate(*orders.get(), node, tell)


def _listen(source: BinaryIO, orders: Orders) -> None:
    """Receive requests; at the end of input, end the present work."""
    try:
        while True:
            orders.put(pickle.load(source))
    except EOFError:
        os._exit(0)


def _simulate(order: Order, place: HostNamespace, node: Ros2Node, tell: Callable[[Answer], None]) -> None:
    try:
        world = Simulator.named(order.body, order.options).open(order.scene, order.seed)
    except Exception as error:  # noqa: BLE001  reported to the loop
        tell(Answer(error=portable(error)))
        return
    with world:
        node.move(place.namespace)
        turns = Turns(node, DONE, GO)
        body = HostedBody(world, node, Notes(place.key))
        await_other(node)
        tell(Answer(Opened(tuple(world.warnings), world.engine.image_scale)))
        body.serve(turns)
        await_other(node, there=False)  # the last answer was sent
    node.move("")


if __name__ == "__main__":
    main()
