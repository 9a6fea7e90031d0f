"""A world without a brain, as a simulator that ROS commands."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

from nrp_core.cle import Pacing
from nrp_core.experiment.collector import Collector
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.prepare import prepare
from nrp_core.experiment.watch import declare_own
from nrp_core.world.interface import World
from nrp_core.world.topics import Publication

from nrp_world_ros.bridge import Bridge
from nrp_world_ros.lockstep import DONE, GO, Turns
from nrp_world_ros.node import Node

_TURN_S = 1.0


def open_world(experiment: Experiment) -> World:
    """Open the world of an experiment, with its topics and aliases.

    Raises:
        BackendError: a backend is missing, broken or does not open.
        InvalidExperimentError: the experiment is wrong.
    """
    plan = prepare(experiment)
    world = plan.world.backend.open(plan.scene, seed=experiment.seed, options=plan.world.options)
    collector = Collector(experiment)
    declare_own(experiment, world, collector)
    collector.raise_errors()
    return world


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
            target_ns = turns.wait(_TURN_S, meanwhile=self._between)
            if target_ns is None:
                continue
            self.bridge.receive()
            sent: Counter[str] = Counter()
            if target_ns > self._world.now_ns:  # else it only asks what time it is
                self.bridge.attend()
                self._world.run_until(target_ns)
                sent = self.bridge.send()
            turns.end(self._world.now_ns, sent)
