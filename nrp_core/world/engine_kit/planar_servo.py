"""The planar servo: how a wheel drive moves its robot, the same in every engine.

Engines differ most in tyre contact: with their friction models a skid-steered robot turns at 10 to 60 % of
the commanded rate. So wheels roll without friction here, and the drive acts on the body:

* A change of the command changes the body's velocity at once, as in the ideal unicycle.
* Against everything else the velocity is held by forces, up to the friction of the tyres or the torque of
  the motors.

Seen from above, a body of mass ``m`` and radius of gyration ``k`` about its centre of mass moves as if driven
at four points of a cross, at ``lever = k / sqrt(2)``: the left and the right one ahead, the front and the
rear one sideways, each with::

    force = m/2 / TIME_CONSTANT_S * (aim - velocity),   |force| <= limit

Then the errors of forward, sideways and turning velocity decay at the same rate and without coupling, for any
robot. As with real tyres, each point has its share of the traction: a robot that tries to spin can be pushed,
so it does not lock itself against a wall. The forces act at the height of the centre of mass: a drive alone
neither pitches its robot nor tips it over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot, sqrt
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.errors import SceneError
from nrp_core.scene.inertia import inertia_tensor, sum_inertials
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import BodyVelocity, ModelMotion, Pose, Vector
from nrp_core.world.drives.ackermann import Ackermann
from nrp_core.world.drives.drive import driven_root, masses_in
from nrp_core.world.drives.mecanum import MecanumDrive, PlanarMove
from nrp_core.world.drives.wheels import WheelDrive

ROLLING_TIME_CONSTANT_S = 0.05
"""Time constant of a wheel that carries no load; slow enough not to rock the body by its reaction."""
DRIVING_TIME_CONSTANT_S = 0.001
"""Time constant of a wheel that moves its share of the robot; friction hardly slows it."""


@dataclass(frozen=True, slots=True)
class ServoedWheel:
    """A wheel that spins as its drive commands.

    Args:
        joint: its name.
        per_forward, per_turn: speed of the joint (rad/s) for each m/s forward and each rad/s of turn.
        per_left: the same for each m/s to the left; 0 for wheels without rollers.
        gain: gain of the servo, N m s/rad.
        limit: torque limit, N m.
        time_constant_s: time constant of its spin below the limit, s.
    """

    joint: str
    per_forward: float
    per_turn: float
    gain: float
    limit: float
    time_constant_s: float = ROLLING_TIME_CONSTANT_S
    per_left: float = 0.0

    def share_in(self, step_s: float) -> float:
        """Return the share of a wheel's speed error that one physics step removes."""
        return step_s / (step_s + self.time_constant_s)


def servoed_wheel(
    drive: WheelDrive | Ackermann | MecanumDrive, wheel: Body, side: float, carried: float
) -> ServoedWheel:
    """Return a wheel's servo; if the joint's axis points right, its sign is reversed.

    Args:
        drive: its drive.
        wheel: the wheel.
        side: -1 for a left wheel, 1 for a right one.
        carried: the mass (kg) that its friction moves; 0: it rolls without friction.
    """
    assert wheel.joint is not None
    assert wheel.inertial is not None
    axis = Pose(orientation=wheel.in_model.orientation).rotate(wheel.joint.axis)
    sign = 1.0 if axis[1] >= 0 else -1.0
    radius = drive.wheel_diameter / 2
    spin_axis = np.array(wheel.joint.axis)
    about_centre = product(product(spin_axis, inertia_tensor(wheel.inertial)), spin_axis)
    inertia = float(about_centre) + carried * radius**2
    time_constant_s = DRIVING_TIME_CONSTANT_S if carried else ROLLING_TIME_CONSTANT_S
    return ServoedWheel(
        wheel.joint.name,
        per_forward=sign / radius,
        per_turn=sign * side * drive.separation / 2 / radius,
        gain=inertia / time_constant_s,
        limit=min(drive.torque, wheel.joint.effort),
        time_constant_s=time_constant_s,
        per_left=sign * _roller_share(drive, wheel.joint.name, side) / radius,
    )


def _roller_share(drive: WheelDrive | Ackermann | MecanumDrive, joint: str, side: float) -> float:
    """Return the share of a motion to the left that turns a wheel: that of rollers at 45 degrees."""
    if not isinstance(drive, MecanumDrive):
        return 0.0
    is_front = joint in (drive.left[-1], drive.right[-1])
    return side if is_front else -side


PlanarDrive = WheelDrive | PlanarMove | Ackermann | MecanumDrive


def planar_drives(model: Model) -> tuple[PlanarDrive, ...]:
    """Return the drives of a model that move it on the ground."""
    return tuple(drive for drive in model.drives if isinstance(drive, PlanarDrive))


TIME_CONSTANT_S = 0.001
"""Time constant of the body's velocity below the limits.

On a slope a robot creeps at the speed that it would gain in free fall along the slope in this time, 2.5 mm/s
at 15 degrees.
"""
TRACTION = 1.0
"""Coefficient of friction between tyres and floor."""

Aims = tuple[float, float, float, float]
"""Forward velocities of the left and right point and leftward velocities of the front and rear point, m/s."""


def _towards(velocity: float, before: float, after: float) -> float:
    """Return the change of a velocity when its command changes."""
    change, gap = after - before, after - velocity
    if not change * gap > 0:
        return 0.0
    return change if (change < gap if change > 0 else change > gap) else gap  # the smaller one


def towards_each(velocity: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the changes of velocities when their commands change."""
    change, gap = after - before, after - velocity
    is_smaller = np.where(change > 0, change < gap, change > gap)
    return np.where(change * gap > 0, np.where(is_smaller, change, gap), 0.0)


@dataclass(frozen=True, slots=True)
class PlanarServo:
    """The servo of one drive.

    Args:
        body: index of the driven body among its model's; its frame looks along x.
        centre: the robot's centre of mass in the body's frame.
        to_centre: that point relative to the drive's centre (the middle of its wheels), forward and left.
        lever: distance of the four points from the centre, m.
        gain: gain of each point, N s/m.
        limit: force limit of each point, N.
        wheels: the wheels, left ones first.
    """

    body: int
    centre: Vector
    to_centre: tuple[float, float]
    lever: float
    gain: float
    limit: float
    wheels: tuple[ServoedWheel, ...] = ()

    @property
    def points(self) -> tuple[Vector, Vector, Vector, Vector]:
        """The left, right, front and rear point in the body's frame."""
        x, y, z = self.centre
        lever = self.lever
        return (x, y + lever, z), (x, y - lever, z), (x + lever, y, z), (x - lever, y, z)

    def aims(self, velocity: BodyVelocity, step_s: float) -> Aims:
        """Return the target velocities of the points for a commanded velocity of the body.

        In a turn the forces have to bend the path, so the targets are ahead of the velocities. Half a step is
        added, because an engine moves a body along its heading at the start of the step, while the arc's
        chord points half the step's turn further.

        Args:
            velocity: the command.
            step_s: the physics step.
        """
        forward, side, turn = self._centre_velocity(velocity)
        bend = (TIME_CONSTANT_S + step_s / 2) * turn
        forward, side = forward - bend * side, side + bend * forward
        swing = turn * self.lever
        return forward - swing, forward + swing, side + swing, side - swing

    def changed(self, motion: ModelMotion, before: BodyVelocity, after: BodyVelocity) -> ModelMotion:
        """Return the motion right after the command has changed, by :meth:`change`.

        Args:
            motion: the motion of the driven body's frame.
            before: the command until now.
            after: the command from now on.
        """
        to_body = motion.pose.rotate_back
        forward, left, turn = self.change(to_body(motion.linear), to_body(motion.angular), before, after)
        linear = motion.pose.rotate((forward, left, 0.0))
        angular = motion.pose.rotate((0.0, 0.0, turn))
        return ModelMotion(motion.pose, _sum(motion.linear, linear), _sum(motion.angular, angular))

    def change(
        self,
        linear: Vector,
        angular: Vector,
        before: BodyVelocity,
        after: BodyVelocity,
        towards: Callable[[Any, Any, Any], Any] = _towards,
    ) -> Vector:
        """Return the change of the driven body's velocity when the command changes.

        Each velocity changes by the change of the command, but only towards the command and not beyond it: a
        robot held by a wall is not thrown back when the command decreases. Without traction nothing changes.

        Args:
            linear: linear velocity of the driven body's frame, along its own axes, m/s.
            angular: angular velocity about these axes, rad/s.
            before: the command until now.
            after: the command from now on.
            towards: :func:`towards_each` if all numbers are arrays.

        Returns:
            The changes of the forward (m/s), leftward (m/s) and turning (rad/s) velocity.
        """
        if not self.limit:
            return 0.0, 0.0, 0.0
        vx, vy, _ = linear
        wx, wy, wz = angular
        x, y, z = self.centre
        now = (vx + wy * z - wz * y, vy + wz * x - wx * z, wz)
        forward, side, turn = map(towards, now, self._centre_velocity(before), self._centre_velocity(after))
        return forward + turn * y, side - turn * x, turn

    def spins(self, velocity: BodyVelocity) -> tuple[float, ...]:
        """Return the velocities of the wheel joints, rad/s."""
        forward, left, turn = velocity.forward, velocity.left, velocity.turn
        return tuple(
            [
                wheel.per_forward * forward + wheel.per_turn * turn + wheel.per_left * left
                for wheel in self.wheels
            ]
        )

    def explicit_gain(self, step_s: float) -> float:
        """Return the gain with which a force held for a step has the effect of an implicit integrator."""
        return self.gain * TIME_CONSTANT_S / (TIME_CONSTANT_S + step_s)

    def _centre_velocity(self, velocity: BodyVelocity) -> Vector:
        """Return the forward, sideways and turning velocity of the centre of mass for one of the drive."""
        ahead, aside = self.to_centre
        turn = velocity.turn
        return velocity.forward - turn * aside, velocity.left + turn * ahead, turn


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def servo_of(
    model: Model, drive: PlanarDrive, bodies: Sequence[Body], gravity: Vector, physical: bool = False
) -> PlanarServo:
    """Build the servo of a drive.

    Args:
        model: the model that it drives.
        drive: the drive.
        bodies: the bodies of the model.
        gravity: the gravity of the scene, m/s^2.
        physical: whether wheels with tyres, if any, move the robot by friction, and not the servo.

    Raises:
        SceneError: a wheel cannot turn, or the wheels are not held by one freely floating body.
    """
    sides = () if isinstance(drive, PlanarMove) else ((-1.0, drive.left), (1.0, drive.right))
    wheels = [(side, _wheel(model, drive, bodies, name)) for side, names in sides for name in names]
    base = driven_root(model, drive, bodies, [wheel for _, wheel in wheels])
    whole = sum_inertials(masses_in(base, bodies))
    assert whole is not None  # a movable body has mass
    lever = sqrt(float(inertia_tensor(whole)[2, 2]) / whole.mass / 2)
    x, y, _ = whole.pose.position
    middle = _middle(drive, [wheel for _, wheel in wheels])
    physical = physical and _has_tyres(drive)
    carried = whole.mass / len(wheels) if physical else 0.0
    return PlanarServo(
        base,
        whole.pose.position,
        (x - middle[0], y - middle[1]),
        lever,
        gain=whole.mass / 2 / TIME_CONSTANT_S,
        limit=0.0 if physical else _limit(drive, whole.mass, gravity),
        wheels=()
        if isinstance(drive, PlanarMove)
        else tuple(servoed_wheel(drive, wheel, side, carried) for side, wheel in wheels),
    )


def without_wheel_friction(model: Model, bodies: Sequence[Body], physical: bool = False) -> tuple[Body, ...]:
    """Return the bodies with frictionless wheels, or frictionless bases for drives without wheels.

    The servo supplies their traction, unless wheels are ``physical``. Friction and damping of the joints of
    such wheels are removed, too, because their motors do not move the robot.
    """
    wheels = {
        name
        for drive in planar_drives(model)
        if not (isinstance(drive, PlanarMove) or (physical and _has_tyres(drive)))
        for name in (*drive.left, *drive.right)
    }
    slides = any(isinstance(drive, PlanarMove) for drive in planar_drives(model))
    return tuple(
        _slippery(body) if (body.joint.name in wheels if body.joint else slides and body.floats) else body
        for body in bodies
    )


def _has_tyres(drive: PlanarDrive) -> bool:
    """Return whether friction can move a drive: the rollers of mecanum wheels are not simulated."""
    return not isinstance(drive, PlanarMove | MecanumDrive)


def _slippery(body: Body) -> Body:
    links = tuple(
        replace(link, collisions=tuple(replace(collision, friction=0.0) for collision in link.collisions))
        for link in body.links
    )
    joint = body.joint and replace(body.joint, damping=0.0, friction=0.0)
    return replace(body, links=links, joint=joint)


def _wheel(model: Model, drive: PlanarDrive, bodies: Sequence[Body], joint: str) -> Body:
    for body in bodies:
        if body.joint is not None and body.joint.name == joint:
            return body
    raise SceneError(f"the drive '{drive.name}' of '{model.name}' has a wheel that cannot turn: '{joint}'")


def _middle(drive: PlanarDrive, wheels: Sequence[Body]) -> tuple[float, float]:
    """Return the point whose velocity is commanded: the middle of the wheels, or of a car's rear wheels."""
    if isinstance(drive, Ackermann):
        rear = (drive.left[0], drive.right[0])
        wheels = [wheel for wheel in wheels if wheel.joint is not None and wheel.joint.name in rear]
    if not wheels:
        return 0.0, 0.0
    places = [wheel.in_model.position for wheel in wheels]
    return sum(x for x, _, _ in places) / len(places), sum(y for _, y, _ in places) / len(places)


def _limit(drive: PlanarDrive, mass: float, gravity: Vector) -> float:
    """Return the maximum force of half of the tyres, or of one side's motors, on the ground."""
    traction = TRACTION * mass * hypot(*gravity) / 2
    if isinstance(drive, PlanarMove):
        return traction
    motors = min(len(drive.left), len(drive.right)) * drive.torque / (drive.wheel_diameter / 2)
    return min(traction, motors)
