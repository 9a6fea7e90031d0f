"""Random trees of bodies that muscles move in PyBullet as in MuJoCo alone: the reference reads the same file.

Each has motors' inertia, limits, couplings and dry friction with random properties of MuJoCo's constraints.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.sdf import read_scene
from nrp_core.world.backends import worlds

_STEPS = 5
"""Steps for which a command holds."""
_SIZES = (0.01, 1.0, 0.5, 0.5, 0.5)
"""The coefficients of couplings are about so large."""


def numbers(values: Any) -> str:
    return " ".join(f"{value:.6g}" for value in np.atleast_1d(values))


class RandomTree:
    """A random tree of up to nine bodies as MJCF.

    Args:
        seed: of its random numbers.
        root: the joint of its base as MJCF; empty if the base is fixed.
        driven: whether most joints also have a servo or a motor.
    """

    def __init__(self, seed: int, root: str = "", *, driven: bool = False) -> None:
        self._rng = rng = np.random.default_rng(seed)
        self.parents = [
            -1,
            *(int(rng.integers(max(0, n - 2), n + 1)) - 1 for n in range(1, rng.integers(3, 10))),
        ]
        self.joints: list[str] = []
        bodies = "".join(self._body(n) for n, parent in enumerate(self.parents) if parent < 0)
        pairs = [rng.choice(len(self.parents), 2, replace=False) for _ in range(2 * len(self.parents))]
        tendons = "".join(
            f'<spatial name="t{k}"><site site="s{a}"/><site site="v{a}"/><site site="s{b}"/></spatial>'
            for k, (a, b) in enumerate(pairs)
        )
        muscles = "".join(
            f'<muscle name="m{k}" tendon="t{k}" lengthrange="0.05 0.4" force="{numbers(force)}"/>'
            for k, force in enumerate(rng.uniform(5, 60, len(pairs)))
        )
        self.text = (
            '<mujoco><option integrator="implicitfast" tolerance="1e-14" iterations="500"/><worldbody>'
            f'<body name="base" pos="0 0 1" euler="{40 * (seed % 2)} 20 0">{root}'
            f'<inertial mass="1" pos="0 0 0" diaginertia=".01 .02 .015"/>{bodies}'
            f"</body></worldbody><tendon>{tendons}</tendon>"
            f"<equality>{self._couplings()}</equality>"
            f"<actuator>{muscles}{self._drives() if driven else ''}</actuator></mujoco>"
        )

    def _drives(self) -> str:
        rng = self._rng
        found = ""
        for joint in self.joints:
            kp, kv = rng.uniform(0.5, 20.0), rng.choice([0.0, 0.02, 0.3])
            kinds = f'position kp="{numbers(kp)}" kv="{numbers(kv)}"', f'velocity kv="{numbers(0.02 * kp)}"'
            kind = rng.choice(["", "motor", *kinds, *kinds])
            limit = rng.choice(["", 'forcerange="-0.5 0.5"'])
            gear = numbers(rng.choice([1.0, -2.0]))
            found += kind and f'<{kind} name="d{joint}" joint="{joint}" gear="{gear}" {limit}/>'
        return found

    def _yielding(self, suffix: str) -> str:
        rng = self._rng
        direct = rng.random() < 0.3
        solref = (
            (-rng.uniform(500, 4000), -rng.uniform(10, 60)) if direct else (rng.uniform(0.003, 0.05), 1.0)
        )
        solimp = (
            rng.uniform(0.3, 0.9),
            rng.uniform(0.9, 0.97),
            10 ** rng.uniform(-3, -1),
            0.4,
            rng.integers(1, 4),
        )
        return f'solref{suffix}="{numbers(solref)}" solimp{suffix}="{numbers(solimp)}"'

    def _body(self, n: int) -> str:
        rng = self._rng
        axis, turn = rng.normal(size=3), rng.normal(size=4)
        slides = rng.random() < 0.2
        low, high = -rng.uniform(0.02, 0.3), rng.uniform(0.02, 0.3)
        low, high = (0.1 * low, 0.1 * high) if slides else (low, high)
        joint = f'<joint name="j{n}" type="{"slide" if slides else "hinge"}" axis="{numbers(axis)}"'
        joint += f' damping="{numbers(rng.choice([0.0, 0.02, 0.2]))}"'
        joint += f' armature="{numbers(rng.choice([0, 1e-3, 0.02]))}"'
        if rng.random() < 0.6:
            joint += (
                f' limited="true" range="{numbers((low, high))}" margin="{numbers(rng.choice([0.0, 0.01]))}" '
            )
            joint += self._yielding("limit")
        if rng.random() < 0.3:
            joint += f' frictionloss="{numbers(rng.uniform(0.02, 0.5))}" ' + self._yielding("friction")
        self.joints.append(f"j{n}")
        mass, moments = rng.uniform(0.05, 1.0), rng.uniform(0.5, 0.9, 3) * 1e-3
        inertial = f'<inertial mass="{numbers(mass)}" pos="{numbers(rng.normal(size=3, scale=0.03))}"'
        inertial += f' quat="{numbers(turn)}" diaginertia="{numbers(moments)}"/>'
        sites = "".join(
            f'<site name="{name}{n}" pos="{numbers(rng.normal(size=3, scale=0.04))}"/>' for name in "sv"
        )
        below = "".join(self._body(k) for k, parent in enumerate(self.parents) if parent == n)
        place = numbers(rng.normal(size=3, scale=0.1))
        body = f'<body name="b{n}" pos="{place}" quat="{numbers(rng.normal(size=4))}">'
        return f"{body}{inertial}{joint}/>{sites}{below}</body>"

    def _couplings(self) -> str:
        rng = self._rng
        order = rng.permutation(self.joints).tolist()
        found = [
            f'<joint joint1="{one}" joint2="{other}" polycoef="{numbers(rng.normal(size=5) * _SIZES)}" '
            f"{self._yielding('')}/>"
            for one, other in zip(order[:2], order[2:], strict=False)
        ]
        kept = f'<joint joint1="{order[-1]}" polycoef="0.02" {self._yielding("")}/>'
        return "".join([*found, kept] if rng.random() < 0.3 else found)


def drive_of(model: mujoco.MjModel, number: int) -> tuple[str, str, float]:
    """Return joint, topic and the command for each unit of control of an actuator."""
    joint, gear = model.joint(model.actuator_trnid[number, 0]).name, float(model.actuator_gear[number, 0])
    spring, brake = model.actuator_biasprm[number, 1:3]
    if spring:
        return joint, "cmd_pos", 1.0 / gear
    return (joint, "cmd_vel", 1.0 / gear) if brake else (joint, "cmd_effort", gear)


def largest_difference(tree: RandomTree, file: Path, seed: int, seconds: float) -> float:
    """Return by how much the joints of a tree in PyBullet differ from MuJoCo alone at most, rad or m."""
    file.write_text(tree.text)
    model = mujoco.MjModel.from_xml_path(str(file))
    data, backend, worst = mujoco.MjData(model), worlds().load("pybullet"), 0.0
    with backend.open(read_scene(file), seed=1, options=backend.options()) as world:
        assert not [each for each in world.warnings if each.subject in ("armature", "joint")]
        muscles = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON
        command = world.advertise("/base/muscles/cmd")
        names = world.joint_states("base").names
        single = [model.joint(n) for n in range(model.njnt) if model.jnt_type[n] > 1]
        ours = [names.index(joint.name) for joint in single]
        theirs = [joint.qposadr[0] for joint in single]
        drives = [(n, *drive_of(model, n)) for n in np.flatnonzero(~muscles)]
        topics = [world.advertise(f"/base/{joint}/{topic}") for _, joint, topic, _ in drives]
        rows = np.random.default_rng(seed).uniform(0.0, 1.0, (round(seconds / 0.01), model.nu))
        for k, row in enumerate(rows):
            data.ctrl[:] = row
            mujoco.mj_step(model, data, _STEPS)
            command.publish(Float64MultiArray(data=row[muscles]))
            for topic, (n, *_, scale) in zip(topics, drives, strict=True):
                topic.publish(Float64(scale * row[n]))
            world.run_until((k + 1) * 10_000_000)
            mujoco.mj_kinematics(model, data)
            found = [*world.joint_states("base").positions[ours], *world.model_motion("base").pose.position]
            alone = [*data.qpos[theirs], *data.body("base").xpos]
            worst = max(worst, float(np.abs(np.subtract(found, alone)).max()))
    assert np.abs(data.qpos[theirs]).max() > 1e-3
    return worst


@pytest.mark.one_of(50)
@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("root", ["", "<freejoint/>", '<joint type="ball" damping="0.1"/>'])
def test_random_trees_move_as_in_mujoco_alone(root: str, seed: int, tmp_path: Path) -> None:
    assert largest_difference(RandomTree(seed, root), tmp_path / "tree.xml", seed, 0.5) < 1e-9


@pytest.mark.one_of(25)
@pytest.mark.parametrize("seed", range(60))
@pytest.mark.parametrize("root", ["", "<freejoint/>"])
def test_random_trees_with_servos_and_muscles_move_as_in_mujoco_alone(root, seed, tmp_path):
    """Stiffness as in the file, without the damping that a servo of another format has here."""
    tree = RandomTree(seed, root, driven=True)
    assert largest_difference(tree, tmp_path / "tree.xml", seed, 0.5) < 1e-9
