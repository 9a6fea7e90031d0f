"""The topic ``/clock``, which a simulation with ROS publishes."""

from __future__ import annotations

from typing import Any, Final

from nrp_core.cle.engine import ClosedLoop
from nrp_core.clock import NS_PER_S
from nrp_core.dsl.parameters.messages import message_type
from nrp_core.experiment.running.run import Run
from nrp_core.world.messages.base import Time
from nrp_core.world.world import World

CLOCK: Final = "/clock"
_TYPE: Any = message_type("rosgraph_msgs/Clock")


def declare_clock(world: World) -> None:
    """Add the topic to a world, unless it has it."""
    if CLOCK not in world.topics:
        world.declare(CLOCK, _TYPE)


def let_tick(run: Run) -> None:
    """Publish the simulated time before the functions of each step, if somebody wants it."""
    if CLOCK not in run.world.topics:
        return
    publication = run.world.advertise(CLOCK)

    def tick(loop: ClosedLoop) -> None:
        publication.publish(_TYPE(Time(*divmod(loop.now_ns, NS_PER_S))))

    run.loop.hooks.before_functions.insert(0, tick)
