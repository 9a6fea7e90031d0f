"""How much faster than real time many copies of one scene run in one process, all robots driving at random.

Copies of the Braitenberg room with its Husky, without cameras; every step each robot gets a command of its
own and reports its pose. For comparison, MuJoCo's own batch of the same model takes the same physics steps
and does nothing else. The factors are simulated seconds of all copies per second of CPU (one core) and of
wall time (all cores together).

    python benchmarks/batch.py
    python benchmarks/batch.py --copies 64 --engine pybullet
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from conditions import print_conditions
from world_step import STEP_NS, SUBSTEP_NS, SUBSTEPS, shipped_scene

from nrp_core.world.backends import worlds

STEPS = 25


def measure(step: Callable[[], object]) -> tuple[float, float]:
    """Return CPU and wall seconds of all steps, after one that warms up."""
    step()
    cpu, wall = time.process_time(), time.perf_counter()
    for _ in range(STEPS):
        step()
    return time.process_time() - cpu, time.perf_counter() - wall


def report(what: str, copies: int, cpu_s: float, wall_s: float) -> None:
    simulated = copies * STEPS * STEP_NS / 1e9
    print(f"{what:32} {cpu_s / copies / STEPS * 1e6:8.1f} us a step {simulated / cpu_s:8.1f} of CPU time "
          f"{simulated / wall_s:8.1f} of wall time")  # fmt: skip


def ours(engine: str, copies: int, threads: int) -> None:
    backend, random = worlds().load(engine), np.random.default_rng(1)
    began = time.process_time()
    batch = backend.open_batch(
        shipped_scene(), seeds=range(copies), options=backend.options(), threads=threads
    )
    opened = time.process_time() - began
    with batch:
        publication = batch.advertise("/husky/cmd_vel")
        rows = np.zeros((copies, 6))

        def step() -> None:
            rows[:, 0], rows[:, 5] = random.uniform(0, 0.5, copies), random.uniform(-1, 1, copies)
            publication.publish(rows)
            batch.run_until(batch.now_ns + STEP_NS)
            batch.motions("husky")

        report(f"{engine}, {copies} copies", copies, *measure(step))
    print(f"{'':32} {opened / copies * 1e3:8.1f} ms to open a world")


def raw_mujoco(copies: int, threads: int) -> None:
    from mujoco.batch import Batch
    from nrp_world_mujoco.build import build

    scene, random = shipped_scene(), np.random.default_rng(1)
    built = build(scene, timestep_ns=SUBSTEP_NS)
    batch = Batch(built.model, nsim=copies, nthread=threads)
    controls = batch.bind("ctrl")

    def step() -> None:
        controls[:] = random.uniform(0, 0.5, (copies, 1))
        batch.step(nstep=SUBSTEPS)

    report(f"mujoco.batch, {copies} copies", copies, *measure(step))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--copies", type=int, default=256)
    parser.add_argument("--engine", choices=("mujoco", "pybullet"), action="append")
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    print_conditions()
    for engine in arguments.engine or ("mujoco", "pybullet"):
        if engine == "mujoco":
            raw_mujoco(arguments.copies, arguments.threads)
        ours(engine, arguments.copies, arguments.threads)


if __name__ == "__main__":
    main()
