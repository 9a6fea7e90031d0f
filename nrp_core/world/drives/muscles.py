"""Muscles: their data in a scene, and the parts of a world that command them and report their states.

A muscle pulls along a path with the force of MuJoCo's model, a Hill type with a rigid tendon
(https://mujoco.readthedocs.io/en/stable/modeling.html#muscles)::

    L = (length - slack_length) / optimal_length        V = velocity / (optimal_length * vmax)
    tension = force * (FL(L) * FV(V) * activation + FP(L))

A tension is positive where the muscle pulls; a velocity is positive where it lengthens.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import dist
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import TopicError
from nrp_core.findings import Code
from nrp_core.messages.base import Time, resolve_name
from nrp_core.messages.nrp_msgs import MuscleState, MuscleStates
from nrp_core.messages.std_msgs import Float64, Float64MultiArray, Header
from nrp_core.scene.consistency import WORLD, require
from nrp_core.scene.devices import LATER, Rename, set_fields
from nrp_core.scene.model import Joint, Model, Scene
from nrp_core.scene.posture import Posture, start_positions
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.world.drives.drive import Drive
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo, require_finite

ALL = "muscles"
"""The group of all muscles of a model in MJCF."""
MUJOCO_RANGE = (0.75, 1.05)
"""MuJoCo's normalised lengths at the ends of a range of lengths."""
LEAST_CONTROL = 0.01
"""Files have small controls in place of 0."""
_SLENDER = 0.04
"""The radius of a muscle in optimal lengths."""
_TURN = 1e-5
"""Half the change of a position (rad, m) by which a moment arm is measured."""


@dataclass(frozen=True, slots=True)
class ViaPoint:
    """A point of a path: a place (m) in the frame of a link, or in the model's for ``world``."""

    link: str
    position: Vector


@dataclass(frozen=True, slots=True)
class Muscle(Drive):
    """A muscle; its control, from 0 to 1, is commanded (``std_msgs/Float64``).

    Args:
        path: the points that its straight segments connect, from origin to insertion.
        force: the peak force at the optimal length, N.
        optimal_length: of the contractile part, m.
        slack_length: of the tendon, which does not stretch, m.
        lmin, lmax: normalised lengths between which it is active.
        vmax: the shortening velocity without force, optimal lengths per second.
        fpmax: passive force at ``lmax``, a share of the peak force, before the factor of 1.5 there.
        fvmax: force at fast lengthening, a share of the peak force.
        activation_s, deactivation_s: time constants of the activation, s.
        smoothing: width of the transition between the time constants; 0 for none.
        wraps: whether it wraps around shapes: then only engines with ``wrapping`` simulate it, from the
            element with its name in its file.
        state_topic: the absolute topic of its state (``nrp_msgs/MuscleState``).
        native: whether it has properties beyond these: then only engines with ``own_actuators`` simulate it,
            from that element.
    """

    tag: ClassVar[str] = "muscle"

    path: tuple[ViaPoint, ...] = ()
    force: float = 0.0
    optimal_length: float = 1.0
    slack_length: float = 0.0
    lmin: float = 0.5
    lmax: float = 1.6
    vmax: float = 1.5
    fpmax: float = 1.3
    fvmax: float = 1.2
    activation_s: float = 0.01
    deactivation_s: float = 0.04
    smoothing: float = 0.0
    wraps: bool = False
    state_topic: str = ""
    native: bool = field(default=False, metadata=LATER)

    __setstate__ = set_fields

    @property
    def needs(self) -> tuple[str, ...]:
        if self.native:
            return ("own_actuators",)
        return ("wrapping",) if self.wraps else ("muscles",)

    @property
    def length_range(self) -> tuple[float, float]:
        """The lengths at MuJoCo's default normalised lengths of 0.75 and 1.05, m."""
        low, high = (self.slack_length + each * self.optimal_length for each in MUJOCO_RANGE)
        return low, high

    def renamed(self, named: Rename) -> Muscle:
        """Return the same muscle for a model whose parts are renamed."""
        path = tuple(replace(point, link=named(point.link)) for point in self.path)
        return replace(self, name=named(self.name), path=path)

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> Muscle:
        """Read the ``<plugin filename="nrp_muscle">`` of a model.

        Raises:
            SceneError: a point is on no link, the path has fewer than two, or a number is out of range.
        """
        name = plugin.attribute("name")
        topic = plugin.word("topic", name.replace(" ", "_"))
        wraps = plugin.flag("wrapping", default=False)
        path = tuple(_point(point, model) for point in plugin.all("point"))
        if len(path) < 2 and not wraps:
            raise plugin.error(f"the muscle '{name}' has {len(path)} <point>: its path needs at least 2")
        optimal, slack = _lengths(plugin, name)
        numbers = {each: plugin.number(each, getattr(_USUAL, each)) for each in _SHAPE}
        smoothing = plugin.number("smoothing", 0.0)
        if smoothing < 0:
            raise plugin.error(
                f"the <smoothing> of the muscle '{name}' must be at least 0, not {smoothing:g}"
            )
        if not 0 <= numbers["lmin"] < 1 < numbers["lmax"] or numbers["fvmax"] < 1 or numbers["fpmax"] <= 0:
            raise plugin.error(
                f"the muscle '{name}' needs 0 <= lmin < 1 < lmax, fvmax >= 1 and fpmax > 0, not "
                + ", ".join(f"{each} {value:g}" for each, value in numbers.items())
            )
        return cls(
            name,
            resolve_name(f"{topic}/cmd", reading.robot),
            path,
            plugin.positive("force"),
            optimal,
            slack,
            **numbers,
            vmax=plugin.positive("vmax", _USUAL.vmax),
            activation_s=plugin.positive("activation_time", _USUAL.activation_s),
            deactivation_s=plugin.positive("deactivation_time", _USUAL.deactivation_s),
            smoothing=smoothing,
            wraps=wraps,
            state_topic=resolve_name(f"{topic}/state", reading.robot),
            native=plugin.flag("native", default=False),
        )

    def describe(self, model: Model) -> str:
        low, high = (self.slack_length + each * self.optimal_length for each in (self.lmin, self.lmax))
        arms = ", ".join(f"{1e3 * arm:.1f} mm at {joint}" for joint, arm in moment_arms(model, self).items())
        text = f"muscle '{self.name}', {self.force:.4g} N, active from {low:.3g} to {high:.3g} m"
        text += ", wraps" if self.wraps else ""
        return f"{text}, moment arm {arms}" if arms else text

    @property
    def radius(self) -> float:
        """The radius with which it is drawn, m."""
        return _SLENDER * self.optimal_length

    def tube(self, model: Model) -> tuple[list[Vector], float] | None:
        return (path_points(self, start_places(model)), self.radius) if len(self.path) > 1 else None

    def check(self, model: Model) -> None:
        links = [WORLD, *(link.name for link in model.links)]
        for point in self.path:
            require(point.link, links, f"the muscle '{self.name}' of '{model.name}' names the link")

    def part(self, model: Model, engine: Engine) -> MusclePart:
        return MusclePart(self, model.name, engine)


_USUAL = Muscle("", "")
_SHAPE = ("lmin", "lmax", "fpmax", "fvmax")


def _point(point: Element, model: ModelParts) -> ViaPoint:
    link = point.require("link")
    x, y, z = point.require("xyz").numbers(3)
    return ViaPoint(WORLD if link.text == WORLD else model.link(link).name, (x, y, z))


def _lengths(plugin: Element, name: str) -> tuple[float, float]:
    """Return optimal and slack length, which may be given by a range of lengths."""
    given = plugin.find("length_range")
    if given is None:
        return plugin.positive("optimal_length"), plugin.number("slack_length", 0.0)
    low, high = given.numbers(2)
    if not low < high:
        message = f"the <length_range> of the muscle '{name}' goes from {low:g} to {high:g}: it must increase"
        raise given.error(message)
    optimal = (high - low) / (MUJOCO_RANGE[1] - MUJOCO_RANGE[0])
    return optimal, low - MUJOCO_RANGE[0] * optimal


def muscles_of(model: Model) -> tuple[Muscle, ...]:
    """Return the muscles of a model, in the order of its file."""
    return tuple(drive for drive in model.drives if isinstance(drive, Muscle))


def drawn_muscles(scene: Scene) -> list[tuple[Model, list[Muscle]]]:
    """Return the models that have muscles with a path, and these muscles."""
    muscles = [(model, [each for each in muscles_of(model) if len(each.path) > 1]) for model in scene.models]
    return [(model, drawn) for model, drawn in muscles if drawn]


def path_points(muscle: Muscle, places: Mapping[str, Pose]) -> list[Vector]:
    """Return the points of a path, m.

    Args:
        muscle: the muscle.
        places: the poses of the links on its path, and of ``world``.
    """
    return [(places[each.link] @ Pose(each.position)).position for each in muscle.path]


def drawn_paths(
    engine: Engine, drawn: Sequence[tuple[Model, list[Muscle]]]
) -> Iterator[tuple[Muscle, Sequence[Vector], float]]:
    """Yield muscles with the points of their paths now, m, and their activations, 0 to 1.

    Args:
        engine: the engine that moves them.
        drawn: the muscles, as :func:`drawn_muscles` returns them for the current scene.
    """
    for model, muscles in drawn:
        links = {point.link for muscle in muscles for point in muscle.path} - {WORLD}
        places = {link: engine.link_motion(model.name, link).pose for link in links}
        states = engine.actuator_states(model.name, [muscle.name for muscle in muscles])
        for muscle, activation in zip(muscles, states[3].tolist(), strict=True):
            points = engine.muscle_path(model.name, muscle.name)
            yield muscle, points or path_points(muscle, {WORLD: model.pose, **places}), activation


def path_length(muscle: Muscle, places: Mapping[str, Pose]) -> float:
    """Return the length of a path of straight lines, m; the arguments are those of :func:`path_points`."""
    return sum(dist(*pair) for pair in pairwise(path_points(muscle, places)))


def start_places(model: Model, positions: Mapping[str, float] | None = None) -> dict[str, Pose]:
    """Return the poses of the links and of ``world`` in the frame of a model.

    Args:
        model: the model.
        positions: of its joints, rad or m; by default the initial ones.
    """
    posture = Posture(model, start_positions(model) if positions is None else positions)
    return {WORLD: Pose(), **{link.name: posture.of(link.name) @ link.pose for link in model.links}}


def moment_arms(model: Model, muscle: Muscle) -> dict[str, float]:
    """Return the moment arms of a muscle, -d(length)/dq where its model starts, m (of a slider: 1).

    They are positive where it pulls a joint in the positive direction, as in biomechanics; those of MuJoCo
    have the other sign. Ball joints, and joints that do not change its length, are omitted.
    """
    starts = dict(start_positions(model))

    def length(joint: Joint, turn: float) -> float:
        turned = {**starts, joint.name: starts.get(joint.name, 0.0) + turn}
        return path_length(muscle, start_places(model, turned))

    arms = {
        joint.name: (length(joint, -_TURN) - length(joint, _TURN)) / (2 * _TURN)
        for joint in model.joints
        if joint.takes_commands and not muscle.wraps
    }
    return {name: arm for name, arm in arms.items() if abs(arm) > _TURN}


class MusclePart(Part):
    """Commands one muscle and reports its state."""

    def __init__(self, muscle: Muscle, model: str, engine: Engine) -> None:
        self._muscle, self._model, self._engine, self._reported = muscle, model, engine, False
        name = f"the muscle {muscle.name} of {model}"
        self.topics = (
            _command_topic(muscle.command_topic, Float64, f"control of {name}, 0 to 1"),
            TopicInfo(muscle.state_topic, MuscleState, Direction.OUT, what=f"state of {name}"),
        )

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        names, control = (self._muscle.name,), np.array([message.data], float)
        self._reported = command(self._engine, self._model, names, control, topic, self._reported)

    def read(self, topic: str, now_ns: int) -> MuscleState:
        muscle, header = self._muscle, Header(Time.from_ns(now_ns), self._model)
        states = self._engine.actuator_states(self._model, (muscle.name,))
        length, velocity, tension, activation = states[:, 0].tolist()
        normalised = (length - muscle.slack_length) / muscle.optimal_length
        share = tension / muscle.force
        speed = velocity / muscle.optimal_length
        return MuscleState(header, length, velocity, tension, activation, normalised, share, speed)


def _command_topic(name: str, kind: type, what: str, elements: tuple[str, ...] = ()) -> TopicInfo:
    limits = 0.0, 1.0
    return TopicInfo(name, kind, Direction.IN, what=what, limits=limits, elements=elements, clips=True)


def command(
    engine: Engine, model: str, muscles: Sequence[str], controls: FloatArray, topic: str, reported: bool
) -> bool:
    """Set the controls of muscles; return whether one outside 0 to 1, which is clipped, was reported.

    Raises:
        TopicError: a control is not finite.
    """
    if not (controls.min() >= 0.0 and controls.max() <= 1.0):
        require_finite(topic, controls.tolist())
        if not reported:
            n = int(np.argmax((controls < 0.0) | (controls > 1.0)))
            message = (
                f"the muscle '{muscles[n]}' of '{model}' is commanded {controls[n]:g}; it goes from 0 to 1"
            )
            engine.warnings.add(Code.NRP299, message, subject=topic)
        reported = True
    engine.set_controls(model, muscles, controls)
    return reported


@dataclass(frozen=True, slots=True)
class MuscleGroup(Drive):
    """Several muscles with one topic for their controls, and one for their states.

    Args:
        muscles: their names, in the order of the numbers.
        state_topic: the absolute topic of their states (``nrp_msgs/MuscleStates``).
    """

    tag: ClassVar[str] = "muscle_group"

    muscles: tuple[str, ...] = ()
    state_topic: str = ""

    def renamed(self, named: Rename) -> MuscleGroup:
        """Return the same group for a model whose parts are renamed."""
        return replace(self, name=named(self.name), muscles=tuple(map(named, self.muscles)))

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> MuscleGroup:
        """Read the ``<plugin filename="nrp_muscle_group">`` of a model: ``<muscle>`` once for each muscle.

        Raises:
            SceneError: it names no muscle.
        """
        name = plugin.attribute("name")
        names = tuple(each.text for each in plugin.all("muscle"))
        if not names:
            raise plugin.error(f"the group '{name}' names no <muscle>")
        topic = plugin.word("topic", name.replace(" ", "_"))
        command, state = (resolve_name(f"{topic}/{each}", reading.robot) for each in ("cmd", "state"))
        return cls(name, command, names, state)

    def describe(self, model: Model) -> str:
        return f"muscle group '{self.name}': {', '.join(self.muscles)}"

    def check(self, model: Model) -> None:
        names = [muscle.name for muscle in muscles_of(model)]
        for name in self.muscles:
            require(name, names, f"the group '{self.name}' of '{model.name}' names the muscle")

    def part(self, model: Model, engine: Engine) -> MuscleGroupPart:
        return MuscleGroupPart(self, model, engine)


class MuscleGroupPart(Part):
    """Commands the muscles of one group and reports their states."""

    def __init__(self, group: MuscleGroup, model: Model, engine: Engine) -> None:
        self._group, self._model, self._engine, self._reported = group, model.name, engine, False
        known = {muscle.name: muscle for muscle in muscles_of(model)}
        muscles = [known[name] for name in group.muscles]
        numbers = [(each.force, each.optimal_length, each.slack_length) for each in muscles]
        self._force, self._optimal, self._slack = np.array(numbers).T
        names = ", ".join(group.muscles)
        self.topics = (
            _command_topic(
                group.command_topic,
                Float64MultiArray,
                f"controls, 0 to 1, of {names} of {model.name}",
                elements=group.muscles,
            ),
            TopicInfo(
                group.state_topic,
                MuscleStates,
                Direction.OUT,
                what=f"states of {names}",
                elements=group.muscles,
            ),
        )

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        controls = np.asarray(message.data, dtype=float)
        count = len(self._group.muscles)
        if controls.shape != (count,):
            name = self._group.name
            raise TopicError(f"{topic}: '{name}' has {count} muscles; {controls.size} numbers came")
        names = self._group.muscles
        self._reported = command(self._engine, self._model, names, controls, topic, self._reported)

    def read(self, topic: str, now_ns: int) -> MuscleStates:
        states: FloatArray = self._engine.actuator_states(self._model, self._group.muscles)
        normalised = (states[0] - self._slack) / self._optimal
        names, header = list(self._group.muscles), Header(Time.from_ns(now_ns), self._model)
        length, velocity, tension, activation = states
        share, speed = tension / self._force, velocity / self._optimal
        return MuscleStates(header, names, length, velocity, tension, activation, normalised, share, speed)
