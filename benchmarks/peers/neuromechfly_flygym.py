"""Let NeuroMechFly walk in flygym, and keep its MJCF, commands, joint angles and cost (see neuromechfly.py).

python neuromechfly_flygym.py FOLDER SECONDS
"""

from __future__ import annotations

import json
import runpy
import sys
import time
from pathlib import Path

import flygym  # type: ignore[import-not-found]
import mujoco
import numpy as np
from dm_control import mjcf  # type: ignore[import-not-found]

STEP_S, HELD, STRIDES_HZ, BEGIN_S = 1e-4, 10, 12.0, 0.2
"""Physics step (s), number of steps with one command, steps of a leg in a second, time to the full stride."""
TRIPODS = (0.0, np.pi, 0.0, np.pi, 0.0, np.pi)


def main(folder: Path, seconds: float) -> None:
    """Walk, and write ``fly.xml`` with its meshes, ``walk.npz`` and ``cost.json``."""
    steps_file = Path(flygym.__file__).parent / "examples/locomotion/steps.py"
    gait = runpy.run_path(str(steps_file))["PreprogrammedSteps"]()
    fly = flygym.Fly(enable_adhesion=True, draw_adhesion=False, spawn_pos=(0, 0, 0.5), control="position")
    simulation = flygym.SingleFlySimulation(fly=fly, cameras=[], timestep=STEP_S)
    simulation.arena.root_element.option.cone = "pyramidal"  # which MuJoCo takes if a file has none
    mjcf.export_with_assets(simulation.arena.root_element, str(folder), out_file_name="fly.xml")
    simulation.reset()
    model, data = simulation.physics.model.ptr, simulation.physics.data.ptr
    times_s = np.arange(round(seconds / STEP_S / HELD)) * STEP_S * HELD
    targets, grips = [], []
    for t in times_s:
        phases = dict(zip(gait.legs, 2 * np.pi * STRIDES_HZ * t + np.array(TRIPODS), strict=True))
        stride = min(1.0, t / BEGIN_S)
        targets.append(np.concatenate([gait.get_joint_angles(leg, phases[leg], stride) for leg in gait.legs]))
        grips.append([float(gait.get_adhesion_onoff(leg, phases[leg])) for leg in gait.legs])
    positions, spent_s, bare_s = [], 0.0, 0.0
    for target, grip in zip(targets, grips, strict=True):
        positions.append(np.array(data.qpos))
        began = time.process_time()
        for _ in range(HELD):
            simulation.step({"joints": target, "adhesion": np.array(grip)})
        spent_s += time.process_time() - began
    simulation.reset()
    for target, grip in zip(targets, grips, strict=True):
        simulation.physics.bind(fly.actuators).ctrl = target
        simulation.physics.bind(fly.adhesion_actuators).ctrl = grip
        began = time.process_time()
        mujoco.mj_step(model, data, HELD)
        bare_s += time.process_time() - began
    joints = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, i) for i in range(model.njnt)]
    np.savez(
        folder / "walk.npz", targets=targets, grips=grips, positions=positions, joints=joints,
        addresses=np.array(model.jnt_qposadr), commanded=list(fly.actuated_joints), legs=gait.legs,
    )  # fmt: skip
    cost = {"flygym": spent_s / seconds, "mujoco": bare_s / seconds, "version": mujoco.__version__}
    (folder / "cost.json").write_text(json.dumps(cost))


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]))
