"""The CPU time of Gymnasium's Ant as an environment, beside MuJoCo alone and Gymnasium's own environments.

The Ant is the file in MJCF that ships with Gymnasium, a scene with a brain of one silent cell. Its motors
obey the actions; pose, velocities and joints are observed, as in Ant-v5. In each step three things are timed
one after the other, so that all see the same machine:

* the step of the environment: one copy alone, or all copies of ``make_vec``;
* ``mj_step`` for each copy, from the same states with the same controls, which must give the same positions;
* the step of ``SyncVectorEnv`` and ``AsyncVectorEnv`` of Ant-v5, where ``pip install 'gymnasium[mujoco]'`` or
  at least ``glfw imageio`` are installed.

    python benchmarks/ant.py
    python benchmarks/ant.py --copies 1 --steps 900
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from importlib.resources import files
from importlib.util import find_spec
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
from conditions import conditions, load
from nrp_lab.gym import make_env, make_vec

JOINTS = [f"{joint}_{leg}" for leg in (4, 1, 2, 3) for joint in ("hip", "ankle")]  # as the file's motors
NAMES = [f"/torso/{joint}/cmd_effort" for joint in JOINTS]
AGENT: dict[str, Any] = {
    "observe": ["motion:torso", "joints:torso"],
    "act": {name: {"data": (-150.0, 150.0)} for name in NAMES},
}
SUBSTEPS, GEAR = 5, 150.0
STATE = mujoco.mjtState.mjSTATE_INTEGRATION
EXPERIMENT = """
name: ant
duration: 50 s
timestep: 50 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: ant.xml, options: {timestep: 10 ms}}
"""
BRAIN = """
from nrp_core import pynn as sim
sim.setup(timestep=0.5)
circuit = sim.Population(1, sim.IF_curr_exp())
"""


def write_experiment(folder: Path) -> Path:
    scene = (files("gymnasium") / "envs/mujoco/assets/ant.xml").read_text()
    for name, text in {"ant.xml": scene, "brain.py": BRAIN, "experiment.yaml": EXPERIMENT}.items():
        (folder / name).write_text(text)
    return folder / "experiment.yaml"


def cpu_s() -> float:
    """Return the CPU time of this process and its children."""
    ticks = [
        int(field)
        for child in active_children()
        for field in Path(f"/proc/{child.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
    ]
    return time.process_time() + sum(ticks) / os.sysconf("SC_CLK_TCK")


def spent_s(call: Callable[[], object]) -> float:
    began = time.process_time()
    call()
    return time.process_time() - began


class Physics:
    """MuJoCo alone."""

    def __init__(self, engines: list[Any]) -> None:
        self._engines = engines
        self._data = [mujoco.MjData(engine._model) for engine in engines]

    def load(self) -> None:
        for engine, data in zip(self._engines, self._data, strict=True):
            mujoco.mj_setState(engine._model, data, engine._complete(), STATE)

    def step(self, efforts: Any) -> None:
        for engine, data, row in zip(self._engines, self._data, efforts, strict=True):
            data.ctrl[:] = row
            mujoco.mj_step(engine._model, data, SUBSTEPS)

    def compare(self) -> None:
        for engine, data in zip(self._engines, self._data, strict=True):
            assert data.qpos.tobytes() == engine._positions.tobytes(), "the physics alone differs"


def measure(what: str, step: Callable[[Any], object], physics: Physics, rows: Any) -> None:
    """Print the CPU time of steps, with the same rows of efforts for each copy, and that of MuJoCo alone."""
    spent = np.zeros(2)
    for efforts in rows:
        physics.load()
        spent += spent_s(partial(step, efforts)), spent_s(partial(physics.step, efforts))
        physics.compare()
    copy_us, alone_us = spent / rows.shape[0] / rows.shape[1] * 1e6
    ratio = copy_us / alone_us
    print(f"{what:34}{copy_us:8.1f} us a step and copy, MuJoCo {alone_us:6.1f}, ratio {ratio:.2f}; {load()}")


def gymnasium_own(kind: Any, rows: Any) -> None:
    with closing(kind([lambda: gymnasium.make("Ant-v5")] * rows.shape[1])) as envs:
        envs.reset(seed=1)
        envs.step(np.zeros(rows.shape[1:], np.float32))
        began = cpu_s()
        for row in rows:
            envs.step((row / GEAR).astype(np.float32))
        each_us = (cpu_s() - began) / rows.shape[0] / rows.shape[1] * 1e6
        print(f"Gymnasium, {kind.__name__:23}{each_us:8.1f} us a step and copy; {load()}")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--copies", type=int, default=64)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    print(conditions())
    rows = np.random.default_rng(1).uniform(-GEAR, GEAR, (given.steps, given.copies, len(JOINTS)))
    with tempfile.TemporaryDirectory() as folder, ExitStack() as opened:
        path = write_experiment(Path(folder))
        env = opened.enter_context(closing(make_env(path, **AGENT)))
        envs: Any = opened.enter_context(closing(make_vec(path, num_envs=given.copies, threads=1, **AGENT)))

        def alone(efforts: Any) -> None:
            env.step({name: efforts[0, [place]] for place, name in enumerate(NAMES)})

        def together(efforts: Any) -> None:
            envs.step({name: efforts[:, [place]] for place, name in enumerate(NAMES)})

        one, all_ = Physics([env.run.world.engine]), Physics([run.world.engine for run in envs.runs])
        for _ in range(given.rounds):
            env.reset(seed=1)
            envs.reset(seed=1)
            alone(rows[0])
            together(rows[0])
            measure("one environment", alone, one, rows[:, :1])
            measure(f"make_vec, {given.copies} copies", together, all_, rows)
            for kind in (gymnasium.vector.SyncVectorEnv, gymnasium.vector.AsyncVectorEnv):
                if find_spec("glfw") and find_spec("imageio"):
                    gymnasium_own(kind, rows)


if __name__ == "__main__":
    main()
