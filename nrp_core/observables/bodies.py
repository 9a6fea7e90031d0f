"""Observables of bodies: distance, displacement, height, tilt, speed, contact force, joints."""

from __future__ import annotations

from math import acos, dist, hypot, sqrt
from operator import attrgetter
from typing import Any, ClassVar, Literal

from nrp_core.errors import CapabilityError, ExperimentError, did_you_mean
from nrp_core.observables.observable import Observable, Reading, Room, Surroundings
from nrp_core.observables.positions import Footprint, Poses, require_poses, target_of
from nrp_core.quantities import Point


class OfPositions(Observable):
    """An observable of the pose of a model, which its speed bounds.

    Attributes:
        model: the name of the model.
    """

    unit = "m"
    kind: ClassVar[str]
    _is_known = True

    def __init__(self, around: Surroundings, of: str) -> None:
        require_poses(around.world)
        self._where = around.where
        self.model = around.world.scene.model(of).name
        self._models: tuple[str, ...] = (self.model,)
        self.name = f"the {self.kind} of {self.model}"

    def unchanged_ns(self, room: Room) -> int | None:
        return self._where.unchanged_ns(room(self.value(0)), *self._models) if self._is_known else None

    def distance_to(self) -> Footprint | None:
        """Return the fixed footprint whose distance is the value; None: it is another value, or not yet."""
        return None


class Distance(OfPositions):
    """The horizontal distance of a model's origin to a point, a model or the nearest point of a visual, m."""

    kind = "distance"

    def __init__(self, around: Surroundings, of: str, to: str | Point) -> None:
        super().__init__(around, of)
        self._target = target_of(to, around.world.scene)
        if isinstance(to, str):
            self._models += (to.partition("/")[0],)
        self.name = f"the distance of {self.model} to {to}"
        self._known: tuple[Poses, float] | None = None

    def value(self, now_ns: int) -> float:
        where = self._where
        if self._known is None or self._known[0] is not where.poses:
            self._known = where.poses, self._target(where).distance(where.ground(self.model))
        return self._known[1]

    def distance_to(self) -> Footprint | None:
        moves = any(model in self._where.moving for model in self._models[1:])
        return None if moves else self._target(self._where)


class Displacement(OfPositions):
    """The horizontal distance of a model's origin from its place when it was first read, m."""

    kind = "displacement"

    def __init__(self, around: Surroundings, of: str, from_: Point | None = None) -> None:
        super().__init__(around, of)
        self._centre = from_
        self._is_known = from_ is not None

    def value(self, now_ns: int) -> float:
        x, y, _ = self._where.poses[self.model].position
        if self._centre is None:
            self._centre, self._is_known = (x, y), True
        x, y = x - self._centre[0], y - self._centre[1]
        return sqrt(x * x + y * y)  # as for many copies at once; see distances

    def distance_to(self) -> Footprint | None:
        return None if self._centre is None else Footprint((self._centre,))

    def save(self) -> Any:
        return self._centre

    def restore(self, saved: Any) -> None:
        self._centre, self._is_known = saved, saved is not None


class Height(OfPositions):
    """The height of a model's origin, m."""

    kind = "height"

    def value(self, now_ns: int) -> float:
        return self._where.pose(self.model).position[2]


class Tilt(OfPositions):
    """The angle between a model's z axis and the vertical, rad."""

    unit = "rad"
    kind = "tilt"

    def value(self, now_ns: int) -> float:
        x, y, _, _ = self._where.pose(self.model).orientation
        return acos(min(1.0, max(-1.0, 1 - 2 * (x * x + y * y))))

    def unchanged_ns(self, room: Room) -> int | None:
        return 0


class Speed(Reading):
    """The speed of a model's origin, m/s."""

    unit = "m/s"

    def __init__(self, around: Surroundings, of: str) -> None:
        super().__init__(around)
        self._engine, self._model = around.world.engine, around.world.scene.model(of).name
        self.name = f"the speed of {self._model}"

    def read(self) -> float:
        return hypot(*self._engine.model_motion(self._model).linear)


class Contact(Reading):
    """The sum of the magnitudes of the contact forces on a model, by another model or by any, N."""

    unit = "N"

    def __init__(self, around: Surroundings, of: str, with_: str | tuple[str, ...] | None = None) -> None:
        super().__init__(around)
        if not around.world.capabilities.contacts:
            raise CapabilityError("the world does not report contacts, so no contact force is known")
        scene = around.world.scene
        self._engine, self._model = around.world.engine, scene.model(of).name
        self.name = f"the contact force of {self._model}"
        self._others: frozenset[str] | None = None
        if with_ is not None:
            names = (with_,) if isinstance(with_, str) else with_
            self._others = frozenset(scene.model(one).name for one in names)
            self.name += f" with {' or '.join(sorted(self._others))}"

    def read(self) -> float:
        total = 0.0
        for touch in self._engine.contacts():
            (one, *_), (other, *_) = touch.bodies
            if self._model in (one, other):
                other = one if other == self._model else other
                if self._others is None or other in self._others:
                    total += dist((0.0, 0.0, 0.0), touch.force)
        return total


_UNITS = {
    "position": ("rad", "m"), "velocity": ("rad/s", "m/s"), "effort": ("Nm", "N"),
}  # fmt: skip
"""The units of quantities of joints that turn, and of those that slide."""


class Joint(Reading):
    """The position (rad or m), velocity or effort (Nm or N) of a joint."""

    def __init__(
        self, around: Surroundings, name: str, of: Literal["position", "velocity", "effort"] = "position"
    ) -> None:
        super().__init__(around)
        model, _, joint = name.partition("/")
        self._engine, self._model = around.world.engine, around.world.scene.model(model).name
        kinds = {one.name: one.kind for one in around.world.scene.model(model).joints if one.kind != "fixed"}
        if joint not in kinds:
            raise ExperimentError(f"'{model}' has no movable joint '{joint}'{did_you_mean(joint, kinds)}")
        self._joint, self._read = joint, attrgetter({"velocity": "velocities"}.get(of, f"{of}s"))
        self.name, self.unit = f"the {of} of {name}", _UNITS[of][kinds[joint] == "prismatic"]

    def read(self) -> float:
        states = self._engine.joint_states(self._model)
        return float(self._read(states)[states.names.index(self._joint)])
