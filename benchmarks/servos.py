"""What a 20 ms step costs in which every joint of a robot gets a command, beside raw loops of its engine.

Give it URDF files; without any it takes a quadruped and an arm of ``pybullet_data``:

    python benchmarks/servos.py [--steps N] [--rounds N] [--each] [FILE ...]

Each robot is held by its base. Four loops take turns on the same bodies: without any servo (the joints
hang); with the engine's own servo (actuators in MuJoCo, motors in PyBullet); with the servo of the world,
without the world; and the world. In each of them every joint gets a new target in each step, in the world by
one message for all (``--each``: by a message for each), and the states of all joints are read once. Two more
loops tell the least that a servo of PyBullet takes: motors that hold their first targets, without any call
but those of steps; and the calls of a servo by efforts in each physics step, without its law. It prints CPU
time of each step, best of the rounds; all rounds are printed with ``--raw``.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from importlib.util import find_spec
from math import sin
from pathlib import Path
from statistics import fmean

import numpy as np
from conditions import conditions
from world_step import STEP_NS, SUBSTEP_NS, SUBSTEPS, Step, best, measure

from nrp_core.messages.std_msgs import Float64, Float64MultiArray
from nrp_core.scene.devices import GroupController
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.posture import start_positions
from nrp_core.scene.rigid import JointTargets, Pose, ServoTarget
from nrp_core.scene.sdf import read_model
from nrp_core.world.backends import worlds
from nrp_core.world.engine_kit.firm_joints import FirmJoints, firm_joints
from nrp_core.world.robot_setup import JointControl, RobotSetup, commandable, set_up_robot

KP, KV = 200.0, 10.0
SWING = 0.05  # rad
SHIPPED = ("a1/a1.urdf", "kuka_iiwa/model.urdf")


def held(path: Path) -> Model:
    """Return a robot that is held by its base, with a position servo for every joint."""
    model = read_model(path, name="robot")
    bare = replace(model, drives=(), controllers=(), trajectory_controllers=(), pair_controllers=())
    fitting = RobotSetup(True, control=((".*", JointControl("position")),))
    return replace(set_up_robot(bare, fitting), pose=Pose((0.0, 0.0, 3.0)))


def grouped(model: Model) -> Model:
    """Return a robot whose joints take one message."""
    joints = tuple(each.joint for each in model.controllers)
    group = GroupController("all", joints, "position", "/robot/all")
    return replace(model, group_controllers=(group,))


def targets(model: Model) -> Callable[[int], list[float]]:
    """Return the targets of all joints by step: sines about their starts, within their limits."""
    starts, joints = start_positions(model), commandable(model)
    rest = [
        min(max(starts.get(joint.name, 0.0), joint.lower + SWING), joint.upper - SWING) for joint in joints
    ]
    return lambda k: [start + SWING * sin(0.1 * k + number) for number, start in enumerate(rest)]


@contextmanager
def world_loop(model: Model, engine: str, each: bool) -> Iterator[Step]:
    backend, goals = worlds().load(engine), targets(model)
    topics = {each.joint: each.topic for each in model.controllers}
    with backend.open(Scene((grouped(model),)), seed=1, options=backend.options()) as world:
        commands = [world.advertise(topics[joint.name]) for joint in commandable(model)]
        group = world.advertise("/robot/all")

        def step(k: int) -> None:
            if each:
                for command, goal in zip(commands, goals(k), strict=True):
                    command.publish(Float64(goal))
            else:
                group.publish(Float64MultiArray(data=np.array(goals(k))))
            world.run_until(world.now_ns + STEP_NS)
            world.joint_states(model.name)

        yield step


def led(firm: FirmJoints, model: Model, goals: Sequence[float]) -> tuple[str, ...]:
    """Give each joint its first target; return the names of the joints."""
    names = tuple(joint.name for joint in commandable(model))
    for name, goal in zip(names, goals, strict=True):
        firm.set_target((model.name, name), ServoTarget(stiffness=1.0, position=goal, firm=True))
    return names


@contextmanager
def raw_mujoco(model: Model, servo: str) -> Iterator[Step]:
    from nrp_world_mujoco.build import build
    from nrp_world_mujoco.control import MujocoFirmJoints
    from nrp_world_mujoco.library import mujoco

    scene, goals = Scene((model,)), targets(model)
    built = build(scene, timestep_ns=SUBSTEP_NS)
    m, joints = built.model, commandable(model)
    data, ids = mujoco.MjData(m), [built.servos[model.name, joint.name] for joint in joints]
    places = m.jnt_qposadr[m.dof_jntid[[built.joints[model.name][joint.name] for joint in joints]]]
    starts = start_positions(model)
    data.qpos[places] = [starts.get(joint.name, 0.0) for joint in joints]
    if servo == "own":
        m.actuator_biasprm[ids, 1:3] = -KP, -KV
    firm = MujocoFirmJoints(built, data, SUBSTEP_NS / 1e9)
    names = led(firm, model, goals(0)) if servo == "same" else ()
    mujoco.mj_forward(m, data)

    def step(k: int) -> None:
        if servo == "own":
            data.ctrl[ids] = [KP * goal for goal in goals(k)]
        if servo == "same":
            firm.retarget(model.name, JointTargets(names, goals(k), (), smooth=True))
            firm.step(SUBSTEPS)
        else:
            mujoco.mj_step(m, data, SUBSTEPS)
        data.qpos[places].tolist()

    yield step


@contextmanager
def raw_pybullet(model: Model, servo: str) -> Iterator[Step]:
    from nrp_world_pybullet.build import build
    from nrp_world_pybullet.firm import BulletFirmJoints
    from nrp_world_pybullet.library import bullet
    from nrp_world_pybullet.motion import JointReader

    client = bullet.connect(bullet.DIRECT)
    goals = targets(model)
    built = build(Scene((model,)), timestep_ns=SUBSTEP_NS, client=client)
    places = [built.joints[model.name][joint.name] for joint in commandable(model)]
    body, links = places[0].multibody, [place.link for place in places]
    starts, mode = start_positions(model), bullet.POSITION_CONTROL
    for joint, link in zip(commandable(model), links, strict=True):
        bullet.resetJointState(body, link, starts.get(joint.name, 0.0), 0.0, client)

    bodies = [each for each, _ in built.bodies[model.name]]
    found = firm_joints(model, bodies)
    own = {(model.name, each.name): place for each, place in zip(commandable(model), places, strict=True)}
    firm = BulletFirmJoints(
        {path: (found[path[1]], place) for path, place in own.items()},
        JointReader(built.joints[model.name], (), client),
        client,
        SUBSTEP_NS / 1e9,
    )
    names = led(firm, model, goals(0)) if servo == "same" else ()
    for link in links if servo == "same" else ():  # firm joints have no dampers
        bullet.changeDynamics(body, link, jointDamping=0.0, physicsClientId=client)

    rest = [0.0] * len(links)
    if servo == "held":
        bullet.setJointMotorControlArray(body, links, mode, targetPositions=goals(0), physicsClientId=client)

    def step(k: int) -> None:
        if servo == "own":
            bullet.setJointMotorControlArray(
                body, links, mode, targetPositions=goals(k), physicsClientId=client
            )
        if servo == "same":
            firm.retarget(model.name, JointTargets(names, goals(k), (), smooth=True))
        for _ in range(SUBSTEPS):
            if servo == "same":
                firm.step()
            if servo == "efforts":
                bullet.getJointStates(body, links, client)
                bullet.setJointMotorControlArray(
                    body, links, bullet.TORQUE_CONTROL, forces=rest, physicsClientId=client
                )
            bullet.stepSimulation(client)
        bullet.getJointStates(body, links, client)

    yield step
    bullet.disconnect(client)


RAW = {"mujoco": raw_mujoco, "pybullet": raw_pybullet}
SERVOS = ("none", "own", "same")
LEAST = {"mujoco": (), "pybullet": ("held", "efforts")}


def measured(model: Model, engine: str, steps: int, rounds: int, each: bool) -> list[list[list[float]]]:
    """Return CPU microseconds by loop (raw ones, then the world), round and step."""
    with ExitStack() as stack:
        loops = [stack.enter_context(RAW[engine](model, servo)) for servo in (*SERVOS, *LEAST[engine])]
        loops.append(stack.enter_context(world_loop(model, engine, each)))
        found = [[measure(loop, number * steps, steps) for loop in loops] for number in range(rounds + 1)]
    return [list(each) for each in zip(*found[1:], strict=True)]  # the first round warms up


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--each", action="store_true", help="a message for each joint")
    parser.add_argument("--raw", action="store_true", help="print the mean step of every round")
    arguments = parser.parse_args()
    spec = find_spec("pybullet_data")
    shipped = [Path(spec.origin).parent / name for name in SHIPPED] if spec and spec.origin else []
    print(conditions())
    print(
        "| robot | joints | engine | no servo, us | its own | same | world | of the same | of none "
        "| motors that hold | efforts |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for path in arguments.files or shipped:
        model = held(path)
        for engine in RAW:
            rounds = measured(model, engine, arguments.steps, arguments.rounds, arguments.each)
            none, own, same, *least, world = (best(loop) for loop in rounds)
            print(
                f"| {path.stem if path.stem != 'model' else path.parent.name} | {len(commandable(model))} "
                f"| {engine} | {none:.0f} | {own:.0f} | {same:.0f} | {world:.0f} | {world / same:.2f} "
                f"| {world / none:.2f} | {' | '.join(f'{each:.0f}' for each in least) or '|'} |",
                flush=True,
            )
            if arguments.raw:
                for name, loop in zip((*SERVOS, *LEAST[engine], "world"), rounds, strict=True):
                    print(f"{name}:", *(f"{fmean(each):.0f}" for each in loop))


if __name__ == "__main__":
    main()
