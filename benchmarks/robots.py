"""Whether real robots load, weigh what their files say, and reach what is commanded, on both engines.

Give it robot files, or folders with URDF files; without any it takes the robots of ``pybullet_data``:

    python benchmarks/robots.py [FILE | FOLDER ...]

Each robot is held by its base. Every joint that can be commanded goes 0.2 rad (5 cm) from its start, within
its limits; after 1.5 s the table counts the joints that are within 1 mrad (1 mm).
"""

from __future__ import annotations

import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from nrp_core.errors import NrpError
from nrp_core.world.backends import worlds
from nrp_core.world.fitting import Fitting, JointControl, commandable, fitted
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.sdf import read_model
from nrp_core.world.scene.starts import start_positions

ENGINES = ("mujoco", "pybullet")
STEP, SLIDE, WITHIN = 0.2, 0.05, 1e-3
PARTS = ("random_urdfs", "objects", "toys")
"""Folders of ``pybullet_data`` with things that are not robots."""


def main() -> None:
    print("| robot | joints | load, s | mass, kg (file) | mujoco | pybullet |")
    print("|---|---|---|---|---|---|")
    done = 0
    for path in robots(sys.argv[1:]):
        row = measured(path)
        if row is not None:
            done += 1
            print(row, flush=True)
    print(f"\n{done} robots")


def robots(given: Iterable[str]) -> Iterator[Path]:
    """Yield the files to measure."""
    spec = find_spec("pybullet_data")
    shipped = [str(Path(spec.origin).parent)] if spec is not None and spec.origin else []
    for place in map(Path, list(given) or shipped):
        files = [place] if place.is_file() else sorted(place.rglob("*.urdf"))
        yield from (path for path in files if not {*path.parts} & {*PARTS})


def measured(path: Path) -> str | None:
    """Return the row of a robot; None for a thing without joints that can be commanded."""
    began = time.process_time()
    try:
        model = read_model(path, name="robot")
        took = time.process_time() - began
        if model.static or not commandable(model):
            return None
        model = fitted(model, Fitting(True, control=((".*", JointControl("position")),)))
    except NrpError as error:
        return f"| {path.stem} | | | | refused: {str(error).rpartition(': ')[2][:80]} | |"
    mass = sum(link.inertial.mass for link in model.links if link.inertial)
    held = replace(model, drives=(), pose=Pose((0.0, 0.0, 3.0)))
    ends = " | ".join(reached(held, engine) for engine in ENGINES)
    count = len(commandable(model))
    return f"| {path.stem} | {count} | {took:.2f} | {mass:.4g} ({written(path):.4g}) | {ends} |"


def written(path: Path) -> float:
    """Return the sum of the masses in a URDF file, kg."""
    links = ET.parse(path).getroot().iter("link")
    masses = [mass for link in links for mass in link.iter("mass")]
    return sum(float(mass.get("value", 0.0)) for mass in masses)


def reached(model: Model, engine: str) -> str:
    """Return how many joints reach their commands in an engine."""
    backend = worlds().load(engine)
    topics = {each.joint: each.topic for each in model.controllers if each.kind == "position"}
    try:
        with backend.open(Scene((model,)), seed=1, options=backend.options()) as world:
            goals = dict(goals_of(model))
            for name, goal in goals.items():
                world.advertise(topics[name]).publish(Float64(goal))
            world.run_until(1_500_000_000)
            states = world.joint_states("robot")
            ends = dict(zip(states.names, states.positions.tolist(), strict=True))
    except NrpError as error:
        return f"refused: {str(error)[:80]}"
    near = [name for name, goal in goals.items() if abs(ends[name] - goal) <= WITHIN]
    return f"{len(near)} of {len(goals)}"


def goals_of(model: Model) -> Iterator[tuple[str, float]]:
    """Yield where each joint is to go."""
    starts = start_positions(model)
    for joint in commandable(model):
        start, step = starts.get(joint.name, 0.0), SLIDE if joint.kind == "prismatic" else STEP
        up, down = min(step, joint.upper - start), min(step, start - joint.lower)
        yield joint.name, start + up if up >= down else start - down


if __name__ == "__main__":
    main()
