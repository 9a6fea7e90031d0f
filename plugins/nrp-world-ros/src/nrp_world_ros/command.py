"""``nrp ros-bridge``."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from nrp_core.cli.options import (
    BrainName,
    ExperimentName,
    Overrides,
    Seed,
    WorldName,
    overrides_of,
    usage_errors,
)
from nrp_core.cli.output import INTERRUPTED, warn
from nrp_core.quantities import time_ns

from nrp_world_ros.options import LAST_DOMAIN, Ros

if TYPE_CHECKING:
    from nrp_core import Experiment

    from nrp_world_ros.bridge import Bridge, Style
    from nrp_world_ros.node import Node

_QUEUE = 10
"""Queue length for a slow subscriber outside lockstep."""


def ros_bridge(
    experiment: ExperimentName,
    without_brain: Annotated[
        bool,
        typer.Option("--without-brain", help="Run only the world; its robots are commanded from ROS."),
    ] = False,
    lockstep: Annotated[
        bool,
        typer.Option("--lockstep", help="Without a brain: wait for a loop whose world is 'ros'."),
    ] = False,
    ros2: Annotated[bool, typer.Option("--ros2", help="ROS 2 instead of ROS 1.")] = False,
    domain: Annotated[
        int | None,
        typer.Option(min=0, max=LAST_DOMAIN, help="The domain of ROS 2; by default ROS_DOMAIN_ID, else 0."),
    ] = None,
    stamped: Annotated[
        bool,
        typer.Option(
            "--stamped", help="Drives take TwistStamped instead of Twist, as Nav2 and drivers of Jazzy do."
        ),
    ] = False,
    bare_frames: Annotated[
        str | None,
        typer.Option(metavar="ROBOT", help="Publish frames of this robot as 'odom', not 'ROBOT/odom'."),
    ] = None,
    brain: BrainName = None,
    world: WorldName = None,
    overrides: Overrides = None,
    seed: Seed = None,
    pace: Annotated[
        str | None,
        typer.Option(metavar="max|realtime|FACTOR", help="Speed relative to real time.  [default: realtime]"),
    ] = None,
    until: Annotated[
        str | None,
        typer.Option(
            metavar="TIME",
            help="Stop at this time; by default at the experiment's end, without brain at Ctrl-C.",
        ),
    ] = None,
) -> None:
    """Connect an experiment and its robots to ROS: rviz, rosbag, your nodes."""
    from nrp_core import load_experiment

    from nrp_world_ros.bridge import Style
    from nrp_world_ros.joining import join

    if lockstep and not without_brain:
        raise typer.BadParameter(
            "an experiment with a brain cannot wait for another loop", param_hint="--lockstep"
        )
    if domain is not None and not ros2:
        raise typer.BadParameter("only ROS 2 has domains: add --ros2", param_hint="--domain")
    if without_brain and brain is not None:
        raise typer.BadParameter("it has no effect with --without-brain", param_hint="--brain")
    if lockstep and pace is not None:
        raise typer.BadParameter("the other loop decides it with --lockstep", param_hint="--pace")
    with usage_errors("--until"):
        until_ns = None if until is None else time_ns(until)
        if until_ns is not None and until_ns <= 0:
            raise ValueError(f"a run ends after 0 s, not at {until}")
    settings = overrides_of(overrides, brain=brain, world=world, seed=seed, pace=pace or "realtime")
    loaded = load_experiment(experiment, settings)
    style = Style(stamped, bare_frames, _model_folders(loaded))
    if bare_frames is not None and bare_frames not in loaded.world.robots:
        raise typer.BadParameter(f"the experiment has no robot '{bare_frames}'", param_hint="--bare-frames")
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # leave ROS cleanly for any end of the run
    try:
        ros = Ros.TWO if ros2 else Ros.ONE
        queue = 0 if lockstep else _QUEUE
        with join(ros, "nrp_body", queue=queue, domain=domain, parameters=True) as node:
            if without_brain:
                _body(loaded, node, until_ns, style, lockstep=lockstep)
            else:
                _whole(loaded, node, until_ns, style)
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None


def _model_folders(experiment: Experiment) -> tuple[Path, ...]:
    """Return the folders of the experiment's models, and those in which Gazebo looks for models."""
    files = [experiment.world.scene, *(robot.model for robot in experiment.world.robots.values())]
    places = [path.parent for path in files if path is not None]
    places += experiment.models
    for variable in ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH"):
        places += [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each]
    return tuple(dict.fromkeys(places))


def _body(experiment: Experiment, node: Node, until_ns: int | None, style: Style, *, lockstep: bool) -> None:
    from nrp_core import open_world
    from nrp_core.cle.pacing import pacing_of

    from nrp_world_ros.body import Body

    with open_world(experiment) as world:
        body = Body(world, node, warn, style)
        try:
            if lockstep:
                body.run_in_lockstep(until_ns, lambda: _tell(body.bridge))
            else:
                _tell(body.bridge)
                body.run(until_ns, experiment.timestep, pacing_of(experiment.pace))
        finally:
            body.bridge.report()
            body.bridge.close()


def _whole(experiment: Experiment, node: Node, until_ns: int | None, style: Style) -> None:
    from nrp_core import Run

    from nrp_world_ros.bridge import Bridge

    with Run(experiment) as run:
        bridge = Bridge(run.world, node, run.loop.publish, warn, style)

        def exchange(_loop: object) -> None:
            bridge.check()
            bridge.send()
            bridge.receive()
            bridge.attend()

        run.loop.hooks.after_step.append(exchange)
        run.loop.hooks.after_reset.append(lambda _loop: bridge.restart())
        _tell(bridge)
        try:
            run.run_until_ns(experiment.duration if until_ns is None else until_ns)
        finally:
            bridge.report()
            bridge.close()
        result = run.result()
    for _, line in result.judgement.lines():
        typer.echo(line)
    typer.echo(f"criteria met: {result.passed}")
    if result.passed is False or not result.complete:
        raise typer.Exit(1)


def _tell(bridge: Bridge) -> None:
    topics = f"{len(bridge.outgoing)} topics to subscribe to, {len(bridge.incoming)} to publish on"
    typer.echo(f"in ROS: {topics}, {len(bridge.services)} services")
    bridge.report()
