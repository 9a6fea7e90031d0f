"""Rotors and wings, as the plugins ``MulticopterMotorModel`` and ``LiftDrag`` of Gazebo Sim describe them."""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, exp, pi
from posixpath import join
from typing import Any, ClassVar

import numpy as np

from nrp_core.errors import TopicError
from nrp_core.messages.base import resolve_name
from nrp_core.messages.std_msgs import Float64MultiArray
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
from nrp_core.world.topics import require_finite
from nrp_medium.element import Flow, Immersed, MediumPart, cross


@dataclass(frozen=True, slots=True)
class Rotor(Immersed):
    """A rotor whose thrust grows with the square of its speed (rad/s), which follows a command with a lag.

    Its links are the rotor and the link that holds it. The drag of the moving rotor is that of P. Martin and
    E. Salaun, The True Role of Accelerometer Feedback in Quadrotor Control, ICRA 2010.

    Args:
        number: its place among the speeds of a command (``std_msgs/Float64MultiArray``).
        direction: 1 if it turns counter-clockwise as seen from above, else -1.
        thrust: N s^2/rad^2.
        moment: torque about its axis for each newton of thrust, m.
        drag: force across its axis for each rad/s and m/s, N s^2/(rad m).
        rolling: torque across its axis likewise, N s^2/rad.
        fastest: the highest speed, rad/s.
        rise_s, fall_s: the time constants of a higher and of a lower speed, s.
        slowdown: the speed of its joint is its own divided by this.
    """

    tag: ClassVar[str] = "rotor"
    servo_fields: ClassVar[tuple[str, ...]] = ("shafts",)

    number: int = 0
    direction: int = 1
    thrust: float = 8.54858e-06
    moment: float = 0.016
    drag: float = 1e-4
    rolling: float = 1e-6
    fastest: float = 838.0
    rise_s: float = 1 / 80
    fall_s: float = 1 / 40
    slowdown: float = 10.0

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Rotor:
        """Read a ``MulticopterMotorModel`` with its units and defaults; only motors commanded by velocity."""
        usual = cls("", "")
        joint = model.joint(plugin.require("jointName"))
        link = model.link(plugin.require("linkName")).name
        plugin.choice("motorType", ("velocity",), "velocity")
        turning = plugin.choice("turningDirection", ("cw", "ccw"), "")
        space = plugin.word("robotNamespace", reading.robot)
        topic = join("/", space, plugin.word("commandSubTopic", "command/motor_speed"))
        number = plugin.find("actuator_number") or plugin.require("motorNumber")
        return cls(
            f"rotor {link}",
            resolve_name(topic, reading.robot),
            (link, joint.parent),
            (joint.name,),
            int(number.numbers(1)[0]),
            1 if turning == "ccw" else -1,
            plugin.number("motorConstant", usual.thrust),
            plugin.number("momentConstant", usual.moment),
            plugin.number("rotorDragCoefficient", usual.drag),
            plugin.number("rollingMomentCoefficient", usual.rolling),
            plugin.positive("maxRotVelocity", usual.fastest),
            plugin.positive("timeConstantUp", usual.rise_s),
            plugin.positive("timeConstantDown", usual.fall_s),
            plugin.positive("rotorVelocitySlowdownSim", usual.slowdown),
        )

    def part(self, model: Model, engine: Engine) -> RotorPart:
        return RotorPart(self, model, engine)


class RotorPart(MediumPart):
    """Runs one :class:`Rotor`; its state is the commanded and the present speed."""

    state: tuple[float, float]

    def __init__(self, rotor: Rotor, model: Model, engine: Engine) -> None:
        super().__init__(rotor, rotor.links, model, engine)
        self._rotor, self.state = rotor, (0.0, 0.0)
        what = f"speeds of the rotors of {model.name}, rad/s"
        self.topics = (TopicInfo(rotor.command_topic, Float64MultiArray, Direction.IN, what=what),)

    def _start(self) -> tuple[float, float]:
        return 0.0, 0.0

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        number, count = self._rotor.number, len(message.data)
        if number >= count:
            raise TopicError(f"'{self._model}' has a rotor {number}, but {topic} received {count} speeds")
        require_finite(topic, [float(speed) for speed in message.data])
        self.state = min(float(message.data[number]), self._rotor.fastest), self.state[1]

    def _push(self, flow: Flow) -> FloatArray:
        rotor, (target, speed) = self._rotor, self.state
        thrust = rotor.thrust * speed * abs(speed)
        across = flow.velocities[0, :3] * (1.0, 1.0, 0.0)
        wrenches = np.zeros((2, 6))
        wrenches[0, :3] = -abs(speed) * rotor.drag * across
        wrenches[0, 2] += thrust
        torque = -abs(speed) * rotor.rolling * across
        torque[2] -= rotor.direction * thrust * rotor.moment
        wrenches[1, 3:] = (
            flow.turns[1].T @ flow.turns[0] @ torque
        )  # the bearing takes no torque along the axis
        lag_s = rotor.rise_s if target > speed else rotor.fall_s
        speed = target + (speed - target) * exp(-self._step_s / lag_s)
        self.state = target, speed
        self._turn(rotor.shafts[0], rotor.direction * speed / rotor.slowdown)
        return wrenches


_SLOWEST = 0.01
"""The speed (m/s) up to which a wing has neither lift nor drag."""


@dataclass(frozen=True, slots=True)
class LiftDrag(Immersed):
    """A wing, whose coefficients are linear in the angle of attack up to the stall and linear beyond.

    The coefficients of lift and drag are multiplied by the square of the cosine of the sweep. A joint of a
    control surface, its only shaft, adds to lift and moment but is not turned here.

    Args:
        lift, drag, moment: slopes before and after the stall, 1/rad.
        stall: the angle of the stall, rad.
        zero: the angle of attack at which the flow comes from ahead, rad.
        area: m^2.
        density: of the medium, kg/m^3.
        centre: of pressure, in the frame of the link, m.
        forward, upward: unit vectors of the chord and of the lift, in the frame of the link; without a
            forward direction there are no forces.
        radial: whether the lift is towards the flow, as on a body of revolution.
        reversible: whether flow from behind acts, too.
        surface: lift and moment for each radian of the control surface.
    """

    tag: ClassVar[str] = "wing"

    lift: tuple[float, float] = (1.0, 0.0)
    drag: tuple[float, float] = (0.01, 1.0)
    moment: tuple[float, float] = (0.0, 0.0)
    stall: float = pi / 2
    zero: float = 0.0
    area: float = 1.0
    density: float = 1.2041
    centre: Vector = (0.0, 0.0, 0.0)
    forward: Vector = (1.0, 0.0, 0.0)
    upward: Vector = (0.0, 0.0, 1.0)
    radial: bool = False
    reversible: bool = False
    surface: tuple[float, float] = (4.0, 0.0)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> LiftDrag:
        """Read a ``LiftDrag``, or a ``LiftDragPlugin`` of Gazebo Classic, with its units and defaults."""
        usual = cls("", "")
        link = model.link(plugin.require("link_name")).name
        joint = plugin.find("control_joint_name")
        centre = plugin.find("cp")
        x, y, z = centre.numbers(3) if centre else usual.centre
        ahead = plugin.find("forward")
        still = ahead is not None and not any(ahead.numbers(3))  # files switch a wing off like this

        def slopes(letter: str, by_default: tuple[float, float]) -> tuple[float, float]:
            first, stalled = by_default
            return plugin.number(f"c{letter}a", first), plugin.number(f"c{letter}a_stall", stalled)

        return cls(
            f"wing {link}",
            "",
            (link,),
            () if joint is None else (model.joint(joint).name,),
            slopes("l", usual.lift),
            slopes("d", usual.drag),
            slopes("m", usual.moment),
            plugin.number("alpha_stall", usual.stall),
            plugin.number("a0", usual.zero),
            plugin.number("area", usual.area),
            plugin.number("air_density", usual.density),
            (x, y, z),
            (0.0, 0.0, 0.0) if still else plugin.direction("forward", usual.forward),
            plugin.direction("upward", usual.upward),
            plugin.flag("radial_symmetry", False),
            plugin.flag("reversible", False),
            (plugin.number("control_joint_rad_to_cl", usual.surface[0]), plugin.number("cm_delta", 0.0)),
        )

    def part(self, model: Model, engine: Engine) -> WingPart:
        return WingPart(self, model, engine)


class WingPart(MediumPart):
    """Runs one :class:`LiftDrag`."""

    def __init__(self, wing: LiftDrag, model: Model, engine: Engine) -> None:
        super().__init__(wing, wing.links, model, engine)
        self._wing = wing
        self._forward, self._upward = np.array(wing.forward), np.array(wing.upward)
        self._centre = np.array(wing.centre)

    def _push(self, flow: Flow) -> FloatArray:
        wing, wrench = self._wing, np.zeros((1, 6))
        velocity = flow.velocities[0, :3] + cross(flow.velocities[0, 3:], self._centre)
        speed = float(np.linalg.norm(velocity))
        if speed <= _SLOWEST or (self._forward @ velocity <= 0 and not wing.reversible):
            return wrench
        upward = self._upward
        if wing.radial:
            upward = _unit(cross(self._forward, cross(self._forward, velocity / speed)))
        along_span = _unit(cross(self._forward, upward))
        sideways = float(along_span @ velocity)
        in_plane = velocity - sideways * along_span
        pressure = 0.5 * wing.density * float(in_plane @ in_plane)
        lift_way = _unit(cross(along_span, in_plane))
        ahead, across = float(lift_way @ self._forward), float(np.clip(lift_way @ upward, -1.0, 1.0))
        attack = wing.zero + (1.0 if ahead >= 0 else -1.0) * (pi / 2 - asin(across))
        attack = (attack + pi / 2) % pi - pi / 2
        straight = 1.0 - min(1.0, (sideways / speed) ** 2)
        lift, drag, moment = (
            straight * _coefficient(attack, wing.stall, slopes, signed=signed)
            for slopes, signed in ((wing.lift, True), (wing.drag, False), (wing.moment, True))
        )
        deflection = self._deflection()
        lift += wing.surface[0] * deflection
        moment += wing.surface[1] * deflection
        force = pressure * wing.area * (lift * lift_way - abs(drag) * _unit(in_plane))
        wrench[0, :3] = force
        wrench[0, 3:] = pressure * wing.area * moment * along_span + cross(self._centre, force)
        return wrench

    def _deflection(self) -> float:
        """Return the position of the control surface, rad."""
        if not self._wing.shafts:
            return 0.0
        states = self._engine.joint_states(self._model)
        return float(states.positions[states.names.index(self._wing.shafts[0])])


def _coefficient(attack: float, stall: float, slopes: tuple[float, float], *, signed: bool) -> float:
    """Return a coefficient; a signed one does not change its sign beyond the stall."""
    if abs(attack) <= stall:
        return slopes[0] * attack
    beyond = slopes[0] * stall + slopes[1] * (abs(attack) - stall)
    size = max(0.0, beyond) if signed else beyond
    return size if attack > 0 else -size


def _unit(vector: FloatArray) -> FloatArray:
    size = float(np.linalg.norm(vector))
    return vector / size if size else vector
