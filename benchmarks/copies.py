"""How fast copies of whole experiments run on one core beside physics alone, and whether they are exact.

Each copy is a whole run with its brain, its transfer functions, events and criteria, and a seed of its own.
In each step of the loop, three parts are timed one after the other, so that all see the same machine:

* the step of all copies, by :class:`nrp_lab.side_by_side.SideBySide` on one thread;
* MuJoCo's step alone, from the same states with the same controls, which has to give the same positions;
* the sensors that were due in this step, once more: images and scans, without the physics.

The last lines compare some copies with runs that are alone in their process's memory: the complete states at
the end, and in a second episode the spikes and the poses of the robots in every step.

    python benchmarks/copies.py
    python benchmarks/copies.py --copies 64 --experiment slalom_pioneer
    python benchmarks/copies.py --copies 10000 --steps 490 --experiment slalom_pioneer --whole  # 10 s each

With ``--whole`` only the step of all copies is timed: MuJoCo's data for its steps alone take 0.5 MB a copy.
"""

from __future__ import annotations

import argparse
import gc
import pickle
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from conditions import conditions, load
from nrp_lab.side_by_side import SideBySide

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.experiment import Run, load_experiment

EXPERIMENTS = ("braitenberg_husky", "slalom_pioneer")
STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class Physics:
    """The physics of the copies, once more and alone."""

    def __init__(self, runs: Sequence[Run]) -> None:
        self._engines: list[Any] = [run.world.engine for run in runs]
        self._size = mujoco.mj_stateSize(self._engines[0]._model, STATE)
        self._states = np.empty((len(runs), self._size))
        self._data = [mujoco.MjData(engine._model) for engine in self._engines]
        self._steps = runs[0].experiment.timestep // self._engines[0].capabilities.step_ns

    def remember(self) -> None:
        """Store the states of the copies, before they take a step."""
        for engine, state in zip(self._engines, self._states, strict=True):
            state[:] = engine._complete()

    def step(self) -> float:
        """Take the step that the copies have taken; return its seconds of CPU time."""
        for engine, data, state in zip(self._engines, self._data, self._states, strict=True):
            mujoco.mj_setState(engine._model, data, state, STATE)
        began = time.process_time()
        for engine, data in zip(self._engines, self._data, strict=True):
            mujoco.mj_step(engine._model, data, self._steps)
        spent = time.process_time() - began
        for engine, data in zip(self._engines, self._data, strict=True):
            assert data.qpos.tobytes() == engine._positions.tobytes(), "the physics alone differs"
        return spent


class Sensors:
    """The sensors of the copies that have subscribers, sampled once more."""

    def __init__(self, runs: Sequence[Run]) -> None:
        self._samplings = [list(run.world._board._rated.items()) for run in runs]
        self._runs = runs

    def due(self) -> list[list[int]]:
        return [[sampling.due_ns for _, sampling in each] for each in self._samplings]

    def sample(self, due_before: list[list[int]]) -> float:
        """Sample those that were due since then; return their seconds of CPU time."""
        reads = [
            (sampling.part, name, run.world.now_ns)
            for run, each, before in zip(self._runs, self._samplings, due_before, strict=True)
            for (name, sampling), due_ns in zip(each, before, strict=True)
            if sampling.due_ns != due_ns
        ]
        began = time.process_time()
        for part, name, now_ns in reads:
            part.read(name, now_ns)
        return time.process_time() - began


def resident_mb() -> float:
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def run_steps(run: Run, steps: int) -> None:
    for _ in range(steps):
        run.step()


def timed(function: Callable[[], object]) -> float:
    began = time.process_time()
    function()
    return time.process_time() - began


def stepped(together: SideBySide, runs: Sequence[Run]) -> None:
    failed = together.step([run.loop for run in runs])
    assert not failed, failed


def measure(name: str, copies: int, steps: int, warm: int, solo: int, *, whole: bool) -> None:
    with ExitStack() as opened:
        first = opened.enter_context(Run(load_experiment(name)))
        first.step()
        before_mb, began = resident_mb(), time.process_time()
        others = [opened.enter_context(Run(first.experiment, beside=first)) for _ in range(copies - 1)]
        runs = (first, *others)
        for seed, run in enumerate(runs):
            run.loop.reset(seed=seed)
        opened_ms = (time.process_time() - began) / copies * 1e3
        together = opened.enter_context(SideBySide(1))
        for _ in range(warm):
            stepped(together, runs)
        memory_mb = (resident_mb() - before_mb) / max(1, copies - 1)
        began_s = time.perf_counter()
        spent = timed_steps(together, runs, steps, whole=whole) / steps / copies
        report(name, copies, steps * first.experiment.timestep / 1e9, spent)
        print(f"  {time.perf_counter() - began_s:.1f} s elapsed")
        print(f"  {opened_ms:.1f} ms and {memory_mb:.3f} MB to open a copy and take {warm} steps")
        compare(name, runs, together, np.linspace(0, copies - 1, solo).astype(int).tolist(), warm + steps)


def timed_steps(
    together: SideBySide, runs: Sequence[Run], steps: int, *, whole: bool
) -> np.ndarray[Any, Any]:
    """Take steps; return the seconds of CPU time of all parts, or of the whole alone."""
    if whole:
        return np.array([sum(timed(partial(stepped, together, runs)) for _ in range(steps))])
    physics, sensors = Physics(runs), Sensors(runs)
    spent = np.zeros(3)
    for _ in range(steps):
        due = sensors.due()
        physics.remember()
        copied_s = timed(lambda: stepped(together, runs))
        spent += copied_s, physics.step(), sensors.sample(due)
    spent[2] += spent[1]
    return spent


def report(name: str, copies: int, simulated_s: float, spent_s: np.ndarray[Any, Any]) -> None:
    copy = spent_s[0]
    print(f"{name}: {copies} copies, {simulated_s:g} s each, {load()}")
    for what, each_s in zip(("copies", "physics alone", "with sensors"), spent_s, strict=False):
        print(f"  {what:14}{each_s * 1e6:8.1f} us a step, {each_s / copy:5.1%} of the copies' time")


def compare(name: str, runs: Sequence[Run], together: SideBySide, chosen: Sequence[int], steps: int) -> None:
    """Compare copies with runs alone."""
    spent = 0.0
    ends = {number: runs[number].snapshot() for number in chosen}
    traces = {number: Trace(runs[number]) for number in chosen}
    for seed, run in enumerate(runs):
        run.loop.reset(seed=seed)
    for _ in range(min(steps, 50)):
        stepped(together, runs)
        for trace in traces.values():
            trace.add()
    for number in chosen:
        with Run(load_experiment(name)) as run:
            run.loop.reset(seed=number)
            spent += timed(partial(run_steps, run, steps))
            same(ends[number], run.snapshot(), f"the state of copy {number}")
            trace = Trace(run)
            run.loop.reset(seed=number)
            for _ in range(min(steps, 50)):
                run.step()
                trace.add()
            same(pickle.dumps(traces[number].rows), pickle.dumps(trace.rows), f"the path of copy {number}")
    each_us = spent / len(chosen) / steps * 1e6
    print(f"  {len(chosen)} runs alone: {each_us:.1f} us a step; they end in the same states")


class Trace:
    """The spikes of a run and the poses of its robots, in every step."""

    def __init__(self, run: Run) -> None:
        neurons = np.arange(run.brain.network.size)
        self._run, self._port = run, run.brain.add_sink(SpikeRecorder(), neurons, name="benchmark")
        self.rows: list[Any] = []

    def add(self) -> None:
        spikes: Any = self._port.spikes()  # type: ignore[attr-defined]
        robots = self._run.experiment.world.robots
        poses = [self._run.world.model_motion(robot).pose for robot in robots]
        self.rows.append((spikes.neurons.tobytes(), spikes.times_ms.tobytes(), repr(poses)))


def same(copy: bytes, alone: bytes, what: str) -> None:
    assert copy == alone, f"{what} is not that of the run alone"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--copies", type=int, default=256)
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--warm", type=int, default=10, help="steps before the measurement")
    parser.add_argument("--solo", type=int, default=4, help="how many copies are compared with runs alone")
    parser.add_argument("--whole", action="store_true", help="time nothing but the step of all copies")
    parser.add_argument("--experiment", help=f"by default {' and '.join(EXPERIMENTS)}")
    given = parser.parse_args()
    if given.experiment is None:  # a process for each, for the memory of the first would be used again
        print(conditions(), flush=True)
        for name in EXPERIMENTS:
            command = [sys.executable, __file__, *sys.argv[1:], "--experiment", name]
            subprocess.run(command, check=True)
        return
    measure(given.experiment, given.copies, given.steps, given.warm, given.solo, whole=given.whole)


if __name__ == "__main__":
    main()
