"""Bodies as every engine simulates them: stable springs and velocity decay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import expm1

from nrp_core.scene.merged_bodies import Body, bodies_of, joint_inertias
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Pose, Vector, Wrench
from nrp_core.world.engine_kit.planar_servo import without_wheel_friction

STIFF = 0.5
"""``stiffness * step^2 / (inertia + damping * step)`` above which a spring is stiff; engines take dampers at
the end of a step, so that the limit of stability is at least 2."""


def with_steady_springs(bodies: Sequence[Body], step_s: float) -> tuple[Body, ...]:
    """Return bodies whose springs are stable with the step.

    A stiff spring gets ``stiffness * step`` as additional damping, which is backward Euler. One that the
    damper of its joint holds acts as it is.

    Args:
        bodies: the bodies of one model.
        step_s: the physics step.
    """
    inertias = joint_inertias(bodies) if any(body.joint and body.joint.stiffness for body in bodies) else {}
    steady = []
    for body in bodies:
        joint = body.joint
        if joint and joint.stiffness:
            held = inertias.get(joint.name, 0.0) + joint.damping * step_s
            if joint.stiffness * step_s**2 > STIFF * held:
                body = replace(body, joint=replace(joint, damping=joint.damping + joint.stiffness * step_s))
        steady.append(body)
    return tuple(steady)


@dataclass(frozen=True, slots=True)
class Decay:
    """The coefficients of the wrench on a body by which its velocity decays exponentially.

    The wrench is constant in a step, so they take the decay of a whole step into account, and no rate is too
    large for the step.

    Args:
        linear: of its centre of mass, N s/m.
        angular: about its principal axes, N m s/rad.
    """

    linear: float
    angular: Vector

    @classmethod
    def of(cls, body: Body, step_s: float) -> Decay | None:
        """Return the decay of a body; None without one.

        Args:
            body: the body.
            step_s: the physics step.
        """
        if body.inertial is None or not any(body.decay):
            return None
        linear, angular = (-expm1(-rate * step_s) / step_s for rate in body.decay)
        ix, iy, iz = body.inertial.inertia[:3]
        return cls(linear * body.inertial.mass, (angular * ix, angular * iy, angular * iz))

    def wrench(self, axes: Pose, linear: Vector, angular: Vector) -> Wrench:
        """Return the wrench in the next step.

        Args:
            axes: the orientation of the principal axes in the world.
            linear: the velocity of the centre of mass, m/s.
            angular: the angular velocity in the world, rad/s.
        """
        x, y, z = (-self.linear * v for v in linear)
        torque = [-k * w for k, w in zip(self.angular, axes.rotate_back(angular), strict=True)]
        return Wrench((x, y, z), axes.rotate((torque[0], torque[1], torque[2])))


def simulated_bodies(model: Model, step_s: float, physical: bool) -> tuple[Body, ...]:
    """Return the bodies of a model, prepared for an engine.

    Args:
        model: the model.
        step_s: the physics step.
        physical: whether wheels move the robot by friction.
    """
    return with_steady_springs(without_wheel_friction(model, bodies_of(model), physical), step_s)
