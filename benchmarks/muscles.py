"""What 80 muscles cost in a world and in MuJoCo alone, in CPU seconds per simulated second.

Every 10 ms one message commands all muscles of the group, and one message with their states is read. MuJoCo
alone gets the same controls and the same physics step. The two take turns. The body is made here; a file in
MJCF is measured in its place:

    python benchmarks/muscles.py [FILE]
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np
from conditions import print_conditions

from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_model
from nrp_core.world.backends import worlds

LIMBS, SEGMENTS, PER_SEGMENT = 5, 4, 4
STEP_NS, PHYSICS_NS, STEPS, REPEATS = 10_000_000, 2_000_000, 100, 3


def main() -> None:
    """Print a table of one row."""
    print_conditions()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(folder) / "limbs.xml"
        if len(sys.argv) == 1:
            path.write_text(body(), encoding="utf-8")
        world, alone, count = [], [], 0
        for _ in range(REPEATS):
            spent, count = in_a_world(path)
            world.append(spent)
            alone.append(in_mujoco_alone(path, count))
    ratio = statistics.median(a / b for a, b in zip(world, alone, strict=True))
    print("| body | muscles | world | MuJoCo alone | ratio |\n|---|---|---|---|---|")
    print(f"| {path.stem} | {count} | {min(world):.4f} | {min(alone):.4f} | {ratio:.2f} |")


def body() -> str:
    """Return a trunk with limbs of hinged segments, each of which several muscles move."""
    sites: dict[str, list[str]] = {"trunk": []}
    tendons, muscles, limbs = [], [], []
    for limb in range(LIMBS):
        before = "trunk"
        for segment in range(SEGMENTS):
            name = f"limb{limb}_{segment}"
            sites[name] = []
            for number in range(PER_SEGMENT):
                muscle, side = f"{name}_{number}", 0.03 * (-1) ** number
                first = f"{0.1 * limb} {side} {0.02 * number}" if segment == 0 else f"0 {side} -0.05"
                sites[before].append(f'<site name="{muscle}_a" pos="{first}"/>')
                sites[name].append(f'<site name="{muscle}_b" pos="0 {side} {-0.06 - 0.01 * number}"/>')
                tendons.append(
                    f'<spatial name="{muscle}"><site site="{muscle}_a"/><site site="{muscle}_b"/></spatial>'
                )
                muscles.append(
                    f'<muscle name="{muscle}" tendon="{muscle}" force="60" lengthrange="0.03 0.2"/>'
                )
            before = name
    for limb in range(LIMBS):
        chain = ends = ""
        for segment in range(SEGMENTS):
            name = f"limb{limb}_{segment}"
            place = f"{0.1 * limb} 0 0" if segment == 0 else "0 0 -0.15"
            chain += (
                f'<body name="{name}" pos="{place}">'
                f'<joint name="{name}" axis="1 0 0" range="-60 60" damping="0.2"/>'
                '<geom type="capsule" size="0.015" fromto="0 0 -0.02 0 0 -0.13" '
                'contype="0" conaffinity="0"/>' + "".join(sites[name])
            )
            ends += "</body>"
        limbs.append(chain + ends)
    return (
        '<mujoco model="limbs"><worldbody><body name="trunk" pos="0 0 1">'
        '<geom type="box" size="0.3 0.05 0.05" contype="0" conaffinity="0"/>'
        f"{''.join(sites['trunk'])}{''.join(limbs)}</body></worldbody>"
        f"<tendon>{''.join(tendons)}</tendon><actuator>{''.join(muscles)}</actuator></mujoco>"
    )


def controls(step: int, count: int) -> np.ndarray:
    """Return the controls of all muscles in a step."""
    values: np.ndarray = 0.3 + 0.2 * np.sin(0.1 * step + np.arange(count))
    return values


def in_a_world(path: Path) -> tuple[float, int]:
    """Return the CPU time in a world, and the number of muscles."""
    model = read_model(path)
    backend = worlds().load("mujoco")
    with backend.open(Scene((model,)), seed=1, options=backend.options()) as world:
        state = world.subscribe(f"/{model.name}/muscles/state")
        command = world.advertise(f"/{model.name}/muscles/cmd")
        world.run_until(STEP_NS)
        assert state.latest is not None
        count = len(state.latest.message.name)
        began = time.process_time()
        for step in range(STEPS):
            command.publish(Float64MultiArray(data=controls(step, count)))
            world.run_until((step + 2) * STEP_NS)
            _ = state.latest.message.length
        return (time.process_time() - began) / (STEPS * STEP_NS * 1e-9), count


def in_mujoco_alone(path: Path, count: int) -> float:
    """Return the CPU time of the same without a world."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.timestep, model.opt.integrator = PHYSICS_NS * 1e-9, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    began = time.process_time()
    for step in range(STEPS):
        data.ctrl[:count] = controls(step, count)
        mujoco.mj_step(model, data, STEP_NS // PHYSICS_NS)
        _ = data.ten_length.copy()
    return (time.process_time() - began) / (STEPS * STEP_NS * 1e-9)


if __name__ == "__main__":
    main()
