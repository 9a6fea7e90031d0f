"""Thrusters and drag, as the plugins ``Thruster`` and ``Hydrodynamics`` of Gazebo; drag of slender links."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import copysign, sqrt
from typing import Any, ClassVar, Final

import numpy as np

from nrp_core.messages.base import resolve_name
from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.world import (
    Direction,
    Element,
    Engine,
    FloatArray,
    Model,
    ModelParts,
    Reading,
    TopicInfo,
    Vector,
)
from nrp_medium.element import Flow, Immersed, MediumPart, cross, cross_matrix, require_stable


@dataclass(frozen=True, slots=True)
class Thruster(Immersed):
    """A propeller that pushes its link along the axis of its joint.

    Fossen, Guidance and Control of Ocean Vehicles, 1994, section 4.1::

        thrust = density * K * diameter^4 * speed * |speed|
        K = coefficient, or alpha[0] + alpha[1] * (1 - wake) * advance / (speed * diameter)

    Args:
        by_speed: whether its speed (rad/s) is commanded, not its thrust (N); both as ``std_msgs/Float64``.
        axis: of the joint, in the frame of the link.
        state_topic: the absolute topic of the speed if the thrust is commanded, else of the thrust.
        coefficient: K, 0 if ``alpha`` are used.
        alpha, wake: of the propeller's diagram, and the wake fraction.
        diameter: m.
        density: of the fluid, kg/m^3.
        range: lowest and highest command.
        deadband: the thrust below which it stands still, N.
    """

    tag: ClassVar[str] = "thruster"
    servo_fields: ClassVar[tuple[str, ...]] = ("shafts",)

    by_speed: bool = False
    axis: Vector = (0.0, 0.0, 1.0)
    state_topic: str = ""
    coefficient: float = 1.0
    alpha: tuple[float, float] = (1.0, 0.0)
    wake: float = 0.2
    diameter: float = 0.02
    density: float = 1000.0
    range: tuple[float, float] = (-1000.0, 1000.0)
    deadband: float = 0.0

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Thruster:
        """Read a ``Thruster`` with its units and defaults; the gains for its joint are not used."""
        usual = cls("", "")
        joint = model.joint(plugin.require("joint_name"))
        link = next(each for each in model.links if each.name == joint.child)
        plugin.find("velocity_control")  # the joint always follows, whatever controls it
        by_speed, space = plugin.flag("use_angvel_cmd", False), plugin.word("namespace", reading.robot)
        own = plugin.word("topic")
        base = f"/{space}/{own}" if own else f"/model/{space}/joint/{joint.name}"
        command = base if own else f"{base}/{'cmd_vel' if by_speed else 'cmd_thrust'}"
        gives_alpha = bool(plugin.all("alpha_1", "alpha_2")) and plugin.find("thrust_coefficient") is None
        lowest = plugin.number("min_thrust_cmd", usual.range[0])
        highest = plugin.number("max_thrust_cmd", usual.range[1])
        return cls(
            f"thruster {link.name}",
            resolve_name(command, reading.robot),
            (link.name,),
            (joint.name,),
            by_speed,
            (link.pose.inverse() @ joint.pose).rotate(joint.axis),
            resolve_name(f"{base}/{'force' if by_speed else 'ang_vel'}", reading.robot),
            0.0 if gives_alpha else plugin.number("thrust_coefficient", usual.coefficient),
            (plugin.number("alpha_1", usual.alpha[0]), plugin.number("alpha_2", usual.alpha[1])),
            plugin.number("wake_fraction", usual.wake),
            plugin.positive("propeller_diameter", usual.diameter),
            plugin.positive("fluid_density", usual.density),
            (lowest, highest) if lowest <= highest else usual.range,  # as in Gazebo
            plugin.number("deadband", 0.0),
        )

    def part(self, model: Model, engine: Engine) -> ThrusterPart:
        return ThrusterPart(self, model, engine)


class ThrusterPart(MediumPart):
    """Runs one :class:`Thruster`; its state is the command and the other of thrust and speed."""

    state: tuple[float, float]

    def __init__(self, thruster: Thruster, model: Model, engine: Engine) -> None:
        super().__init__(thruster, thruster.links, model, engine)
        self._thruster, self.state, self._axis = thruster, (0.0, 0.0), np.array(thruster.axis)
        command, other = ("speed, rad/s", "thrust, N") if thruster.by_speed else ("thrust, N", "speed, rad/s")
        of = f"of the thruster {model.name}/{thruster.links[0]}"
        self.topics = (
            TopicInfo(thruster.command_topic, Float64, Direction.IN, what=f"{command}, {of}"),
            TopicInfo(thruster.state_topic, Float64, Direction.OUT, what=f"{other}, {of}"),
        )

    def _start(self) -> tuple[float, float]:
        return 0.0, 0.0

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        lowest, highest = self._thruster.range
        self.state = min(max(float(message.data), lowest), highest), self.state[1]

    def read(self, topic: str, now_ns: int) -> Float64:
        return Float64(self.state[1])

    def _push(self, flow: Flow) -> FloatArray:
        thruster, (command, other) = self._thruster, self.state
        advance = float(self._axis @ flow.velocities[0, :3])
        speed = command if thruster.by_speed else other
        size = thruster.density * thruster.diameter**4 * self._coefficient(speed, advance)
        if thruster.by_speed:
            thrust, speed = size * command * abs(command), command
        else:
            thrust, speed = command, copysign(sqrt(abs(command / size)), command * size) if size else 0.0
        if abs(thrust) < thruster.deadband:
            thrust = speed = 0.0
        self.state = command, thrust if thruster.by_speed else speed
        self._turn(thruster.shafts[0], speed)
        wrench = np.zeros((1, 6))
        wrench[0, :3] = thrust * self._axis
        return wrench

    def _coefficient(self, speed: float, advance: float) -> float:
        thruster = self._thruster
        if thruster.coefficient:
            return thruster.coefficient
        first, second = thruster.alpha
        ratio = (1 - thruster.wake) * advance / (speed * thruster.diameter) if speed else 0.0
        return first + second * ratio


_DERIVATIVE: Final = re.compile(r"([xyzkmn])(Dot)?([UVWPQR])(?:(abs)?([UVWPQR]))?")
"""The name of a derivative: of a force or torque, by an acceleration or by one or two velocities."""

Terms = tuple[tuple[int, int, int, float], ...]
"""Quadratic damping: force, velocity, the other velocity, and the coefficient."""
Square = tuple[tuple[float, ...], ...]
"""A matrix of shape ``(6, 6)``."""


@dataclass(frozen=True, slots=True)
class Hydrodynamics(Immersed):
    """Damping and added mass of a body in a fluid that moves.

    Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, chapters 6 and 8::

        W = -A dv/dt - C_A(v) v - D(v) v

    with ``v`` relative to the fluid, whose velocity in the world is commanded (``geometry_msgs/Vector3``).

    Args:
        current: the velocity before the first command, m/s.
        added_mass: A, kg, kg m and kg m^2.
        linear: the constant part of D.
        by_size, by_velocity: the parts of D that grow with the size of a velocity, and with the velocity.
        turns: whether the Coriolis and centripetal forces of the added mass act.
    """

    tag: ClassVar[str] = "hydrodynamics"

    current: Vector = (0.0, 0.0, 0.0)
    added_mass: Square | None = None
    linear: Square = ()
    by_size: Terms = ()
    by_velocity: Terms = ()
    turns: bool = True

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Hydrodynamics:
        """Read a ``Hydrodynamics``: its derivatives are those of SNAME 1950, the negatives of A and D."""
        link = model.link(plugin.require("link_name")).name
        space = plugin.word("namespace")
        plugin.find("water_density")  # which Gazebo does not use either
        added, linear = np.zeros((6, 6)), np.zeros((6, 6))
        terms: dict[str, list[tuple[int, int, int, float]]] = {"abs": [], "": []}
        for child in list(plugin.children):
            if (name := _DERIVATIVE.fullmatch(child.tag)) is None:
                continue
            value = -plugin.number(child.tag, 0.0)
            row, column = "xyzkmn".index(name[1]), "UVWPQR".index(name[3])
            if name[5]:
                terms[name[4] or ""].append((row, column, "UVWPQR".index(name[5]), value))
            else:
                (added if name[2] else linear)[row, column] = value
        flow = plugin.find("default_current")
        x, y, z = flow.numbers(3) if flow else (0.0, 0.0, 0.0)
        acts = bool(added.any())
        return cls(
            f"hydrodynamics {link}",
            resolve_name(f"/model/{space}/ocean_current" if space else "/ocean_current", reading.robot),
            (link,),
            (),
            (x, y, z),
            _rows(added) if not plugin.flag("disable_added_mass", False) and acts else None,
            _rows(linear),
            tuple(terms["abs"]),
            tuple(terms[""]),
            not plugin.flag("disable_coriolis", False),
        )

    def part(self, model: Model, engine: Engine) -> HydrodynamicsPart:
        return HydrodynamicsPart(self, model, engine)


def _rows(matrix: FloatArray) -> Square:
    return tuple(map(tuple, matrix.tolist()))


class HydrodynamicsPart(MediumPart):
    """Runs one :class:`Hydrodynamics`."""

    def __init__(self, water: Hydrodynamics, model: Model, engine: Engine) -> None:
        super().__init__(water, water.links, model, engine)
        self._water, self.current = water, water.current
        self._linear = np.array(water.linear)
        if water.added_mass is not None:
            self.added_mass = np.array([water.added_mass])
            require_stable(self, f"the drive '{water.name}' of '{model.name}'")
        what = "velocity of the water, m/s"  # one for all models, so that they share the topic
        self.topics = (TopicInfo(water.command_topic, Vector3, Direction.IN, what=what),)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self.current = (float(message.x), float(message.y), float(message.z))

    def reset(self) -> None:
        super().reset()
        self.current = self._water.current

    def _damping(self, flow: Flow) -> FloatArray:
        velocity = flow.velocities[0]
        damping = self._linear.copy()
        for row, column, other, value in self._water.by_size:
            damping[row, column] += value * abs(velocity[other])
        for row, column, other, value in self._water.by_velocity:
            damping[row, column] += value * velocity[other]
        return damping[None]

    def _push(self, flow: Flow) -> FloatArray:
        """Return ``-C_A(v) v``: the rates of change of the fluid's momenta in turning axes."""
        wrench = np.zeros((1, 6))
        if self.added_mass is not None and self._water.turns:
            velocity = flow.velocities[0]
            momentum = self.added_mass[0] @ velocity
            wrench[0, :3] = cross(momentum[:3], velocity[3:])
            wrench[0, 3:] = cross(momentum[:3], velocity[:3]) + cross(momentum[3:], velocity[3:])
        return wrench


@dataclass(frozen=True, slots=True)
class Drag(Immersed):
    """Slender links in a viscous fluid or a gel: drag that is linear in the velocity of each point.

    The force on a length is that of resistive-force theory (J. Gray and G. J. Hancock, The Propulsion of
    Sea-Urchin Spermatozoa, 1955): each of its coefficients times the velocity of the length along the link's
    axis, and across it. A link of length L is slowed by L times these, and its turning by L^3 / 12 times the
    one across.

    Args:
        along, across: for each length, N s/m^2.
        lengths: of each link, m, about its centre.
        centres: the middle of each link in its frame, m.
        axes: the axis of each link in its frame.
    """

    tag: ClassVar[str] = "drag"

    along: float = 0.0
    across: float = 0.0
    lengths: tuple[float, ...] = ()
    centres: tuple[Vector, ...] = ()
    axes: tuple[Vector, ...] = ()

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Drag:
        """Read ``<along>``, ``<across>`` and any number of ``<link length="" axis="" centre="">``."""
        links = plugin.all("link")
        if not links:
            raise plugin.error("a <plugin> with the file 'nrp_drag' needs a <link>")

        def numbers(link: Element, name: str, usual: str) -> Vector:
            x, y, z = link.parse_numbers(link.attributes.get(name, usual), 3)
            return x, y, z

        axes = np.array([numbers(each, "axis", "1 0 0") for each in links])
        sizes = np.linalg.norm(axes, axis=1, keepdims=True)
        if not (sizes > 0).all():
            raise plugin.error("the axis of a link must not be 0 0 0")
        return cls(
            plugin.attribute("name"),
            "",
            tuple(model.link(each).name for each in links),
            (),
            plugin.number("along", 0.0),
            plugin.number("across", 0.0),
            tuple(each.parse_numbers(each.attribute("length"), 1)[0] for each in links),
            tuple(numbers(each, "centre", "0 0 0") for each in links),
            tuple(map(tuple, (axes / sizes).tolist())),
        )

    def part(self, model: Model, engine: Engine) -> DragPart:
        return DragPart(self, model, engine)


class DragPart(MediumPart):
    """Runs one :class:`Drag`."""

    def __init__(self, drag: Drag, model: Model, engine: Engine) -> None:
        super().__init__(drag, drag.links, model, engine)
        self._matrices = np.array(
            [
                _slender(drag.along, drag.across, *each)
                for each in zip(drag.lengths, drag.centres, drag.axes, strict=True)
            ]
        )
        self._none = np.zeros((len(drag.links), 6))

    def _push(self, flow: Flow) -> FloatArray:
        return self._none

    def _damping(self, flow: Flow) -> FloatArray:
        return self._matrices


def _slender(along: float, across: float, length: float, centre: Vector, axis: Vector) -> FloatArray:
    """Return the damping of a slender link about its origin."""
    outer = np.outer(axis, axis)
    about = np.zeros((6, 6))
    about[:3, :3] = length * (along * outer + across * (np.eye(3) - outer))
    about[3:, 3:] = length**3 / 12 * across * (np.eye(3) - outer)
    to_centre = np.eye(6)
    to_centre[:3, 3:] = -cross_matrix(centre)  # the velocity of the centre by that of the origin
    whole: FloatArray = to_centre.T @ about @ to_centre
    return whole
