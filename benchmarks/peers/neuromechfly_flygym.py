"""Let NeuroMechFly move in flygym, and keep its MJCF, commands, joint angles and cost (see neuromechfly.py).

python neuromechfly_flygym.py FOLDER SECONDS SCENE, with a scene of neuromechfly.py
"""

from __future__ import annotations

import json
import pickle
import runpy
import sys
import time
from pathlib import Path
from typing import Any

import flygym  # type: ignore[import-not-found]
import mujoco
import numpy as np
from dm_control import mjcf  # type: ignore[import-not-found]
from dm_control.mujoco.wrapper.mjbindings import sizes  # type: ignore[import-not-found]
from flygym.arena import FlatTerrain, Tethered  # type: ignore[import-not-found]

STEP_S, HELD, STRIDES_HZ, BEGIN_S = 1e-4, 10, 12.0, 0.2
"""Physics step (s), number of steps with one command, steps of a leg in a second, time to the full stride."""
TRIPODS = (0.0, np.pi, 0.0, np.pi, 0.0, np.pi)
PACKAGE = Path(flygym.__file__).parent


def bear_with_another_mujoco() -> None:
    """Take from dm_control's list of fields those that MuJoCo does not have any more."""
    for kind, structure in (("mjmodel", mujoco.MjModel), ("mjdata", mujoco.MjData)):
        fields = sizes.array_sizes[kind]
        for name in [name for name in fields if not hasattr(structure, name)]:
            del fields[name]


def walking(gait: Any, times_s: np.ndarray) -> tuple[list[np.ndarray], list[list[float]]]:
    """Return the targets of the joints in flygym's tripod gait, and whether each foot sticks."""
    targets, grips = [], []
    for t in times_s:
        phases = dict(zip(gait.legs, 2 * np.pi * STRIDES_HZ * t + np.array(TRIPODS), strict=True))
        stride = min(1.0, t / BEGIN_S)
        targets.append(np.concatenate([gait.get_joint_angles(leg, phases[leg], stride) for leg in gait.legs]))
        grips.append([float(gait.get_adhesion_onoff(leg, phases[leg])) for leg in gait.legs])
    return targets, grips


def recorded(fly: Any, times_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the targets of the joints in the walk of a real fly that comes with flygym; no foot sticks."""
    kept = pickle.loads((PACKAGE / "data/behavior/210902_pr_fly1.pkl").read_bytes())
    every_s = kept["meta"]["timestep"]
    angles = [
        np.interp(times_s, np.arange(len(kept[name])) * every_s, kept[name]) for name in fly.actuated_joints
    ]
    return np.transpose(angles), np.zeros((len(times_s), 6))


def main(folder: Path, seconds: float, scene: str) -> None:
    """Move, and write ``fly.xml`` with its meshes, ``walk.npz`` and ``cost.json``."""
    bear_with_another_mujoco()
    gait = runpy.run_path(str(PACKAGE / "examples/locomotion/steps.py"))["PreprogrammedSteps"]()
    fly = flygym.Fly(enable_adhesion=True, draw_adhesion=False, spawn_pos=(0, 0, 0.5), control="position")
    arena = Tethered() if scene == "held" else FlatTerrain()
    simulation = flygym.SingleFlySimulation(fly=fly, cameras=[], timestep=STEP_S, arena=arena)
    simulation.arena.root_element.option.cone = "pyramidal"  # which MuJoCo takes if a file has none
    mjcf.export_with_assets(simulation.arena.root_element, str(folder), out_file_name="fly.xml")
    simulation.reset()
    model, data = simulation.physics.model.ptr, simulation.physics.data.ptr
    times_s = np.arange(round(seconds / STEP_S / HELD)) * STEP_S * HELD
    targets, grips = recorded(fly, times_s) if scene == "recorded" else walking(gait, times_s)
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
    main(Path(sys.argv[1]), float(sys.argv[2]), sys.argv[3])
