"""A world without a brain, as a simulator for ROS."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from nrp_core.world import Publication, World

from nrp_world_ros.bridge import PLAIN, Bridge, Style
from nrp_world_ros.node import Node
from nrp_world_ros.timekeeping import DONE, GO, Sent, Turn, Turns

if TYPE_CHECKING:
    from nrp_core.cle.pacing import Pacing

_TURN_S = 1.0


class Publications:
    """Publishes on topics of a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._open: dict[str, Publication] = {}

    def __call__(self, topic: str, message: Any) -> None:
        """Publish a message; it takes effect at once."""
        if topic not in self._open:
            self._open[topic] = self._world.advertise(topic)
        self._open[topic].publish(message)


class Body:
    """Steps a world behind a bridge.

    Args:
        world: the world.
        node: in ROS.
        tell: receives warnings, also when no ROS node is found; None: a node exists that calls no
            services.
        style: of the messages.

    Attributes:
        bridge: its topics in ROS.
    """

    def __init__(
        self, world: World, node: Node, tell: Callable[[str], None] | None = None, style: Style = PLAIN
    ) -> None:
        self._world, self._node = world, node
        self.bridge = Bridge(world, node, Publications(world), tell, style)

    def run(self, until_ns: int | None, period_ns: int, pacing: Pacing) -> None:
        """Run for some time.

        Args:
            until_ns: end time, ns; None: never.
            period_ns: period of the exchange of messages, ns.
            pacing: the pace.

        Raises:
            SimulationError: the engine failed, or the connection to ROS was lost.
        """
        pacing.start(self._world.now_ns)
        while until_ns is None or self._world.now_ns < until_ns:
            self.bridge.check()
            self.bridge.receive()
            self.bridge.attend()
            self._world.run_until(self._world.now_ns + period_ns)
            self.bridge.send()
            pacing.wait(self._world.now_ns)

    def _between(self) -> None:
        """Handle messages and calls while time does not pass."""
        self.bridge.check()
        self.bridge.answer()

    def run_in_lockstep(self, until_ns: int | None, began: Callable[[], None]) -> None:
        """Run in lockstep with a loop.

        Args:
            until_ns: end time, ns; None: never.
            began: called when loops can find this body.

        Raises:
            SimulationError: the engine failed, or the connection to ROS was lost.
        """
        turns = Turns(self._node, DONE, GO)
        began()
        while until_ns is None or self._world.now_ns < until_ns:
            turn = turns.wait(_TURN_S, meanwhile=self._between)
            if turn is not None:
                sent = self.take_turn(turn)
                turns.end(self._world.now_ns, sent)

    def take_turn(self, turn: Turn) -> Sent:
        """Handle the messages of a loop, and run to its time.

        Returns:
            The sensor messages sent meanwhile.
        """
        self.bridge.receive()
        if turn.time.to_ns() <= self._world.now_ns:
            return {}  # it only asks for the time
        self.bridge.attend()
        self._world.run_until(turn.time.to_ns())
        return self.bridge.send()
