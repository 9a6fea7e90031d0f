"""The process that simulates bodies for another one: ``python -m nrp_world_ros.hosted.host DOMAIN``."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Collection, Mapping
from queue import SimpleQueue
from threading import Thread
from typing import Any, BinaryIO

from nrp_core.errors import BackendLoadError, SimulationError
from nrp_core.simulation import Snapshot
from nrp_core.world import ModelMotion, Scene, World

from nrp_world_ros.body import Body
from nrp_world_ros.hosted.dialogue import Answer, Notes, Question, portable
from nrp_world_ros.hosted.hosts import HostNamespace, Opened, Order, await_other
from nrp_world_ros.node import Node
from nrp_world_ros.options import Simulator
from nrp_world_ros.ros2.node import Ros2Node
from nrp_world_ros.timekeeping import DONE, GO, Sent, Turn, Turns

_TURN_S = 1.0


class HostedBody(Body):
    """See :class:`~nrp_world_ros.body.Body`.

    Args:
        world: the world.
        node: in ROS.
        notes: reads the requests of the loop, and writes the answers.
    """

    def __init__(self, world: World, node: Node, notes: Notes) -> None:
        super().__init__(world, node)
        self._notes = notes
        self._wanted = True
        self._follow()
        self._n_warned = len(world.warnings)
        self._does: Mapping[str, Callable[..., Any]] = {
            "actuator_states": world.engine.actuator_states,
            "sensor_values": world.engine.sensor_values,
            "close": self._close,
            "depth": world.engine.depth,
            "joint_states": world.joint_states,
            "joint_wrench": world.engine.joint_wrench,
            "leave": self._leave,
            "link_motion": world.link_motion,
            "load": self._load,
            "motions": self._motions,
            "nothing": lambda: None,
            "pause": self._pause,
            "place": world.place,
            "push": world.engine._do_set_wrench,
            "render": world.engine.render,
            "reset": self._reset,
            "restore": self._restore,
            "save": world.snapshot,
            "set_glow": world.engine.set_glow,
            "set_joint_effort": world.engine.set_joint_effort,
            "set_joints": world.set_joints,
            "set_lights": world.set_lights,
            "reset_state": lambda: world.reset("state"),
            "touches": world.engine._do_touches,
        }

    def serve(self, turns: Turns) -> None:
        """Handle the loop's requests until it releases this body."""
        while self._wanted:
            turn = turns.wait(_TURN_S, meanwhile=self._node.check)
            if turn is not None:
                sent, note = self._answered(turn)
                turns.end(self._world.now_ns, sent, note)

    def _answered(self, turn: Turn) -> tuple[Sent, bytes]:
        sent: Sent = {}
        value, error = None, None
        try:
            sent = self.take_turn(turn)
            self._require_heard()
            value = self._replied(turn)
        except Exception as raised:  # noqa: BLE001  reported to the loop
            error = portable(raised)
        warnings = tuple(self._world.warnings[self._n_warned :])
        self._n_warned += len(warnings)
        silent = not (turn.note.size or error or warnings)
        return sent, b"" if silent else self._notes.write(Answer(value, error, warnings))

    def _require_heard(self) -> None:
        """Stop if the world has refused a message, because the loop would not know."""
        if self.bridge.warnings:
            refused = "; ".join(warning.message for warning in self.bridge.warnings)
            self.bridge.warnings.clear()
            raise SimulationError(refused)

    def _replied(self, turn: Turn) -> Any:
        if not turn.note.size:
            return None
        question: Question = self._notes.read(turn.note.tobytes())
        return self._does[question.name](*question.arguments)

    # -- requests that are not methods of a world

    def _follow(self) -> None:
        """Transfer the present topics; one that ROS cannot carry is an error only when it is used."""
        self.bridge.follow()
        self._world.warnings.extend(self.bridge.warnings)
        self.bridge.warnings.clear()

    def _close(self) -> None:
        self._wanted = False

    def _leave(self, topics: Collection[str]) -> None:
        self.bridge.left = topics

    def _motions(self) -> dict[str, ModelMotion]:
        return {model.name: self._world.model_motion(model.name) for model in self._world.scene.models}

    def _load(self, scene: Scene) -> None:
        self._world.change_to(scene)
        self._follow()

    def _pause(self, paused: bool) -> None:
        self._world.paused = paused

    def _reset(self, seed: int) -> None:
        self._world.reset(seed=seed)
        self._follow()
        self.bridge.restart()

    def _restore(self, snapshot: Snapshot) -> None:
        self._world.restore(snapshot)
        self._follow()
        self.bridge.restart(self._world.now_ns)


Orders = SimpleQueue[tuple[Order, HostNamespace]]


def main() -> None:
    """Simulate the requested worlds in sequence, until the other process ends."""
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
