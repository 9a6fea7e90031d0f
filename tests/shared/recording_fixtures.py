"""A brain that fires when told and a world of discs that drive, with a camera, and a recorder on both."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha
from nrp_core.dsl.testing import MockBrain
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.recording.layout import RUN_NAME, Images
from nrp_core.recording.recording import Recording
from nrp_core.recording.sealing import seal
from nrp_core.recording.writing.recorder import McapRecorder
from nrp_core.scene.model import Box, Cylinder, Link, Model, Plane, Scene, Sphere, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.world import World

PERIOD_NS = 20_000_000
STEPS = 10
"""The steps of the recorded drive."""


def room() -> Scene:
    """A wall whose glass can change its colour, some furniture, and a husky with a camera."""
    ground = Visual("ground", Plane((8.0, 8.0)))
    glass = Visual("glass", Box((0.02, 2.0, 1.0)), Pose((0.0, 0.0, 1.0)), (0.0, 0.0, 1.0, 1.0))
    stool = Visual("stool", Cylinder(0.2, 0.5), Pose((0.0, 2.0, 0.25)))
    ball = Visual("ball", Sphere(0.1), Pose((0.0, -2.0, 0.1)))
    chassis = Visual("chassis", Box((0.9, 0.5, 0.3)))
    eye = Camera("eye", "/husky/camera", rate_hz=30.0, horizontal_fov=1.57, width=2, height=2)
    drive = WheelDrive(
        "drive", "/husky/cmd_vel", (), (), separation=0.5, wheel_diameter=0.3, timeout=0.1, rate_hz=50.0,
        odometry_topic="/husky/odom",
    )  # fmt: skip
    return Scene((
        Model("floor", (Link("body", visuals=(ground,)),), static=True),
        Model("wall", (Link("body", visuals=(glass, stool, ball)),), pose=Pose((3.0, 0.0, 0.0)), static=True),
        Model("husky", (Link("base", visuals=(chassis,), sensors=(eye,)),), drives=(drive,)),
    ))  # fmt: skip


@dataclass
class Rig:
    """A brain, a world and what records them."""

    brain: MockBrain
    world: World
    folder: Path
    recorder: McapRecorder

    def step(self, *, forward: float = 0.5, turn: float = 0.2) -> None:
        """Take a step of 20 ms with a command and two spikes, and record it."""
        until_ns = self.brain.now_ns + PERIOD_NS
        until_ms = until_ns * 1e-6
        self.brain.fire([0, 4], [until_ms - 5.5, until_ms])
        self.brain.run_until(until_ns)
        self.world.run_until(until_ns)
        self.world.advertise("/husky/cmd_vel").publish(Twist(Vector3(forward), Vector3(z=turn)))
        self.recorder.step()


@pytest.fixture
def brain() -> MockBrain:
    brain = MockBrain({"eyes": 3, "wheels": 2})
    brain.add_sink(LeakyIntegratorAlpha(), [3, 4], name="steer/left")
    return brain


@pytest.fixture
def world(site: Path) -> Iterator[World]:
    from experiment_fakes import DiscBackend, DiscOptions

    with DiscBackend().open(room(), seed=1, options=DiscOptions()) as world:
        yield world


@pytest.fixture
def make_rig(brain: MockBrain, world: World, tmp_path: Path) -> Iterator[Any]:
    """A function that starts a recording, with the camera in use."""
    with ExitStack() as stack:

        def make(images: Images = Images.JPEG) -> Rig:
            world.subscribe("/husky/camera")
            recorder = McapRecorder(brain, world, tmp_path, period_ns=PERIOD_NS, images=images)
            stack.callback(recorder.close)
            return Rig(brain, world, tmp_path, recorder)

        yield make


@pytest.fixture
def rig(make_rig: Any) -> Rig:
    return make_rig()  # type: ignore[no-any-return]


@pytest.fixture
def recorded_drive(rig: Rig) -> Recording:
    """The recording of ten steps, with a colour of the wall that changed, and groups of neurons."""
    for _ in range(STEPS):
        rig.step()
    rig.world.advertise("/wall/body/glass/color").publish(ColorRGBA(1.0))
    rig.recorder.step()
    rig.recorder.close()
    run = {
        "experiment": "driving", "recorded": "2026-01-02T03:04:05+00:00", "seed": 3,
        "brain": {
            "backend": "mock",
            "populations": {"eyes": {"size": 3, "cell_type": "c"}, "wheels": {"size": 2, "cell_type": "c"}},
            "views": {"left": {"eyes": [[0, 1]], "wheels": [[0, 1]]}, "seeing": {"eyes": [[0, 2]]}},
        },
        "settings": {"timestep": 20_000_000, "description": "a drive"},
    }  # fmt: skip
    (rig.folder / RUN_NAME).write_bytes(seal(run))
    return Recording(rig.folder)
