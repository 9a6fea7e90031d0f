"""Whether real robots load, weigh what their files say, reach their commands, and fall alike on engines.

Give it robot files, or folders with files in URDF, SDF or MJCF; without any it takes the robots of
``pybullet_data`` and those of Gymnasium:

    python benchmarks/robots.py [FILE | FOLDER ...] [--engines mujoco drake] [--stand]

Each robot is held by its base. The table counts the joints that start within their limits, at the same
positions on all engines. Every joint that can be commanded then goes 0.2 rad (5 cm) from its start, within
its limits, or as far as its limit of velocity allows in half the time; joints of a loop go to the nearest
positions that close it. After 1.5 s the table counts those that are within 1 mrad (1 mm). Then, without
controllers, its joints fall for 0.5 s, and the table has the largest difference between the first engine and
each other one (rad, m): up to the moment at which a joint comes to one of its stops, and in all. No two
engines stop a joint alike, and a chain of limp joints is chaotic after it.

With ``--stand`` the robot then stands on a floor, with its lowest point on it and its joints held at their
starts; the table has the height (m) and the tilt (degrees) of its base after 2 s in each engine.
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.util import find_spec
from math import acos, degrees
from pathlib import Path

import numpy as np
from conditions import print_conditions

from nrp_core._support.arrays import BoolArray, FloatArray
from nrp_core.errors import NrpError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.model import Collision, Joint, Link, Model, Plane, Scene
from nrp_core.scene.posture import closing, start_positions
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.robot_setup import JointControl, RobotSetup, commandable, set_up_robot

ENGINES = ("mujoco", "pybullet")
STEP, SLIDE, WITHIN, SAME = 0.2, 0.05, 1e-3, 1e-6
COMMANDED_NS, LIMP_NS, SAMPLE_NS = 1_500_000_000, 500_000_000, 10_000_000
STOOD_NS = 2_000_000_000
STYLES = (".urdf", ".sdf", ".xml")
NO_NAMES = ("robot", "model")
PARTS = ("random_urdfs", "objects", "toys")
"""Folders of ``pybullet_data`` with things that are not robots."""
_MASS = re.compile(r"<mass\s+value\s*=\s*\"([^\"]+)\"|<mass>([^<]+)</mass>")
_REMARK = re.compile(r"<!--.*?-->", re.DOTALL)

Ends = dict[str, float]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("places", nargs="*", help="files and folders")
    parser.add_argument(
        "--engines", nargs="+", default=ENGINES, help="world backends; the first is the reference"
    )
    parser.add_argument("--stand", action="store_true", help="let the robots stand for 2 s, too")
    asked = parser.parse_args()
    print_conditions()
    engines = tuple(asked.engines)
    others = engines[1:]
    names = ["robot", "joints", "load, s", "mass, kg (file)", "stands", *engines]
    for other in others:
        off = f"{other} " if len(others) > 1 else ""
        names += [f"{off}apart to a stop", f"{off}apart"]
    if asked.stand:
        names += [f"stand: {engine}" for engine in engines]
    print("|", " | ".join(names), "|")
    print("|---" * len(names) + "|")
    done = 0
    for path in robots(asked.places):
        for row in measured(path, engines, asked.stand):
            done += 1
            print("|", " | ".join((*row, *[""] * (len(names) - len(row)))), "|", flush=True)
    print(f"\n{done} robots")


def robots(given: Iterable[str]) -> Iterator[Path]:
    """Yield the files to measure."""
    specs = [find_spec(name) for name in ("pybullet_data", "gymnasium.envs.mujoco")]
    shipped = [str(Path(spec.origin).parent) for spec in specs if spec is not None and spec.origin]
    for place in map(Path, list(given) or shipped):
        files = [place] if place.is_file() else sorted(p for p in place.rglob("*") if p.suffix in STYLES)
        yield from (path for path in files if not {*path.parts} & {*PARTS})


def measured(path: Path, engines: Sequence[str], stand: bool) -> Iterator[list[str]]:
    """Yield the row of each robot in a file; none for things without joints that can be commanded."""
    began = time.process_time()
    try:
        models = [read_model(path, name="robot")] if path.suffix == ".urdf" else list(read_scene(path).models)
        took = time.process_time() - began
        movable = [(model, _set_up(model, fixed=True)) for model in models if not model.static and led(model)]
    except NrpError as error:
        yield [called(path), "", "", "", f"refused: {str(error).rpartition(': ')[2][:80]}"]
        return
    for model, held in movable:
        mass = sum(link.inertial.mass for link in held.links if link.inertial)
        name = called(path) if path.suffix == ".urdf" else f"{called(path)}{path.suffix} {held.name}"
        said = written(path)
        row = [name, str(len(led(held))), f"{took:.2f}", f"{mass:.4g}{f' ({said:.4g})' if said else ''}"]
        row += [standing(held, engines), *(reached(held, engine) for engine in engines)]
        for other in engines[1:]:
            row += apart(held, engines[0], other)
        if stand:
            row += [stood(model, engine) for engine in engines]
        yield row


def called(path: Path) -> str:
    """Return the name of a file, with its folder if it says nothing."""
    return f"{path.parent.name}/{path.stem}" if path.stem in NO_NAMES else path.stem


def _set_up(model: Model, *, fixed: bool) -> Model:
    """Return a robot with position controllers at all joints: fixed above the floor, or free and on it."""
    control = tuple((re.escape(joint.name), JointControl("position")) for joint in led(model))
    bare = replace(model, drives=(), controllers=(), trajectory_controllers=(), pair_controllers=())
    robot = set_up_robot(bare, RobotSetup(fixed, control=control, on_ground=not fixed))
    return replace(robot, pose=Pose((0.0, 0.0, 3.0))) if fixed else robot


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


def standing(model: Model, engines: Sequence[str]) -> str:
    """Return how many joints start within their limits, where the other engines have them, too."""
    try:
        one, *others = (moved(model, engine, {}, 0) for engine in engines)
    except NrpError as error:
        return f"refused: {str(error)[:80]}"
    inside = [
        joint
        for joint in led(model)
        if joint.lower - SAME <= one[joint.name] <= joint.upper + SAME
        and all(abs(one[joint.name] - other[joint.name]) <= SAME for other in others)
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


def apart(model: Model, reference: str, engine: str) -> tuple[str, str]:
    """Return the largest differences between two engines after a fall without commands, as two columns."""
    try:
        one, other = (fallen(model, each) for each in (reference, engine))
    except NrpError:
        return "", ""
    differences = np.abs(one - other).max(axis=1, initial=0.0)
    free = int(np.argmax(np.append(_at_a_stop(model, one) | _at_a_stop(model, other), True)))
    until = f" ({free * SAMPLE_NS // 1_000_000} ms)" if free < len(one) else ""
    return f"{differences[:free].max(initial=0.0):.2g}{until}", f"{differences.max():.2g}"


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


def stood(model: Model, engine: str) -> str:
    """Return the height (m) and the tilt (degrees) of the base after a while on a floor."""
    floor = Model("floor", (Link("link", collisions=(Collision("plane", Plane()),)),), static=True)
    backend, starts = worlds().load(engine), start_positions(model)
    try:
        free = _set_up(model, fixed=False)
        with backend.open(Scene((floor, free)), seed=1, options=backend.options()) as world:
            for each in free.controllers:
                if each.kind == "position":
                    world.advertise(each.topic).publish(Float64(starts.get(each.joint, 0.0)))
            world.run_until(STOOD_NS)
            pose = world.model_motion(free.name).pose
    except NrpError as error:
        return f"refused: {str(error)[:80]}"
    upright = pose.rotate((0.0, 0.0, 1.0))[2]
    return f"{pose.position[2]:.3f}, {degrees(acos(max(-1.0, min(1.0, upright)))):.1f}"


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
