"""Random models of MJCF over several files move, and measure, as in MuJoCo alone."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from nrp_world_mujoco.schema import attributes_of
from random_mjcf import COMPILER, RandomModel

from nrp_core import World, worlds
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.sdf import read_scene

STEP_NS, STEPS = 2_000_000, 50
KINDS = mujoco.mjtJoint
RELATIVE = ("JOINTPOS", "TENDONPOS", "ACTUATORPOS")
"""Sensors of positions, which begin at 0 in a scene and at ``ref`` in MJCF."""


def opened(path: Path) -> World:
    backend = worlds().load("mujoco")
    options = backend.options.model_validate({"timestep": f"{STEP_NS} ns"})
    return backend.open(read_scene(path), seed=1, options=options)


def paired(ours: Any, theirs: Any) -> list[tuple[slice, slice, float]]:
    """Return the coordinates of each joint in MuJoCo alone, in the scene, and where the former begin."""
    known = {}
    for number in range(ours.njnt):
        joint = ours.joint(number)
        body, _, name = joint.name.partition("/")
        known[body if name.endswith("/free") else name] = joint
    pairs = []
    for number in range(theirs.njnt):
        joint, kind = theirs.joint(number), KINDS(theirs.jnt_type[number])
        size = {KINDS.mjJNT_FREE: 7, KINDS.mjJNT_BALL: 4}.get(kind, 1)
        here = known[theirs.body(joint.bodyid[0]).name if kind == KINDS.mjJNT_FREE else joint.name]
        at, to = int(joint.qposadr[0]), int(here.qposadr[0])
        pairs.append((slice(at, at + size), slice(to, to + size), theirs.qpos0[at] if size == 1 else 0.0))
    return pairs


def measured(model: Any, data: Any) -> dict[str, Any]:
    """Return what each sensor measures, and how positions have changed."""
    start = mujoco.MjData(model)
    for each in (start, data):
        mujoco.mj_forward(model, each)
    found = {}
    for number in range(model.nsensor):
        name = model.sensor(number).name
        relative = mujoco.mjtSensor(model.sensor_type[number]).name.removeprefix("mjSENS_") in RELATIVE
        zero = start.sensor(name).data if relative else 0.0
        found[name.removesuffix("/sensor").rpartition("/")[2]] = data.sensor(name).data - zero
    return found


def difference(model: RandomModel, theirs: Any, path: Path) -> tuple[float, set[str]]:
    """Return the largest difference of a joint, and the sensors that differ."""
    with opened(path) as world:
        ours, here, there = world.engine._model, world.engine._data, mujoco.MjData(theirs)
        theirs.opt.timestep = ours.opt.timestep
        for name, value in model.controls.items():
            for topic in (topic for topic in world.topics if topic.endswith(f"/{name}/cmd")):
                there.actuator(name).ctrl = value
                world.advertise(topic).publish(Float64(value))
        worst = 0.0
        for step in range(1, STEPS + 1):
            mujoco.mj_step(theirs, there)
            world.run_until(step * STEP_NS)
            for at, to, zero in paired(ours, theirs):
                worst = max(worst, float(np.abs(there.qpos[at] - zero - here.qpos[to]).max()))
        values = measured(ours, here)
        wrong = {
            name
            for name, wanted in measured(theirs, there).items()
            if name in values and not np.allclose(values[name], wanted, rtol=1e-7, atol=1e-7)
        }
        return worst, wrong


def sensitivity(model: RandomModel, path: Path) -> float:
    """Return by how much joints of MuJoCo alone differ if the ground and the first speed change by 1e-7.

    The depth of a contact jumps where another direction becomes the shortest one out of it.
    """
    ends = []
    for offset in (0.0, 1e-7, -1e-7):
        alone = mujoco.MjModel.from_xml_path(str(path))
        alone.opt.timestep = STEP_NS * 1e-9
        alone.hfield_data[:] += offset
        data = mujoco.MjData(alone)
        data.qvel[:] += offset
        for name, value in model.controls.items():
            data.actuator(name).ctrl = value
        trajectory = []
        for _ in range(STEPS):
            mujoco.mj_step(alone, data)
            trajectory.append(data.qpos.copy())
        ends.append(np.array(trajectory))
    return max(float(np.abs(end - ends[0]).max()) for end in ends[1:])


def faults(seeds: Iterable[int], folder: Path) -> dict[int, tuple[float, set[str]]]:
    """Return the seeds whose models differ; MuJoCo refuses some models."""
    wrong, valid = {}, 0
    for seed in seeds:
        touching = seed % 3 == 0
        model = RandomModel(seed, joined=bool(seed % 2), touching=touching)
        path = model.save(folder)
        try:
            theirs = mujoco.MjModel.from_xml_path(str(path))
        except ValueError:
            continue
        worst, sensors = difference(model, theirs, path)
        jump = sensitivity(model, path) if touching and (sensors or worst > 1e-9) else 0.0
        valid += jump < 1e-7
        if not worst <= max(1e-9, 10 * jump) or (sensors and jump < 1e-8):
            wrong[seed] = worst, sensors
    assert valid > len(list(seeds)) / 2
    return wrong


def test_random_models_over_several_files_act_as_in_mujoco_alone(tmp_path):
    assert not faults([*range(12), 292], tmp_path)  # 292: fixed bodies with a mass and without inertia


@pytest.mark.heavy
def test_many_random_models_act_as_in_mujoco_alone(tmp_path):
    assert not faults(range(12, 330), tmp_path)


def test_every_attribute_of_the_compiler_is_drawn_or_of_another_subject():
    assert {*COMPILER} == {*attributes_of("compiler")}
