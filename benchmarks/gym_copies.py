"""How much faster than real time many copies of an experiment run as one environment of Gymnasium.

Copies of the Braitenberg experiment, each with its Husky and its brain of 8 cells, without a camera. The
agent commands the robot and drives the eyes, and sees the motion of the robot and the rate of its neurons.
First without Python functions, then with a reward computed for each copy, then with the transfer function of
the paper that drives the wheels. The factors are simulated seconds of all copies per second of CPU time (one
core) and of wall time (all cores together); the CPU time is that of all processes. For comparison, MuJoCo's
own batch takes the physics steps alone.

    python benchmarks/gym_copies.py
    python benchmarks/gym_copies.py --copies 64 --rounds 5
    python benchmarks/gym_copies.py --processes 2
"""

from __future__ import annotations

import argparse
import os
import time
from contextlib import closing
from importlib.resources import files
from pathlib import Path
from typing import Any

from batch import raw_mujoco
from conditions import conditions, load
from nrp_lab.gym import make_vec

STEPS = 25
STEP_S = 0.02
BARE = ["criteria=null", "events=null"]
WITHOUT_FUNCTIONS = ["transfer_functions=[]", *BARE]
SEEN = ["motion:husky", "rate:actors"]
EYES: dict[str, Any] = {"source:sensors": (0.0, 200.0, 0.00015)}
WHEELS: dict[str, Any] = {"/husky/cmd_vel": {"linear.x": (0, 0.5), "angular.z": (-1, 1)}}


def cpu_time_s(envs: Any) -> float:
    """Return the CPU time of this process and of those of the copies."""
    ticks = [
        int(field)
        for worker in getattr(envs, "_workers", ())
        for field in Path(f"/proc/{worker.process.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
    ]
    return time.process_time() + sum(ticks) / os.sysconf("SC_CLK_TCK")


def measured(what: str, copies: int, rounds: int, overrides: list[str], **settings: Any) -> None:
    began = time.process_time()
    with closing(make_vec("braitenberg_husky", overrides, num_envs=copies, observe=SEEN, **settings)) as envs:
        opened = (cpu_time_s(envs) - began) / copies
        envs.reset(seed=1)
        envs.action_space.seed(1)
        actions = [envs.action_space.sample() for _ in range(STEPS)]
        envs.step(actions[0])
        print(f"{what}; {opened * 1e3:.1f} ms to open a copy")
        for _ in range(rounds):
            cpu, wall = cpu_time_s(envs), time.perf_counter()
            for action in actions:
                envs.step(action)
            cpu_s, wall_s = cpu_time_s(envs) - cpu, time.perf_counter() - wall
            cpu = cpu_time_s(envs)
            envs.reset()
            reset_s = (cpu_time_s(envs) - cpu) / copies
            simulated = copies * STEPS * STEP_S
            each_us = cpu_s / copies / STEPS * 1e6
            print(
                f"  {each_us:6.0f} us a step and copy, real time times {simulated / cpu_s:5.1f} a core and "
                f"{simulated / wall_s:5.1f} in all; reset {reset_s * 1e3:.2f} ms a copy; {load()}"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--copies", type=int, default=256)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--processes", type=int, default=1)
    given = parser.parse_args()
    copies, rounds = given.copies, given.rounds
    print(f"{conditions()}, {copies} copies")
    raw_mujoco(copies, 1)
    shared = {"processes": given.processes}
    measured("without functions", copies, rounds, WITHOUT_FUNCTIONS, act=EYES | WHEELS, **shared)
    rewarded: dict[str, Any] = {"reward": lambda _, seen: float(seen["motion:husky"][0])}
    measured("with a reward", copies, rounds, WITHOUT_FUNCTIONS, act=EYES | WHEELS, **rewarded | shared)
    wheels = files("nrp_experiments.braitenberg_husky") / "listing1.py"
    overrides = [f"transfer_functions=[{wheels}]", *BARE]
    measured("with the transfer function of the wheels", copies, rounds, overrides, act=EYES, **shared)
    raw_mujoco(copies, 1)


if __name__ == "__main__":
    main()
