"""What lockstep and messages cost beside Gazebo's own steps and images, in CPU time of both processes.

The room and the robot are those of the Braitenberg experiment. Gazebo's own: many steps of 20 ms, or many
images, in one request. The world: every step brings a command and reads the poses of all models, and every
image is one of the camera. Best of several rounds that take turns.

    export NRP_GAZEBO_ROOT=...
    python benchmarks/gazebo_step.py
    python benchmarks/gazebo_step.py --steps 500 --rounds 5
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from conditions import conditions
from world_step import CAMERA, STEP_NS, SUBSTEPS, shipped_scene

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.backends import worlds
from nrp_core.world.world import World

TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")


def server_of(world: Any) -> Path:
    """Return the process of a world's Gazebo, in ``/proc``."""
    file = bytes(world.engine._built.gazebo._run.world)
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:  # it has just ended
            continue
        if words[0].endswith(b"gzserver") and file in words:
            return process
    raise ProcessLookupError("gzserver")


def used_s(server: Path) -> float:
    """Return the CPU time of Gazebo and of this process, s."""
    user, system = (server / "stat").read_text().rpartition(") ")[2].split()[11:13]
    return TICK_S * (int(user) + int(system)) + time.process_time()


def cost_ms(server: Path, work: Callable[[], object], count: int) -> float:
    """Return the CPU time of both processes for one of ``count`` things, ms."""
    before = used_s(server)
    work()
    return 1e3 * (used_s(server) - before) / count


def step_all(world: World, steps: int) -> None:
    commands = world.advertise("/husky/cmd_vel")
    states = world.subscribe("/gazebo/model_states")
    for step in range(steps):
        commands.publish(Twist(Vector3(0.3), Vector3(0.0, 0.0, 0.5 if step % 100 < 50 else -0.5)))
        world.run_until(world.now_ns + STEP_NS)
    assert states.latest is not None


def compare(
    title: str, world: World, own: Callable[[], Any], ours: Callable[[], Any], count: int, rounds: int
) -> None:
    server = server_of(world)
    pairs = [(cost_ms(server, own, count), cost_ms(server, ours, count)) for _ in range(rounds)]
    raw, all_of = min(pair[0] for pair in pairs), min(pair[1] for pair in pairs)
    print(f"| {title} | {raw:.3f} | {all_of:.3f} | {all_of - raw:+.3f} | {all_of / raw:.2f} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--images", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    steps, images, rounds = arguments.steps, arguments.images, arguments.rounds
    backend = worlds().load("gazebo")
    print(f"{conditions()}\n\n| what | Gazebo's own, ms | world, ms | more, ms | times |")
    print("| --- | --- | --- | --- | --- |")
    with backend.open(shipped_scene(), seed=1, options=backend.options()) as world:
        step_all(world, 50)
        own = lambda: world.engine.advance(steps * SUBSTEPS)  # noqa: E731
        compare("a step of 20 ms", world, own, lambda: step_all(world, steps), steps, rounds)
    own_renderer = backend.options.model_validate({"renderer": "gazebo"})
    with backend.open(shipped_scene(), seed=1, options=own_renderer) as world:
        from nrp_world_gazebo.wire import operation

        gazebo = world.engine._built.gazebo  # type: ignore[attr-defined]
        compare(
            "an image of 320x240",
            world,
            lambda: gazebo.ask(operation("i", 0) * images),
            lambda: [world.engine.render(*CAMERA) for _ in range(images)],
            images,
            rounds,
        )


if __name__ == "__main__":
    main()
