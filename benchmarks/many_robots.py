"""How fast a room full of Huskies runs: all driving at random, without cameras, odometry read or not.

python benchmarks/many_robots.py
python benchmarks/many_robots.py --robots 10 --engine pybullet
"""

from __future__ import annotations

import argparse
import time
from importlib.resources import files
from pathlib import Path

import numpy as np
from conditions import print_conditions

from nrp_core.world.backends import worlds
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.sdf import read_model, read_scene

STEP_NS, STEPS = 20_000_000, 100


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", type=int, default=50)
    parser.add_argument("--engine", default="mujoco")
    arguments = parser.parse_args()
    print_conditions()
    folder = Path(str(files("nrp_experiments") / "braitenberg_husky"))
    scene = read_scene(folder / "room.sdf")
    for number in range(arguments.robots):
        place = Pose((1.2 * (number % 8) - 4.2, 1.2 * (number // 8) - 4.2, 0.15))
        scene = scene.with_model(read_model(folder / "husky.sdf", name=f"husky{number}", pose=place))
    backend = worlds().load(arguments.engine)
    with backend.open(scene, seed=1, options=backend.options()) as world:
        names = [f"husky{number}" for number in range(arguments.robots)]
        topics = [name for name in world.topics if name.endswith("/cmd_vel")]
        odometry = [name for name in world.topics if name.endswith("/odom")]
        commands, random = [world.advertise(topic) for topic in topics], np.random.default_rng(1)
        for read in (False, True):
            subscriptions = [world.subscribe(name) for name in odometry if read]
            started = time.process_time()
            for _ in range(STEPS):
                for command in commands:
                    forward, turn = random.uniform(-0.4, 0.4, 2)
                    command.publish(Twist(Vector3(forward), Vector3(z=turn)))
                world.run_until(world.now_ns + STEP_NS)
            factor = STEPS * STEP_NS / 1e9 / (time.process_time() - started)
            what = "with odometry" if read else "without odometry"
            print(f"{arguments.engine}, {len(names)} robots, {what}: {factor:.2f} times real time")
            for subscription in subscriptions:
                world.unsubscribe(subscription)


if __name__ == "__main__":
    main()
