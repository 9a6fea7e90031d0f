"""NeuroMechFly of flygym 1.2.1 in the MuJoCo world: what is kept, how it stands and walks, and the cost.

flygym lets the fly move and exports it; the file is read here as any robot, gets the same commands at the
same times, and its joint angles are compared. It walks in the tripod gait of flygym's examples, on a floor
and held in the air, and as a real fly whose joint angles come with flygym. MuJoCo alone runs the file as
well, in the version that is installed here. flygym runs with the interpreters that are given: with its own
MuJoCo, 3.2.7, which finds other contacts between a mesh and a plane, and with the one of here.

    python -m venv old && old/bin/pip install flygym==1.2.1
    python -m venv new && new/bin/pip install flygym==1.2.1
    new/bin/pip uninstall -y mujoco && new/bin/pip install --no-deps dm_control==1.0.50 mujoco-core==4.0.1
    python benchmarks/neuromechfly.py old/bin/python new/bin/python
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from conditions import print_conditions

from nrp_core import World, worlds
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.sdf import read_scene

PEER = Path(__file__).parent / "peers" / "neuromechfly_flygym.py"
COMMAND_NS, STEP = 1_000_000, "0.1 ms"
SCENES = {"walk": "on a floor", "recorded": "as a real fly", "held": "held in the air"}
COUNTS = {"njnt": "joints", "nu": "actuators", "npair": "contact pairs"}
Angles = npt.NDArray[np.float64]
"""Angles of the commanded joints, shape ``(n_commands, n_joints)``, rad."""


class Walk:
    """The walk in flygym.

    Args:
        folder: the folder that the peer wrote.
    """

    def __init__(self, folder: Path) -> None:
        kept = np.load(folder / "walk.npz")
        self.file = folder / "fly.xml"
        self.targets, self.grips, self.positions = kept["targets"], kept["grips"], kept["positions"]
        self.legs = [str(leg) for leg in kept["legs"]]
        places = dict(zip(map(str, kept["joints"]), kept["addresses"].tolist(), strict=True))
        self.robot = f"{next(iter(places)).partition('/')[0]}/"
        self.free = self.robot in places
        held = {name: float(self.positions[0, at]) for name, at in places.items()}
        self.start = {name: angle for name, angle in held.items() if not name.endswith("/")}
        self.joints = [
            name if name in places else f"{self.robot}{name}" for name in map(str, kept["commanded"])
        ]
        self.angles: Angles = self.positions[:, [places[name] for name in self.joints]]


def compiled(world: World) -> tuple[Any, Any]:
    """Return MuJoCo's model and state of a world."""
    engine: Any = world.engine
    return engine._model, engine._data


def in_world(walk: Walk) -> tuple[Any, Angles, Angles, float]:
    """Return the model, the joint angles, the positions of the body, and CPU seconds of a simulated one."""
    backend = worlds().load("mujoco")
    options = backend.options.model_validate({"timestep": STEP})
    world = backend.open(read_scene(walk.file), seed=1, options=options)
    world.set_joints(walk.robot, walk.start)
    model, data = compiled(world)
    topics = sorted(world.topics)
    joints = [
        world.advertise(next(one for one in topics if one.endswith(f"/{name.split('/')[-1]}/cmd_pos")))
        for name in walk.joints
    ]
    feet = [
        world.advertise(next(one for one in topics if one.endswith(f"{leg}Tarsus5_adhesion/cmd")))
        for leg in walk.legs
    ]
    places = [int(model.jnt_qposadr[model.joint(f"{walk.robot}/{name}").id]) for name in walk.joints]
    angles, bodies, began = [], [], time.process_time()
    for step, (target, grip) in enumerate(zip(walk.targets, walk.grips, strict=True), 1):
        for publication, value in zip([*joints, *feet], [*target, *grip], strict=True):
            publication.publish(Float64(float(value)))
        angles.append(data.qpos[places])
        bodies.append(data.qpos[:3].copy())
        world.run_until(step * COMMAND_NS)
    spent = (time.process_time() - began) / (len(angles) * COMMAND_NS * 1e-9)
    return model, np.array(angles), np.array(bodies), spent


def alone(walk: Walk, turned: float = 0.0) -> tuple[Any, Angles, Angles, float]:
    """Return the same of MuJoCo without a world; ``turned`` (rad) is added to the angle of one joint."""
    model = mujoco.MjModel.from_xml_path(str(walk.file))
    data = mujoco.MjData(model)
    if walk.free:
        data.qpos[:7] = walk.positions[0, :7]
    for name, angle in walk.start.items():
        data.joint(name).qpos = angle
    data.joint(next(iter(walk.start))).qpos += turned
    driven = {model.joint(model.actuator_trnid[i][0]).name: i for i in range(len(walk.joints))}
    joints = [driven[name] for name in walk.joints]
    feet = [model.actuator(f"{walk.robot}{leg}Tarsus5_adhesion").id for leg in walk.legs]
    places = [int(model.jnt_qposadr[model.joint(name).id]) for name in walk.joints]
    angles, bodies, began = [], [], time.process_time()
    for target, grip in zip(walk.targets, walk.grips, strict=True):
        data.ctrl[joints], data.ctrl[feet] = target, grip
        angles.append(data.qpos[places])
        bodies.append(data.qpos[:3].copy())
        mujoco.mj_step(model, data, 10)
    spent = (time.process_time() - began) / (len(angles) * COMMAND_NS * 1e-9)
    return model, np.array(angles), np.array(bodies), spent


def apart(one: Angles, other: Angles) -> Angles:
    """Return the RMS difference of each joint, in its range in the other walk."""
    shares: Angles = np.sqrt(np.mean((one - other) ** 2, axis=0)) / np.maximum(np.ptp(other, axis=0), 0.05)
    return shares


def report(walk: Walk, cost: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines of the result of one scene."""
    ours, theirs, turned = in_world(walk), alone(walk), alone(walk, 1e-12)
    kept = [f"{getattr(ours[0], n)} of {getattr(theirs[0], n)} {what}" for n, what in COUNTS.items()]
    springs = " of ".join(f"{model.jnt_stiffness.sum():.4g}" for model, *_ in (ours, theirs))
    yield f"kept: {', '.join(kept)}; the stiffness of all springs {springs}"
    columns = "angles against flygym and MuJoCo alone, RMS in ranges: median, worst"
    yield f"{'':24}  CPU s/s  walked (mm)  height (mm)  {columns}"
    yield f"{'flygym, ' + cost['version']:24}  {cost['flygym']:7.2f}  {_way(walk.positions, walk.free)}"
    yield f"{'its MuJoCo, bare':24}  {cost['mujoco']:7.2f}"
    for name, (_, angles, bodies, spent) in (
        ("MuJoCo world", ours),
        (f"MuJoCo {mujoco.__version__}", theirs),
        ("the same, 1e-12 rad apart", turned),
    ):
        shares = [apart(angles, other) for other in (walk.angles, theirs[1])]
        apart_by = "  ".join(f"{np.median(each):.2%}, {each.max():.2%}" for each in shares)
        yield f"{name:24}  {spent:7.2f}  {_way(bodies, walk.free)}  {apart_by}"
    yield f"largest difference to MuJoCo alone in 0.5 s: {abs(ours[1] - theirs[1])[:500].max():.1e} rad"


def _way(positions: Angles, free: bool) -> str:
    """Return how far a body came, and its height at the end."""
    x, y, height = positions[-1, :3] if free else (0.0, 0.0, 0.0)
    return f"{np.hypot(x, y):11.2f}  {height:11.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("flygym", metavar="PYTHON", nargs="+", help="interpreter that has flygym 1.2.1")
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=[*SCENES])
    given = parser.parse_args()
    print_conditions()
    for interpreter in given.flygym:
        for scene in given.scenes:
            with tempfile.TemporaryDirectory() as folder:
                peer = [interpreter, str(PEER), folder, str(given.seconds), scene]
                subprocess.run(peer, check=True, capture_output=True)
                cost = json.loads(Path(folder, "cost.json").read_text())
                print(f"{SCENES[scene]}, against flygym with MuJoCo {cost['version']}")
                for line in report(Walk(Path(folder)), cost):
                    print(f"  {line}", flush=True)


if __name__ == "__main__":
    main()
