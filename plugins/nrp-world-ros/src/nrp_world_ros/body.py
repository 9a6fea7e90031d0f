"""A world without a brain, as a simulator that ROS commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nrp_core.world import Publication, World

from nrp_world_ros.bridge import Bridge
from nrp_world_ros.lockstep import DONE, GO, Sent, Turn, Turns
from nrp_world_ros.node import Node

if TYPE_CHECKING:
    from nrp_core.cle import Pacing

_TURN_S = 1.0


class Publications:
    """Publishes on topics of a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._open: dict[str, Publication] = {}

    def __call__(self, topic: str, message: Any) -> None:
        """Publish a message; it takes effect now."""
        if topic not in self._open:
            self._open[topic] = self._world.advertise(topic)
        self._open[topic].publish(message)


class Body:
    """Steps a world behind a bridge.

    Args:
        world: the world.
        node: in ROS.

    Attributes:
        bridge: what ROS sees of it.
    """

    def __init__(self, world: World, node: Node) -> None:
        self._world, self._node = world, node
        self.bridge = Bridge(world, node, Publications(world))

    def run(self, until_ns: int | None, period_ns: int, pacing: Pacing) -> None:
        """Let time pass.

        Args:
            until_ns: when to end; None: never.
            period_ns: how often messages are exchanged.
            pacing: how fast.

        Raises:
            SimulationError: the engine failed, or ROS is gone.
        """
        pacing.start(self._world.now_ns)
        while until_ns is None or self._world.now_ns < until_ns:
            self._node.check()
            self.bridge.receive()
            self.bridge.attend()
            self._world.run_until(self._world.now_ns + period_ns)
            self.bridge.send()
            pacing.wait(self._world.now_ns)

    def _between(self) -> None:
        """Do what is due while no time passes."""
        self._node.check()
        self.bridge.answer()

    def run_in_lockstep(self, until_ns: int | None, began: Callable[[], None]) -> None:
        """Let time pass as far as a loop says that it may.

        Args:
            until_ns: when to end; None: never.
            began: called when a loop can find this body.

        Raises:
            SimulationError: the engine failed, or ROS is gone.
        """
        turns = Turns(self._node, DONE, GO)
        began()
        while until_ns is None or self._world.now_ns < until_ns:
            turn = turns.wait(_TURN_S, meanwhile=self._between)
            if turn is not None:
                sent = self.take_turn(turn)
                turns.end(self._world.now_ns, sent)

    def take_turn(self, turn: Turn) -> Sent:
        """Do what has come from a loop, and let time pass as far as it says.

        Returns:
            what was sensed meanwhile and sent.
        """
        self.bridge.receive()
        if turn.time.to_ns() <= self._world.now_ns:
            return {}  # it only asks what time it is
        self.bridge.attend()
        self._world.run_until(turn.time.to_ns())
        return self.bridge.send()
