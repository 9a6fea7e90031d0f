"""Short functions that build scenes: objects, walls, a wheeled robot with a camera. Units: m, kg."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import (
    Box,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Link,
    Model,
    Plane,
    Rgba,
    Visual,
)
from nrp_core.world.sensors.camera import Camera

RED: Rgba = (1.0, 0.0, 0.0, 1.0)
GREEN: Rgba = (0.0, 1.0, 0.0, 1.0)
BLUE: Rgba = (0.0, 0.0, 1.0, 1.0)
GREY: Rgba = (0.6, 0.6, 0.6, 1.0)

WHEEL_RADIUS, WHEEL_WIDTH, TRACK = 0.15, 0.08, 0.5
LENGTH, CAMERA_HEIGHT = 0.8, 0.5
FIELD_OF_VIEW, WIDTH, HEIGHT = pi / 2, 48, 32
CAMERA_HZ = 25.0
DRIVE_TIMEOUT_S = 0.3


def prop(
    name: str, geometry: Geometry, pose: Pose = Pose(), *,
    mass: float = 0.0, rgba: Rgba = GREY, solid: bool = True,
) -> Model:  # fmt: skip
    """Return a model of one link, static unless it has a mass; its visual is ``<name>/link/visual``."""
    moment = 0.02 * mass
    inertial = Inertial(mass, inertia=(moment, moment, moment, 0.0, 0.0, 0.0)) if mass else None
    touching = (Collision("collision", geometry),) if solid else ()
    link = Link("link", Pose(), inertial, (Visual("visual", geometry, rgba=rgba),), touching)
    return Model(name, (link,), pose=pose, static=not mass)


def rubbing(model: Model, friction: float) -> Model:
    """Return a model of one link whose shapes have a coefficient of friction."""
    (link,) = model.links
    collisions = tuple(replace(each, friction=friction) for each in link.collisions)
    return replace(model, links=(replace(link, collisions=collisions),))


def at(x: float, y: float, z: float, *, yaw: float = 0.0) -> Pose:
    """Return a pose that is rotated about z only."""
    return Pose.from_rpy((x, y, z), 0.0, 0.0, yaw)


def floor() -> Model:
    """Return the ground."""
    return prop("floor", Plane((40.0, 40.0)))


def screen(name: str, y: float, rgba: Rgba, *, x: float = 3.0, z: float = CAMERA_HEIGHT) -> Model:
    """Return a flat square that faces the origin and touches nothing."""
    return prop(name, Box((0.1, 1.0, 1.0)), at(x, y, z), rgba=rgba, solid=False)


def robot(
    name: str = "robot", x: float = 0.0, y: float = 0.0, *, yaw: float = 0.0, tilt: float = 0.0
) -> Model:
    """Return a robot with four wheels that stands on the floor, its camera above its centre.

    Args:
        name: the model name, and the prefix of its topics.
        x: the x position, m.
        y: the y position, m.
        yaw: the heading, rad.
        tilt: the downward tilt of its camera, rad.
    """
    body = Box((LENGTH, 0.4, 0.2))
    base = Link(
        "base", Pose(), Inertial(20.0, Pose((0.0, 0.0, -0.05)), (0.4, 1.2, 1.4, 0.0, 0.0, 0.0)),
        (Visual("body", body),), (Collision("body", body),),
    )  # fmt: skip
    optics = Camera(
        "camera", f"/{name}/camera", CAMERA_HZ, FIELD_OF_VIEW, WIDTH, HEIGHT,
        pose=Pose.from_rpy((0.0, 0.0, 0.0), 0.0, tilt, 0.0),
    )  # fmt: skip
    eye = Link(
        "eye", Pose((0.0, 0.0, CAMERA_HEIGHT - WHEEL_RADIUS)),
        Inertial(0.1, inertia=(1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0)), sensors=(optics,),
    )  # fmt: skip
    corners = {
        f"{end}_{side}": (0.25 * along, TRACK / 2 * across)
        for end, along in (("back", -1), ("front", 1))
        for side, across in (("left", 1), ("right", -1))
    }
    wheels = {corner: _wheel(corner, *place) for corner, place in corners.items()}
    joints = [
        Joint(corner, "continuous", "base", wheel.name, wheel.pose, (0.0, 1.0, 0.0))
        for corner, wheel in wheels.items()
    ]
    drive = WheelDrive(
        "drive", f"/{name}/cmd_vel", ("back_left", "front_left"), ("back_right", "front_right"), TRACK,
        2 * WHEEL_RADIUS, torque=20.0, timeout=DRIVE_TIMEOUT_S, rate_hz=50.0,
        odometry_topic=f"/{name}/odom", wheel_speeds_topic=f"/{name}/wheel_speeds",
    )  # fmt: skip
    return Model(
        name, (base, eye, *wheels.values()), (Joint("mast", "fixed", "base", "eye"), *joints), (drive,),
        at(x, y, WHEEL_RADIUS, yaw=yaw), joint_states_topic=f"/{name}/joint_states",
    )  # fmt: skip


def _wheel(corner: str, x: float, y: float) -> Link:
    shape, lying = Cylinder(WHEEL_RADIUS, WHEEL_WIDTH), Pose.from_rpy((0.0, 0.0, 0.0), pi / 2, 0.0, 0.0)
    moment = (0.01, 0.02, 0.01, 0.0, 0.0, 0.0)
    return Link(
        f"{corner}_wheel", Pose((x, y, 0.0)), Inertial(2.0, inertia=moment),
        (Visual("tyre", shape, lying),), (Collision("tyre", shape, lying),),
    )  # fmt: skip


def pendulum(damping: float = 2.0) -> Model:
    """Return a pendulum bob on a joint along y at height 2, its mass ahead of the joint."""
    bob = Link("bob", Pose(), Inertial(2.0, Pose((0.5, 0.0, 0.0)), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
    joint = Joint("joint", "revolute", "world", "bob", Pose(), (0, 1, 0), -0.5, 0.6, damping=damping)
    return Model("pendulum", (bob,), (joint,), pose=at(0, 0, 2), joint_states_topic="/pendulum/joint_states")
