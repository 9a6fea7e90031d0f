"""The servo of a single joint, the same in every engine: stiffness and damping, by backward Euler.

Engines that integrate velocities implicitly do this by themselves, with ``damping + stiffness * step`` as
damping. For engines that take forces at the start of a step, :class:`ExplicitServos` computes efforts with
the same effect. It also computes those of the joints' dampers, because strong dampers make such engines
unstable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import ServoTarget
from nrp_core.world.engine_kit.elimination import solve

Stops = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]


def servoed_joints(model: Model) -> tuple[str, ...]:
    """Return the joints of a model that have a servo."""
    controlled = [controller.joint for controller in model.controllers]
    followed = [joint for each in model.leaders for joint in each.joints]
    led = [joint for drive in model.drives for field in drive.servo_fields for joint in getattr(drive, field)]
    return tuple(dict.fromkeys([*controlled, *followed, *led]))


class ExplicitServos:
    """Computes the efforts of all joints of a tree for one step.

    The velocities at the end of the step depend on the other loads on the joints. These are estimated from
    the effect of the last step's efforts, so that a joint at rest gets exactly its stiffness times its error.
    With accelerations ``a``, inertia ``M`` and loads ``l``::

        efforts = wanted - step * damping * a,    M a = efforts - l,    l = last efforts - M * (last a)

    If the efforts against gravity and velocities are known, only the other loads are estimated. Muscles need
    this: with light links these efforts change much from one step to the next.

    Args:
        limits: limits of the efforts of the servos, shape ``(n,)``.
        step_s: the physics step.
        dampers: damping of the joints' dampers, N m s/rad or N s/m; None for none.
        armatures: inertia of the joints' motors that the engine lacks, kg m^2 or kg; None for none.
        limits_first: whether, as in MuJoCo, the limits bound efforts from the state at the start of a step,
            and damping then acts on those that are within; otherwise they bound the efforts themselves.

    Attributes:
        braking: the efforts of the dampers in the next step, which have no limit, and of the stops; by how
            much damping reduces those of muscles; and the efforts that accelerate the motors.
    """

    def __init__(
        self,
        limits: Sequence[float],
        step_s: float,
        dampers: FloatArray | None = None,
        armatures: FloatArray | None = None,
        *,
        limits_first: bool = False,
    ) -> None:
        self._limits, self._step_s, self._limits_first = np.array(limits), step_s, limits_first
        self._dampers = np.zeros(len(limits)) if dampers is None else dampers.copy()
        self._motors = np.diag(np.zeros(len(limits)) if armatures is None else armatures)
        self.braking = np.zeros(len(limits))
        self._aims = np.zeros((len(limits), 5))  # the columns are the fields of ServoTarget
        self._ahead_s = np.full(len(limits), step_s)
        self._efforts = np.zeros(len(limits))
        self._velocities: FloatArray | None = None
        self._before: tuple[FloatArray, FloatArray] | None = None  # inertia and bias

    @property
    def idle(self) -> bool:
        """Return whether all targets and gains are zero."""
        return not (self._dampers.any() or self._aims.any())

    def set_damper(self, number: int, damping: float) -> None:
        """Set the damper of one joint."""
        self._dampers[number] = damping

    def set_target(self, number: int, aim: ServoTarget, *, at_start: bool = False) -> None:
        """Set the target of one joint, whose stiffness can act on the position at the start of a step."""
        idle, self._ahead_s[number] = self.idle, 0.0 if at_start else self._step_s
        self._aims[number] = aim.stiffness, aim.damping, aim.position, aim.velocity, aim.effort
        if self.idle and not idle:  # no efforts from now on, and the last observation becomes invalid
            self.forget()

    def push(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        inertia: FloatArray,
        springs: FloatArray | float = 0.0,
        viscosity: FloatArray | float = 0.0,
        bias: FloatArray | None = None,
        stops: Stops | None = None,
    ) -> FloatArray:
        """Return the servos' efforts in the next step, from the joints' state at its start, shape ``(n,)``.

        Args:
            positions: shape ``(n,)``.
            velocities: shape ``(n,)``.
            inertia: joint-space inertia with a free base, shape ``(n, n)``.
            springs: efforts of springs and muscles in that step, shape ``(n,)`` or a scalar.
            viscosity: damping of these efforts, which fall as velocities rise; shape ``(n, n)`` or 0.
            bias: the efforts with which the joints do not accelerate, shape ``(n,)``; None if unknown.
            stops: returns the efforts of the limits of joints, by positions, velocities, inertia and the
                efforts that accelerate the joints without them; None: the engine has the limits.
        """
        dt = self._step_s
        load: FloatArray = np.zeros(len(positions))
        if self._velocities is not None:
            then, known = (inertia, 0.0) if bias is None or self._before is None else self._before
            load = self._efforts - product(then, velocities - self._velocities) / dt - known
        if bias is not None:
            load, self._before = load + bias, (inertia, bias)
        stiffness, damping, position, velocity, effort = self._aims.T
        wanted = stiffness * position + damping * velocity + effort - stiffness * positions
        damping, dampers = damping + stiffness * self._ahead_s, self._dampers  # backward Euler
        wanted, limits = wanted - damping * velocities, self._limits
        if self._limits_first:
            damping = np.where(abs(wanted) >= limits, 0.0, damping)
            wanted, limits = wanted.clip(-limits, limits), np.full(len(limits), inf)
        stopped: FloatArray | float = 0.0
        moved = inertia + self._motors
        for _ in range(2):
            free = wanted - dampers * velocities + springs - load
            if stops is not None:
                stopped = stops(positions, velocities, moved, free)
                free = free + stopped
            mass = moved + dt * viscosity
            mass.reshape(-1)[:: len(mass) + 1] += dt * (damping + dampers)
            ahead = solve(mass, free[:, None])[:, 0]
            efforts: FloatArray = (wanted - dt * damping * ahead).clip(-limits, limits)
            strained = abs(efforts) == limits
            if not (strained.any() and dampers.any()):
                break
            # dampers act on the motion by the limited effort of a servo, not by the requested one
            wanted, damping = np.where(strained, efforts, wanted), np.where(strained, 0.0, damping)
        self.braking = stopped - dampers * (velocities + dt * ahead) - product(self._motors, ahead)
        if isinstance(viscosity, np.ndarray):
            self.braking -= product(dt * viscosity, ahead)
        self._efforts, self._velocities = efforts + self.braking + springs, velocities
        return efforts

    def forget(self) -> None:
        """Forget the last motion of the joints, because they were moved from outside."""
        self._velocities = self._before = None

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self._efforts, self._velocities, self._before

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._efforts, self._velocities, self._before = saved
