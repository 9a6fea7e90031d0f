"""A chain of rods with motors, and its commands."""

from __future__ import annotations

from math import inf

from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController
from nrp_core.scene.model import Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose
from nrp_core.world.world import World

GRAVITY, MASS, LENGTH, LINKS = 9.8, 2.0, 0.2, 6


def chain(*, effort: float = inf, velocity: float = inf, kind: str = "position", links: int = LINKS) -> Model:
    """Return rods in a row that stretch out along x from a joint on the world; they turn about y."""
    rods = [
        Link(
            f"l{i}",
            Pose((LENGTH * i, 0.0, 0.0)),
            Inertial(MASS, Pose((LENGTH / 2, 0.0, 0.0)), (2e-3, 1e-2, 1e-2, 0, 0, 0)),
        )
        for i in range(links)
    ]
    joints = [
        Joint(
            f"j{i}", "revolute", f"l{i - 1}" if i else "world", f"l{i}", rods[i].pose, (0.0, 1.0, 0.0),
            effort=effort, velocity=velocity,
        )
        for i in range(links)
    ]  # fmt: skip
    control = [JointController(f"j{i}", kind, f"/chain/j{i}/{kind}", None) for i in range(links)]
    return Model(
        "chain", tuple(rods), tuple(joints), pose=Pose((0, 0, 2.0)), controllers=tuple(control),
        joint_states_topic="/joints",
    )  # fmt: skip


def command(
    world: World, value: float, *, joint: str = "j0", kind: str = "position", model: str = "chain"
) -> None:
    world.advertise(f"/{model}/{joint}/{kind}").publish(Float64(value))
