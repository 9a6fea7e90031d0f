"""How far wheel drives lead a robot away from the ideal unicycle, and what they cost, by option and engine.

Commands that hold for two seconds on flat ground, from rest: half a metre a second, half a radian a second,
both. ``skid x1.875`` is the Husky with a wheel separation multiplied as its maker does for the real robot.

    python benchmarks/wheels.py
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from importlib.resources import files
from math import cos, degrees, hypot, sin
from pathlib import Path

from conditions import print_conditions

from nrp_core.world.backends import worlds
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Collision, Link, Model, Plane, Scene
from nrp_core.world.scene.sdf import read_model

STEP_NS, STEPS = 20_000_000, 100
COMMANDS = {"ahead": (0.5, 0.0), "turn": (0.0, 0.5), "both": (0.5, 0.5)}


def robots() -> Iterator[tuple[str, Model]]:
    """Yield robots that listen to ``/cmd_vel``."""
    folder = Path(str(files("nrp_experiments")))
    pioneer = read_model(folder / "bodies" / "pioneer.sdf", name="robot")
    husky = read_model(
        folder / "braitenberg_husky" / "husky.sdf", name="robot", pose=Pose((0.0, 0.0, 0.14275))
    )
    yield "two wheels (Pioneer)", driven(pioneer)
    yield "skid (Husky)", driven(husky)
    yield "skid x1.875", driven(husky, 1.875)


def driven(model: Model, widened: float = 1.0) -> Model:
    (drive,) = model.drives
    assert isinstance(drive, WheelDrive)
    wider = replace(drive, command_topic="/cmd_vel", separation=widened * drive.separation)
    return replace(model, drives=(wider,))


def ideal(forward: float, turn: float) -> tuple[float, float, float]:
    heading = turn * STEPS * STEP_NS / 1e9
    if not turn:
        return forward * STEPS * STEP_NS / 1e9, 0.0, 0.0
    return forward / turn * sin(heading), forward / turn * (1 - cos(heading)), heading


def errors(engine: str, mode: str, robot: Model) -> tuple[list[str], float]:
    """Return the errors for each command, and CPU microseconds a step."""
    floor = Model(
        "floor", (Link("link", collisions=(Collision("ground", Plane((60.0, 60.0))),)),), static=True
    )
    backend, found = worlds().load(engine), []
    began = time.process_time()
    options = backend.options.model_validate({"drive": mode})
    with backend.open(Scene((floor, robot)), seed=1, options=options) as world:
        opened, commands = time.process_time() - began, world.advertise("/cmd_vel")
        for forward, turn in COMMANDS.values():
            world.reset()
            start = world.model_motion("robot").pose
            for _ in range(STEPS):
                commands.publish(Twist(Vector3(forward), Vector3(z=turn)))
                world.run_until(world.now_ns + STEP_NS)
            pose, (x, y, heading) = start.inverse() @ world.model_motion("robot").pose, ideal(forward, turn)
            away = hypot(pose.position[0] - x, pose.position[1] - y)
            found.append(f"{100 * away:5.1f} cm {degrees(pose.yaw - heading):6.1f} deg")
    return found, (time.process_time() - began - opened) / len(COMMANDS) / STEPS * 1e6


def main() -> None:
    print_conditions()
    print(f"{'robot':22}{'engine':10}{'drive':10}", *(f"{name:>20}" for name in COMMANDS), f"{'us':>8}")
    for name, robot in robots():
        for engine in ("mujoco", "pybullet"):
            for mode in ("planar", "physical"):
                found, cost_us = errors(engine, mode, robot)
                print(f"{name:22}{engine:10}{mode:10}", *(f"{each:>20}" for each in found), f"{cost_us:8.0f}")


if __name__ == "__main__":
    main()
