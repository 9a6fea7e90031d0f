"""What a 20 ms step of a world costs beside the same physics, servo, reads and images in a raw loop.

The room and the robot are those of the Braitenberg experiment; every step brings a new command and reads
the poses of all models, and a camera takes 30 images a second. The raw loop makes the engine's own calls:
it sets the backend's servo, steps, reads the robot's pose and velocity, and takes the same images at the
same times by the same renderer. CPU time of each step, best of several rounds in which raw loop and world
take turns.
``camera_percent`` is what is added beyond what is added without a camera, of the raw step.

    python benchmarks/world_step.py
    python benchmarks/world_step.py --steps 500 --rounds 5 --json
    python benchmarks/world_step.py --engines drake
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from math import pi
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np
from conditions import print_conditions

from nrp_core.clock import SampleSchedule
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyPath, BodyVelocity, Pose, ReadFrames, matrix_of
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.render.cameras import Cameras, optics_of
from nrp_core.world.render.raster import RasterCameras
from nrp_core.world.render.realistic import RealisticCameras

STEP_NS, SUBSTEP_NS, SUBSTEPS = 20_000_000, 2_000_000, 10
IMAGES_HZ = 30
CAMERA = ("husky", "eye_vision_camera", "camera")

Step = Callable[[int], None]


class Case(NamedTuple):
    """What is measured: an engine, and a renderer with a scale of the 320x240 image, or no camera."""

    engine: str
    renderer: str | None = None
    scale: float = 1.0

    @property
    def image(self) -> str:
        size = f"{320 * self.scale:.0f}x{240 * self.scale:.0f}"
        return "no camera" if self.renderer is None else f"{self.renderer} {size}"


CASES = (
    Case("mujoco"),
    Case("mujoco", "raster", 0.2),
    Case("mujoco", "raster"),
    Case("mujoco", "realistic"),
    Case("pybullet"),
    Case("pybullet", "raster", 0.2),
    Case("pybullet", "raster"),
    Case("drake"),
    Case("drake", "raster", 0.2),
)


def shipped_scene() -> Scene:
    folder = Path(str(files("nrp_experiments.braitenberg_husky")))
    robot = read_model(folder / "husky.sdf", name="husky", pose=Pose.from_rpy((0, 0, 0.15), 0, 0, pi))
    return read_scene(folder / "room.sdf").with_model(robot)


def command(k: int) -> tuple[float, float]:
    """Return forward velocity and turn rate of step ``k``; never the same twice in a row.

    They lead to and fro, so that both loops see the same: how long an image takes depends on what it shows.
    """
    sign = 1 if k // 21 % 2 else -1
    return sign * (0.1 + 0.05 * (k % 3)), sign * (0.5 + 0.1 * (k % 7))


SCHEDULE = SampleSchedule.of(IMAGES_HZ, SUBSTEP_NS)


def substeps_to_image(k: int) -> int | None:
    """Return after which physics step of step ``k`` an image is taken, None where there is none."""
    due_ns = SCHEDULE.next_after(k * STEP_NS)
    return (due_ns - k * STEP_NS) // SUBSTEP_NS if due_ns <= (k + 1) * STEP_NS else None


def cameras_of(case: Case, scene: Scene, bodies: Any, reader: Any) -> Cameras:
    """Return the same cameras as the world has, warmed up as there."""
    optics = optics_of(scene, case.scale)
    alone = {model: [body for body, _ in each] for model, each in bodies.items()}
    if case.renderer == "realistic":
        cameras: Cameras = RealisticCameras(alone, optics, reader, scene.lights)
    else:
        cameras = RasterCameras(alone, optics, reader)
    cameras.image(CAMERA)
    return cameras


@contextmanager
def world_loop(case: Case, scene: Scene) -> Iterator[Step]:
    backend = worlds().load(case.engine)
    renderer = {"renderer": case.renderer} if case.renderer else {}
    options = backend.options.model_validate({"image_scale": case.scale, **renderer})
    with backend.open(scene, seed=1, options=options) as world:
        commands, states = world.advertise("/husky/cmd_vel"), world.subscribe("/gazebo/model_states")
        if case.renderer is not None:
            world.subscribe("/husky/camera")

        def step(k: int) -> None:
            forward, turn = command(k)
            commands.publish(Twist(Vector3(forward), Vector3(0.0, 0.0, turn)))
            world.run_until(world.now_ns + STEP_NS)
            assert states.latest is not None

        yield step


@contextmanager
def raw_mujoco(case: Case, scene: Scene) -> Iterator[Step]:
    """MuJoCo's own calls on the same model, with the backend's servo, which is made of its actuators."""
    from nrp_world_mujoco.build import build
    from nrp_world_mujoco.drive import Drive
    from nrp_world_mujoco.library import mujoco
    from nrp_world_mujoco.motion import Floating

    built = build(scene, timestep_ns=SUBSTEP_NS)
    model, data = built.model, mujoco.MjData(built.model)
    servo, actuators = next(iter(built.drives.values()))
    base = Floating(model, data, built.bodies["husky"][servo.body][1])
    drive = Drive(data, servo, base, actuators, SUBSTEP_NS / 1e9)
    drive.set_velocity(BodyVelocity())
    mujoco.mj_forward(model, data)

    def reader(paths: Sequence[BodyPath]) -> ReadFrames:
        ids = np.array([built.bodies[name][index][1] for name, index in paths], int)

        def read(frames: Any) -> None:
            frames[:, :, :3] = data.xmat[ids].reshape(-1, 3, 3)
            frames[:, :, 3] = data.xpos[ids]

        return read

    cameras = cameras_of(case, scene, built.bodies, reader)
    seen = [cameras.image(CAMERA)]  # a reader keeps the latest image, too

    def step(k: int) -> None:
        forward, turn = command(k)
        drive.set_velocity(BodyVelocity(forward, 0.0, turn))
        before = substeps_to_image(k) if case.renderer else None
        if before is not None:
            mujoco.mj_step(model, data, before)
            mujoco.mj_kinematics(model, data)
            seen[0] = cameras.image(CAMERA)
        if before != SUBSTEPS:
            mujoco.mj_step(model, data, SUBSTEPS - (before or 0))
        data.qpos[:7].tolist(), data.qvel[:6].tolist()

    yield step
    cameras.close()


@contextmanager
def raw_pybullet(case: Case, scene: Scene) -> Iterator[Step]:
    """PyBullet's own calls on the same bodies, with the backend's servo before each physics step."""
    from nrp_world_pybullet.build import build
    from nrp_world_pybullet.drive import Drive
    from nrp_world_pybullet.library import bullet
    from nrp_world_pybullet.motion import place_of

    client = bullet.connect(bullet.DIRECT)
    built = build(scene, timestep_ns=SUBSTEP_NS, client=client)
    servo = next(iter(built.drives.values()))
    body, place = built.bodies["husky"][servo.body]
    wheels = [built.joints["husky"][wheel.joint] for wheel in servo.wheels]
    drive = Drive(client, servo, body, wheels[0].multibody, wheels, SUBSTEP_NS / 1e9, scene.gravity)

    def reader(paths: Sequence[BodyPath]) -> ReadFrames:
        places = [place_of(*built.bodies[name][index], Pose(), client) for name, index in paths]

        def read(frames: Any) -> None:
            for frame, place in zip(frames, places, strict=True):
                position, orientation = place()
                frame[:, :3] = np.reshape(bullet.getMatrixFromQuaternion(orientation), (3, 3))
                frame[:, 3] = position

        return read

    cameras = cameras_of(case, scene, built.bodies, reader)
    seen = [cameras.image(CAMERA)]

    def step(k: int) -> None:
        forward, turn = command(k)
        drive.set_velocity(BodyVelocity(forward, 0.0, turn))
        before = substeps_to_image(k) if case.renderer else None
        for number in range(1, SUBSTEPS + 1):
            drive.push()
            bullet.stepSimulation(client)
            if number == before:
                seen[0] = cameras.image(CAMERA)
        bullet.getBasePositionAndOrientation(place.multibody, client)
        bullet.getBaseVelocity(place.multibody, client)

    yield step
    bullet.disconnect(client)


@contextmanager
def raw_drake(case: Case, scene: Scene) -> Iterator[Step]:
    """Drake's own calls on the same bodies, with the backend's servo before each physics step."""
    from nrp_world_drake.build import build
    from nrp_world_drake.drive import Drive
    from nrp_world_drake.motion import Base, Running

    built = build(scene, timestep_ns=SUBSTEP_NS)
    running = Running(built, SUBSTEP_NS)
    plant, context = running.plant, running.context
    ((path, servo),) = built.drives.items()
    base = Base(running, built.bodies["husky"][servo.body][1])
    drive = Drive(running, servo, base, built.spins[path], SUBSTEP_NS / 1e9, scene.gravity)

    def reader(paths: Sequence[BodyPath]) -> ReadFrames:
        bodies = [built.bodies[name][index] for name, index in paths]
        still = [matrix_of(body.pose) for body, _ in bodies]

        def read(frames: Any) -> None:
            for frame, at, (body, place) in zip(frames, still, bodies, strict=True):
                frame[:] = at if body.fixed else plant.EvalBodyPoseInWorld(context, place).GetAsMatrix34()

        return read

    cameras = cameras_of(case, scene, built.bodies, reader)
    seen = [cameras.image(CAMERA)]

    def step(k: int) -> None:
        forward, turn = command(k)
        drive.set_velocity(BodyVelocity(forward, 0.0, turn))
        before = substeps_to_image(k) if case.renderer else None
        for number in range(1, SUBSTEPS + 1):
            drive.push()
            running.touch()
            running.step()
            if number == before:
                seen[0] = cameras.image(CAMERA)
        plant.GetPositionsAndVelocities(context)

    yield step


RAW = {"mujoco": raw_mujoco, "pybullet": raw_pybullet, "drake": raw_drake}


def measure(step: Step, start: int, steps: int) -> list[float]:
    """Return CPU microseconds of each step."""
    costs = []
    for k in range(start, start + steps):
        began = time.process_time_ns()
        step(k)
        costs.append((time.process_time_ns() - began) / 1e3)
    return costs


def best(rounds: Sequence[Sequence[float]]) -> float:
    """Return the mean step of the best rounds, found for each step by itself: other programs disturb some."""
    return fmean(min(each) for each in zip(*rounds, strict=True))


def compare(case: Case, scene: Scene, steps: int, rounds: int) -> dict[str, Any]:
    """Return the cost of a step of the raw loop and of the world."""
    with RAW[case.engine](case, scene) as raw, world_loop(case, scene) as ours:
        costs = [
            [measure(step, number * steps, steps) for step in (raw, ours)] for number in range(rounds + 1)
        ]
        raw_us, world_us = (best(column) for column in zip(*costs[1:], strict=True))  # the first warms up
    added = world_us - raw_us
    return {
        "engine": case.engine,
        "camera": case.image,
        "raw_us": round(raw_us, 1),
        "world_us": round(world_us, 1),
        "added_us": round(added, 1),
        "added_percent": round(100 * added / raw_us, 1),
        "real_time_factor": round(STEP_NS / 1e3 / world_us, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "--steps", type=int, default=200, help="a multiple of 5: each round has its images alike"
    )
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--engines", nargs="+", choices=RAW, default=("mujoco", "pybullet"))
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    print_conditions()
    scene = shipped_scene()
    cases = [case for case in CASES if case.engine in arguments.engines]
    rows = [compare(case, scene, arguments.steps, arguments.rounds) for case in cases]
    bare = {row["engine"]: row["added_us"] for row in rows if row["camera"] == "no camera"}
    for row in rows:
        row["camera_percent"] = round(100 * (row["added_us"] - bare[row["engine"]]) / row["raw_us"], 1)
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return
    for row in (dict(zip(rows[0], rows[0], strict=True)), *rows):
        print("  ".join(f"{value!s:>{max(len(key), 12)}}" for key, value in row.items()))


if __name__ == "__main__":
    main()
