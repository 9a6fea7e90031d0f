"""How much faster than real time many copies of one scene run in one process, all robots driving at random.

Copies of the Braitenberg room with its Husky, without cameras; every step each robot gets a command of its
own and reports its pose; then the same with the Braitenberg brain of 8 cells beside each robot, whose sensors
are driven and whose actors are read, without transfer functions. For comparison, MuJoCo's own batch of the
same model takes the same physics steps and does nothing else. The factors are simulated seconds of all copies
per second of CPU (one core) and of wall time (all cores together).

    python benchmarks/batch.py
    python benchmarks/batch.py --copies 64 --engine pybullet
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from functools import cache

import numpy as np
from brain_step import braitenberg
from conditions import print_conditions
from world_step import STEP_NS, SUBSTEP_NS, SUBSTEPS, shipped_scene

from nrp_core.brain.backends import brains as brain_backends
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha
from nrp_core.brain.devices.sources import PoissonSource
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


def ours(engine: str, copies: int, threads: int, with_brains: bool) -> None:
    backend, random = worlds().load(engine), np.random.default_rng(1)
    began = time.process_time()
    batch = backend.open_batch(
        shipped_scene(), seeds=range(copies), options=backend.options(), threads=threads
    )
    opened = time.process_time() - began
    with batch, ExitStack() as opened_brains:
        publication = batch.advertise("/husky/cmd_vel")
        rows = np.zeros((copies, 6))
        brains = [opened_brains.enter_context(_Brain(seed)) for seed in range(copies if with_brains else 0)]

        def step() -> None:
            rows[:, 0], rows[:, 5] = random.uniform(0, 0.5, copies), random.uniform(-1, 1, copies)
            publication.publish(rows)
            for brain, rate in zip(brains, random.uniform(0, 200, len(brains)).tolist(), strict=True):
                brain.step(rate)
            batch.run_until(batch.now_ns + STEP_NS)
            batch.motions("husky")

        what = f"{engine} with brains" if with_brains else engine
        report(f"{what}, {copies} copies", copies, *measure(step))
    print(f"{'':32} {opened / copies * 1e3:8.1f} ms to open a world")


class _Brain(AbstractContextManager["_Brain"]):
    """The brain of one robot, its sensors driven at one rate, its actors read as voltages."""

    network = cache(braitenberg)

    def __init__(self, seed: int) -> None:
        backend = brain_backends().load("event")
        self._brain = backend.open(_Brain.network(), seed=seed, options=backend.options())
        self._eyes = self._brain.add_source(PoissonSource(), range(5), name="eyes")
        self._wheels = [
            self._brain.add_sink(LeakyIntegratorAlpha(), [cell], name=f"wheel {cell}") for cell in (6, 7)
        ]

    def step(self, rate_hz: float) -> None:
        self._eyes.rate = rate_hz  # type: ignore[attr-defined]
        self._brain.run_until(self._brain.now_ns + STEP_NS)
        for wheel in self._wheels:
            assert np.isfinite(wheel.voltage)  # type: ignore[attr-defined]

    def __exit__(self, *_: object) -> None:
        self._brain.close()


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
        for with_brains in (False, True):
            ours(engine, arguments.copies, arguments.threads, with_brains)


if __name__ == "__main__":
    main()
