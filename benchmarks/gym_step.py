"""What a step as an environment of Gymnasium adds to the step of a run, and what a reset takes.

The environment observes the robot's motion and a firing rate, and commands the robot. The same run takes
steps of its own, steps before which the same command is published, and steps of the environment in turn, so
that a busy machine slows all. Each comes after a step of the environment that is not timed: one that reads
a firing rate adds up the spikes since the last time. Where functions drive the robot, they publish a command
too. CPU time, least and median.

    python benchmarks/gym_step.py
    python benchmarks/gym_step.py --steps 2000
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import closing
from statistics import median
from typing import Any

from conditions import conditions, load
from nrp_lab.gym import make_env

CASES: dict[str, dict[str, Any]] = {
    "braitenberg_husky": {
        "overrides": ["world.options.image_scale=0.25"],
        "observe": ["motion:husky", "rate:actors"],
        "act": ["/husky/cmd_vel"],
    },
    "slalom_pioneer": {"observe": ["motion:pioneer", "rate:feelers"], "act": ["/pioneer/cmd_vel"]},
}


def cpu_us(call: Callable[[], object]) -> float:
    """Return the CPU time of a call."""
    began = time.process_time_ns()
    call()
    return (time.process_time_ns() - began) / 1e3


def shown(times_us: list[float]) -> str:
    return f"{min(times_us):6.0f} (median {median(times_us):6.0f})"


def more(times_us: list[float], base_us: list[float]) -> str:
    least, typical = min(times_us) / min(base_us) - 1, median(times_us) / median(base_us) - 1
    return f"{least:+.1%} (median {typical:+.1%})"


def measure(name: str, steps: int, settings: dict[str, Any]) -> None:
    with closing(make_env(name, same_noise=True, **settings)) as env:
        env.action_space.seed(1)
        action = env.action_space.sample()
        (topic,) = settings["act"]
        command, info = env.run.world.advertise(topic), env.run.world.topics[topic]
        message = info.type()
        message.linear.x, message.angular.z = 0.2, 0.1

        def commanded_step() -> None:
            command.publish(message)
            env.run.step()

        bare: list[float] = []
        commanded: list[float] = []
        whole: list[float] = []
        resets: list[float] = []
        kinds = (whole, lambda: env.step(action)), (bare, env.run.step), (commanded, commanded_step)
        while len(bare) < steps:
            resets.append(cpu_us(env.reset))
            for _ in range(25):  # in this order, sensors of every rate fall into all kinds of steps
                for times_us, step in (*kinds, *reversed(kinds)):
                    env.step(action)
                    times_us.append(cpu_us(step))
        print(
            f"{name}: step {shown(whole)} us; of the run {shown(bare)} us, {more(whole, bare)}; "
            f"of the run with a command {shown(commanded)} us, {more(whole, commanded)}; "
            f"reset {shown(resets)} us; {load()}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--steps", type=int, default=1000)
    given = parser.parse_args()
    print(conditions())
    for name, settings in CASES.items():
        measure(name, given.steps, settings)


if __name__ == "__main__":
    main()
