"""Velocities of bodies that decay (SDF's ``<velocity_decay>``), by the wrench of each physics step."""

from __future__ import annotations

from dataclasses import dataclass
from math import expm1

from nrp_core.world.rigid.motion import Wrench
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.merged_bodies import Body


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
