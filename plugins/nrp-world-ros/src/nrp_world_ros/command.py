"""``nrp ros-bridge``."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING, Annotated

import typer
from nrp_core.cli.failure import INTERRUPTED, complain
from nrp_core.cli.options import BrainName, ExperimentName, Overrides, Seed, WorldName, overrides_of
from nrp_core.quantities import time_ns

from nrp_world_ros.backend import LAST_DOMAIN, Ros

if TYPE_CHECKING:
    from nrp_core import Experiment

    from nrp_world_ros.bridge import Bridge
    from nrp_world_ros.node import Node

_QUEUE = 10
"""How many messages wait for a listener that is slow, when nobody waits for it."""


def ros_bridge(
    experiment: ExperimentName,
    without_brain: Annotated[
        bool,
        typer.Option("--without-brain", help="Only the world: its robots do what ROS tells them."),
    ] = False,
    lockstep: Annotated[
        bool,
        typer.Option("--lockstep", help="Without a brain: wait for a loop whose world is 'ros'."),
    ] = False,
    ros2: Annotated[bool, typer.Option("--ros2", help="ROS 2 instead of ROS 1.")] = False,
    domain: Annotated[
        int | None,
        typer.Option(
            min=0, max=LAST_DOMAIN, help="The domain of ROS 2; by default ROS_DOMAIN_ID says, else 0."
        ),
    ] = None,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    seed: Seed = None,
    pace: Annotated[
        str, typer.Option(metavar="max|realtime|FACTOR", help="How fast simulated time passes.")
    ] = "realtime",
    until: Annotated[
        str | None, typer.Option(metavar="TIME", help="Stop at this time; by default Ctrl-C ends it.")
    ] = None,
) -> None:
    """Let ROS see an experiment and command its robots: rviz, rosbag, your nodes."""
    from nrp_core import load_experiment

    from nrp_world_ros.node import join

    if lockstep and not without_brain:
        raise typer.BadParameter("a brain here waits for no other loop", param_hint="--lockstep")
    if domain is not None and not ros2:
        raise typer.BadParameter("only ROS 2 has domains: say --ros2, too", param_hint="--domain")
    settings = overrides_of(overrides, brain=brain, world=world, seed=seed, pace=pace)
    loaded = load_experiment(experiment, settings)
    until_ns = None if until is None else time_ns(until)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what ends it leaves ROS in order
    try:
        ros = Ros.TWO if ros2 else Ros.ONE
        with join(ros, "nrp_body", queue=0 if lockstep else _QUEUE, domain=domain) as node:
            if without_brain:
                _body(loaded, node, until_ns, lockstep=lockstep)
            else:
                _whole(loaded, node, until_ns)
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None


def _body(experiment: Experiment, node: Node, until_ns: int | None, *, lockstep: bool) -> None:
    from nrp_core.cle import pacing_of

    from nrp_world_ros.body import Body
    from nrp_world_ros.opening import open_world

    with open_world(experiment) as world:
        body = Body(world, node)
        try:
            if lockstep:
                body.run_in_lockstep(until_ns, lambda: _tell(body.bridge))
            else:
                _tell(body.bridge)
                body.run(until_ns, experiment.timestep, pacing_of(experiment.pace))
        finally:
            _warn(body.bridge)


def _whole(experiment: Experiment, node: Node, until_ns: int | None) -> None:
    from nrp_core import Run
    from nrp_core.clock import seconds

    from nrp_world_ros.bridge import Bridge

    with Run(experiment) as run:
        bridge = Bridge(run.world, node, run.loop.publish)

        def exchange(_loop: object) -> None:
            node.check()
            bridge.send()
            bridge.receive()
            bridge.attend()

        run.loop.hooks.after_step.append(exchange)
        run.loop.hooks.after_reset.append(lambda _loop: bridge.restart())
        _tell(bridge)
        try:
            run.run(None if until_ns is None else seconds(until_ns))
        finally:
            _warn(bridge)
        result = run.result()
    typer.echo(f"criteria met: {result.passed}")
    if result.passed is False:
        raise typer.Exit(1)


def _tell(bridge: Bridge) -> None:
    topics = f"{len(bridge.outgoing)} topics to listen to, {len(bridge.incoming)} to command"
    typer.echo(f"in ROS: {topics}, {len(bridge.services)} services")
    _warn(bridge)


def _warn(bridge: Bridge) -> None:
    for warning in bridge.warnings:
        complain(warning, label="warning", color="yellow")
    bridge.warnings.clear()
