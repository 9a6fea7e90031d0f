"""Observables of bodies: distance, displacement, height, tilt, speed, contact force, joints."""

from __future__ import annotations

from math import acos, dist, hypot
from typing import Any, ClassVar

from nrp_core.errors import CapabilityError, ExperimentError, did_you_mean
from nrp_core.observables.observable import Observable, Reading, Room, Surroundings, arguments_of
from nrp_core.observables.positions import GroundPoint, Poses, require_poses, target_of
from nrp_core.quantities import length_m


class _OfPositions(Observable):
    """An observable of the pose of a model, which its speed bounds."""

    unit = "m"
    kind: ClassVar[str]

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        require_poses(around.world)
        self._where = around.where
        self._model = around.world.scene.model(str(arguments)).name
        self._models: tuple[str, ...] = (self._model,)
        self.name = f"the {self.kind} of {self._model}"

    def unchanged_ns(self, room: Room) -> int | None:
        return self._where.unchanged_ns(room(self.value(0)), *self._models)


class Distance(_OfPositions):
    """The horizontal distance of a model's origin to a point, a model or the nearest point of a visual, m."""

    kind = "distance"

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        given = arguments_of(arguments, self.kind, "of", "to", needed=["to"])
        super().__init__(given["of"], around)
        to = given["to"]
        place: GroundPoint | str = str(to) if isinstance(to, str) else (length_m(to[0]), length_m(to[1]))
        self._target = target_of(place, around.world.scene)
        if isinstance(place, str):
            self._models += (place.partition("/")[0],)
        self.name = f"the distance of {self._model} to {place}"
        self._known: tuple[Poses, float] | None = None

    def value(self, now_ns: int) -> float:
        where = self._where
        if self._known is None or self._known[0] is not where.poses:
            self._known = where.poses, self._target(where).distance(where.ground(self._model))
        return self._known[1]


class Displacement(_OfPositions):
    """The horizontal distance of a model's origin from its place when it was first read, m."""

    kind = "displacement"

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        given = arguments_of(arguments, self.kind, "of", "from")
        super().__init__(given["of"], around)
        centre = given.get("from")
        self._fixed = None if centre is None else (length_m(centre[0]), length_m(centre[1]))
        self._centre: GroundPoint | None = self._fixed

    def value(self, now_ns: int) -> float:
        x, y = self._where.ground(self._model)
        self._centre = self._centre or (x, y)
        return hypot(x - self._centre[0], y - self._centre[1])

    def unchanged_ns(self, room: Room) -> int | None:
        return None if self._centre is None else super().unchanged_ns(room)

    def save(self) -> Any:
        return self._centre

    def restore(self, saved: Any) -> None:
        self._centre = saved


class Height(_OfPositions):
    """The height of a model's origin, m."""

    kind = "height"

    def value(self, now_ns: int) -> float:
        return self._where.pose(self._model).position[2]


class Tilt(_OfPositions):
    """The angle between a model's z axis and the vertical, rad."""

    unit = "rad"
    kind = "tilt"

    def value(self, now_ns: int) -> float:
        x, y, _, _ = self._where.pose(self._model).orientation
        return acos(min(1.0, max(-1.0, 1 - 2 * (x * x + y * y))))

    def unchanged_ns(self, room: Room) -> int | None:
        return 0


class Speed(Reading):
    """The speed of a model's origin, m/s."""

    unit = "m/s"

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        super().__init__(arguments, around)
        self._engine, self._model = around.world.engine, around.world.scene.model(str(arguments)).name
        self.name = f"the speed of {self._model}"

    def read(self) -> float:
        return hypot(*self._engine.model_motion(self._model).linear)


class Contact(Reading):
    """The sum of the magnitudes of the contact forces on a model, by another model or by any, N."""

    unit = "N"

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        super().__init__(arguments, around)
        given = arguments_of(arguments, "contact", "of", "with")
        if not around.world.capabilities.contacts:
            raise CapabilityError("the world does not report contacts, so no contact force is known")
        scene = around.world.scene
        self._engine, self._model = around.world.engine, scene.model(str(given["of"])).name
        self._others = self._named(given.get("with"), scene)
        self.name = f"the contact force of {self._model}"
        if "with" in given:
            self.name += f" with {' or '.join(sorted(self._others or ()))}"

    @staticmethod
    def _named(others: Any, scene: Any) -> frozenset[str] | None:
        if others is None:
            return None
        listed = others if isinstance(others, (list, tuple)) else [others]
        return frozenset(scene.model(str(one)).name for one in listed)

    def read(self) -> float:
        total = 0.0
        for touch, _ in self._engine.touches():
            models = [body[0] for body in touch.bodies]
            if self._model in models:
                other = models[1] if models[0] == self._model else models[0]
                if self._others is None or other in self._others:
                    total += dist((0.0, 0.0, 0.0), touch.force)
        return total


class Joint(Reading):
    """The position (rad or m), velocity or effort (Nm or N) of a joint."""

    _QUANTITIES = ("position", "velocity", "effort")

    def __init__(self, arguments: Any, around: Surroundings) -> None:
        super().__init__(arguments, around)
        given = arguments_of(arguments, "joint", "name", "of", needed=["name"])
        model, _, joint = str(given["name"]).partition("/")
        self._engine, self._model = around.world.engine, around.world.scene.model(model).name
        self._quantity = str(given.get("of", "position"))
        if self._quantity not in self._QUANTITIES:
            hint = did_you_mean(self._quantity, self._QUANTITIES)
            raise ExperimentError(f"joint: there is no quantity '{self._quantity}'{hint}")
        names = [one.name for one in around.world.scene.model(model).joints if one.kind != "fixed"]
        if joint not in names:
            raise ExperimentError(f"'{model}' has no movable joint '{joint}'{did_you_mean(joint, names)}")
        self._joint = joint
        self.name = f"the {self._quantity} of {model}/{joint}"

    def read(self) -> float:
        states = self._engine.joint_states(self._model)
        values = {"position": states.positions, "velocity": states.velocities, "effort": states.efforts}
        return float(values[self._quantity][states.names.index(self._joint)])
