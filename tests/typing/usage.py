"""What users and authors write, as type checkers see it; mypy checks this file, nothing runs it."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, assert_type

from nrp_lab.comparison import RunSignals, ScalarMetric

import nrp_core
from nrp_core import (
    Brain,
    Experiment,
    Finding,
    Network,
    Pose,
    Recording,
    Result,
    Run,
    Scene,
    World,
    brains,
    geometry_msgs,
    load_experiment,
    load_network,
    read_scene,
    run,
    validate,
    worlds,
)
from nrp_core.brain import BrainBackend, BrainCapabilities, BrainOptions, FloatArray, IntArray, Spikes
from nrp_core.registry import Registry
from nrp_core.world import BodyVelocity, Engine, ModelMotion, WorldBackend, WorldCapabilities, WorldOptions


def one_call() -> None:
    result = run("braitenberg_husky", ["seed=3"], until_s=5.0, record=Path("out"))
    assert_type(result, Result)
    assert_type(result.passed, bool | None)
    assert_type(nrp_core.run("braitenberg_husky").final_pose["husky"]["x"], float)


def by_hand() -> None:
    experiment = load_experiment("braitenberg_husky")
    assert_type(experiment, Experiment)
    assert_type(validate(experiment), list[Finding])
    with Run(experiment) as simulation:
        assert_type(simulation, Run)
        assert_type(simulation.brain, Brain)
        assert_type(simulation.world, World)
        simulation.publish("/husky/cmd_vel", geometry_msgs.Twist(linear=geometry_msgs.Vector3(0.5)))
        simulation.run_until(1.0)


def files() -> None:
    assert_type(load_network(Path("brain.py")), Network)
    assert_type(read_scene(Path("room.sdf")), Scene)
    assert_type(Recording(Path("out")), Recording)


def backends() -> None:
    assert_type(brains(), Registry[BrainBackend])
    assert_type(worlds().load("mujoco"), WorldBackend)


class Stops(ScalarMetric):
    name: ClassVar[str] = "stops"
    title: ClassVar[str] = "Stops"

    def values(self, run: RunSignals) -> dict[str, float | None]:
        return dict.fromkeys(run.robots, 0.0)


class MyBrainBackend(BrainBackend):
    def capabilities(self, options: BrainOptions) -> BrainCapabilities:
        raise NotImplementedError

    def open(self, network: Network, *, seed: int, options: BrainOptions) -> Brain:
        raise NotImplementedError


class MyWorldBackend(WorldBackend):
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        raise NotImplementedError

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        raise NotImplementedError


def values(ids: IntArray, times_ms: FloatArray) -> None:
    assert_type(Spikes(ids, times_ms).times_ms, FloatArray)
    assert_type(Pose((0.0, 0.0, 1.0)), Pose)
    assert_type(ModelMotion(Pose(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)).pose, Pose)
    assert_type(BodyVelocity(), BodyVelocity)
