"""NeuroMechFly of flygym 1.2.1 in the MuJoCo world: what is kept, how it stands and walks, and the cost.

flygym lets the fly walk on the tripod gait of its own examples and exports it; the file is read here as any
robot, gets the same commands at the same times, and its joint angles are compared. MuJoCo alone runs the
file as well, in the version that is installed here: flygym has an older one, and contacts make small
differences grow. flygym runs with the interpreter that is given.

    python -m venv flygym && flygym/bin/pip install flygym==1.2.1
    python benchmarks/neuromechfly.py flygym/bin/python
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

from nrp_core import World, worlds
from nrp_core.world.messages.std_msgs import Float64
from nrp_core.world.scene.sdf import read_scene

PEER = Path(__file__).parent / "peers" / "neuromechfly_flygym.py"
COMMAND_NS, STEP = 1_000_000, "0.1 ms"
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
        self.free = next(name for name in places if name.endswith("/"))
        self.start = {name: float(self.positions[0, at]) for name, at in places.items() if name != self.free}
        self.joints = [
            name if name in places else f"{self.free}{name}" for name in map(str, kept["commanded"])
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
    world.set_joints(walk.free, walk.start)
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
    places = [int(model.jnt_qposadr[model.joint(f"{walk.free}/{name}").id]) for name in walk.joints]
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
    data.qpos[:7] = walk.positions[0, :7]
    for name, angle in walk.start.items():
        data.joint(name).qpos = angle
    data.joint(next(iter(walk.start))).qpos += turned
    driven = {model.joint(model.actuator_trnid[i][0]).name: i for i in range(len(walk.joints))}
    joints = [driven[name] for name in walk.joints]
    feet = [model.actuator(f"{walk.free}{leg}Tarsus5_adhesion").id for leg in walk.legs]
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
    """Yield the lines of the result."""
    ours, theirs, turned = in_world(walk), alone(walk), alone(walk, 1e-6)
    kept = [f"{getattr(ours[0], n)} of {getattr(theirs[0], n)} {what}" for n, what in COUNTS.items()]
    springs = " of ".join(f"{model.jnt_stiffness.sum():.4g}" for model, *_ in (ours, theirs))
    yield f"kept: {', '.join(kept)}; the stiffness of all springs {springs}"
    columns = "angles against flygym and MuJoCo alone, RMS in ranges: median, worst"
    yield f"{'':24}  CPU s/s  walked (mm)  height (mm)  {columns}"
    x, y, height = walk.positions[-1, :3]
    yield f"{'flygym, ' + cost['version']:24}  {cost['flygym']:7.2f}  {np.hypot(x, y):11.2f}  {height:11.3f}"
    yield f"{'its MuJoCo, bare':24}  {cost['mujoco']:7.2f}"
    for name, (_, angles, bodies, spent) in (
        ("MuJoCo world", ours),
        (f"MuJoCo {mujoco.__version__}", theirs),
        ("the same, 1e-6 rad apart", turned),
    ):
        way = f"{np.hypot(*bodies[-1][:2]):11.2f}  {bodies[-1][2]:11.3f}"
        shares = [apart(angles, other) for other in (walk.angles, theirs[1])]
        apart_by = "  ".join(f"{np.median(each):.2%}, {each.max():.2%}" for each in shares)
        yield f"{name:24}  {spent:7.2f}  {way}  {apart_by}"
    yield f"largest difference to MuJoCo alone in 0.1 s: {abs(ours[1] - theirs[1])[:100].max():.1e} rad"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("flygym", metavar="PYTHON", help="interpreter that has flygym 1.2.1")
    parser.add_argument("--seconds", type=float, default=1.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([given.flygym, str(PEER), folder, str(given.seconds)], check=True, capture_output=True)
        cost = json.loads(Path(folder, "cost.json").read_text())
        for line in report(Walk(Path(folder)), cost):
            print(line, flush=True)


if __name__ == "__main__":
    main()
