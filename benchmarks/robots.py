"""Whether real robots load, weigh what their files say, reach their commands, and fall alike on both engines.

Give it robot files, or folders with files in URDF, SDF or MJCF; without any it takes the robots of
``pybullet_data`` and those of Gymnasium:

    python benchmarks/robots.py [FILE | FOLDER ...]

Each robot is held by its base. The table counts the joints that start within their limits, at the same
positions on both engines. Every joint that can be commanded then goes 0.2 rad (5 cm) from its start, within
its limits, or as far as its limit of velocity allows in half the time; joints of a loop go to the nearest
positions that close it. After 1.5 s the table counts those that are within 1 mrad (1 mm). Then, without
controllers, its joints fall for 0.5 s, and the table has the largest difference between the engines (rad,
m): up to the moment at which a joint comes to one of its stops, and in all. No two engines stop a joint
alike, and a chain of limp joints is chaotic after it.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from conditions import print_conditions

from nrp_core._support.arrays import BoolArray, FloatArray
from nrp_core.errors import NrpError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.model import Joint, Model, Scene
from nrp_core.scene.posture import closing, start_positions
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.robot_setup import JointControl, RobotSetup, commandable, set_up_robot

ENGINES = ("mujoco", "pybullet")
STEP, SLIDE, WITHIN, SAME = 0.2, 0.05, 1e-3, 1e-6
COMMANDED_NS, LIMP_NS, SAMPLE_NS = 1_500_000_000, 500_000_000, 10_000_000
STYLES = (".urdf", ".sdf", ".xml")
NO_NAMES = ("robot", "model")
PARTS = ("random_urdfs", "objects", "toys")
"""Folders of ``pybullet_data`` with things that are not robots."""
_MASS = re.compile(r"<mass\s+value\s*=\s*\"([^\"]+)\"|<mass>([^<]+)</mass>")
_REMARK = re.compile(r"<!--.*?-->", re.DOTALL)

Ends = dict[str, float]


def main() -> None:
    print_conditions()
    names = ("robot", "joints", "load, s", "mass, kg (file)", "stands", *ENGINES, "apart to a stop", "apart")
    print("|", " | ".join(names), "|")
    print("|---" * len(names) + "|")
    done = 0
    for path in robots(sys.argv[1:]):
        for row in measured(path):
            done += 1
            print(row, flush=True)
    print(f"\n{done} robots")


def robots(given: Iterable[str]) -> Iterator[Path]:
    """Yield the files to measure."""
    specs = [find_spec(name) for name in ("pybullet_data", "gymnasium.envs.mujoco")]
    shipped = [str(Path(spec.origin).parent) for spec in specs if spec is not None and spec.origin]
    for place in map(Path, list(given) or shipped):
        files = [place] if place.is_file() else sorted(p for p in place.rglob("*") if p.suffix in STYLES)
        yield from (path for path in files if not {*path.parts} & {*PARTS})


def measured(path: Path) -> Iterator[str]:
    """Yield the row of each robot in a file; none for things without joints that can be commanded."""
    began = time.process_time()
    try:
        models = [read_model(path, name="robot")] if path.suffix == ".urdf" else list(read_scene(path).models)
        took = time.process_time() - began
        held = [_held(model) for model in models if not model.static and led(model)]
    except NrpError as error:
        yield f"| {called(path)} | | | | refused: {str(error).rpartition(': ')[2][:80]} | | | | |"
        return
    for model in held:
        mass = sum(link.inertial.mass for link in model.links if link.inertial)
        ends = " | ".join(reached(model, engine) for engine in ENGINES)
        name = called(path) if path.suffix == ".urdf" else f"{called(path)}{path.suffix} {model.name}"
        count, said = len(led(model)), written(path)
        yield (
            f"| {name} | {count} | {took:.2f} | {mass:.4g}{f' ({said:.4g})' if said else ''} "
            f"| {standing(model)} | {ends} | {apart(model)} |"
        )


def called(path: Path) -> str:
    """Return the name of a file, with its folder if it says nothing."""
    return f"{path.parent.name}/{path.stem}" if path.stem in NO_NAMES else path.stem


def _held(model: Model) -> Model:
    control = ((".*", JointControl("position")),)
    bare = replace(model, drives=(), controllers=(), trajectory_controllers=(), pair_controllers=())
    return replace(set_up_robot(bare, RobotSetup(True, control=control)), pose=Pose((0.0, 0.0, 3.0)))


def written(path: Path) -> float:
    """Return the sum of the masses that a file states, kg; 0 for one in MJCF."""
    found = _MASS.findall(_REMARK.sub("", path.read_text(errors="replace")))
    return sum(float(value or text) for value, text in found)


def moved(model: Model, engine: str, goals: Ends, until_ns: int) -> Ends:
    """Return the positions of all joints after commands."""
    backend = worlds().load(engine)
    topics = {each.joint: each.topic for each in model.controllers if each.kind == "position"}
    with backend.open(Scene((model,)), seed=1, options=backend.options()) as world:
        for name, goal in goals.items():
            world.advertise(topics[name]).publish(Float64(goal))
        world.run_until(until_ns)
        states = world.joint_states(model.name)
        return dict(zip(states.names, states.positions.tolist(), strict=True))


def standing(model: Model) -> str:
    """Return how many joints start within their limits, where the other engine has them, too."""
    try:
        one, other = (moved(model, engine, {}, 0) for engine in ENGINES)
    except NrpError as error:
        return f"refused: {str(error)[:80]}"
    inside = [
        joint
        for joint in led(model)
        if joint.lower - SAME <= one[joint.name] <= joint.upper + SAME
        and abs(one[joint.name] - other[joint.name]) <= SAME
    ]
    return f"{len(inside)} of {len(led(model))}"


def reached(model: Model, engine: str) -> str:
    """Return how many joints reach their commands in an engine."""
    goals = goals_of(model)
    try:
        ends = moved(model, engine, goals, COMMANDED_NS)
    except NrpError as error:
        return f"refused: {str(error)[:80]}"
    near = [name for name, goal in goals.items() if abs(ends[name] - goal) <= WITHIN]
    return f"{len(near)} of {len(goals)}"


def apart(model: Model) -> str:
    """Return the largest differences between the engines after a fall without commands, as two columns."""
    try:
        one, other = (fallen(model, engine) for engine in ENGINES)
    except NrpError:
        return " |"
    differences = np.abs(one - other).max(axis=1, initial=0.0)
    free = int(np.argmax(np.append(_at_a_stop(model, one) | _at_a_stop(model, other), True)))
    until = f" ({free * SAMPLE_NS // 1_000_000} ms)" if free < len(one) else ""
    return f"{differences[:free].max(initial=0.0):.2g}{until} | {differences.max():.2g}"


def fallen(model: Model, engine: str) -> FloatArray:
    """Return the positions of the joints without controllers, (n_samples, n_coordinates)."""
    backend = worlds().load(engine)
    samples = []
    limp = replace(model, controllers=())  # these would hold them
    with backend.open(Scene((limp,)), seed=1, options=backend.options()) as world:
        for time_ns in range(SAMPLE_NS, LIMP_NS + 1, SAMPLE_NS):
            world.run_until(time_ns)
            samples.append(world.joint_states(model.name).positions.copy())
    return np.array(samples)


def _at_a_stop(model: Model, positions: FloatArray) -> BoolArray:
    """Return at which samples a joint is beyond a stop or will be by the next one, (n_samples,)."""
    limits = [(each.lower, each.upper) for each in model.joints for _ in each.coordinates]
    lower, upper = np.array(limits).T
    next_ones = positions + np.diff(positions, axis=0, append=positions[-1:])
    outside = (np.minimum(positions, next_ones) < lower) | (np.maximum(positions, next_ones) > upper)
    return np.asarray(outside.any(axis=1))


def led(model: Model) -> list[Joint]:
    """Return the joints to command, without ball joints, which take orientations."""
    return [joint for joint in commandable(model) if joint.kind != "ball"]


def goals_of(model: Model) -> Ends:
    """Return where each joint is to go; those of loops where the loops stay closed."""
    starts, wanted = start_positions(model), {}
    for joint in led(model):
        far = SLIDE if joint.kind == "prismatic" else STEP
        start, step = starts.get(joint.name, 0.0), min(far, joint.velocity * COMMANDED_NS * 1e-9 / 2)
        up, down = min(step, joint.upper - start), min(step, start - joint.lower)
        wanted[joint.name] = start + up if up >= down else start - down
    closed = closing(model, wanted, ()) if model.loops else wanted
    return {name: closed.get(name, 0.0) for name in wanted}


if __name__ == "__main__":
    main()
