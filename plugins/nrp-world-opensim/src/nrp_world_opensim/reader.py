"""A file of OpenSim as SDF: bodies are links, coordinates are joints, actuators have topics for commands.

The engine simulates the file itself. The scene has what the rest of the platform needs: names, the poses of
bodies at the start, shapes to draw, and the topics.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import opensim
from nrp_core.findings import Code, Findings
from nrp_core.utilities import join_with_limit
from nrp_core.world import Pose, Vector

from nrp_world_opensim.geometry import Shapes
from nrp_world_opensim.library import elements, initial_state, open_model, pose_of, triple, upright

ALL = "muscles"
"""The group of all muscles of a model."""
_TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_LEAST = "<mass>1e-12</mass><inertia><ixx>2e-14</ixx><iyy>2e-14</iyy><izz>2e-14</izz></inertia>"
"""Of a body without mass, and of a link between two coordinates of a joint."""


def read_osim(path: Path) -> tuple[str, Findings]:
    """Return the SDF of a file of OpenSim, and warnings.

    Raises:
        SceneError: OpenSim cannot read the file or build its model, or the model has a controller of its own.
    """
    warnings = Findings()
    model = open_model(path)
    state = initial_state(model, path)
    model.realizeVelocity(state)
    shapes = Shapes(path)
    text = "\n".join(_Writer(model, state, shapes).lines(path))
    for why, names in shapes.left_out.items():
        listed = join_with_limit(sorted(set(names)), 3)
        warnings.add(Code.NRP260, f"not drawn, because {why}: {listed}", path=path)
    return text, warnings


@dataclass(frozen=True, slots=True)
class CoordinateAxis:
    """How a coordinate moves the child of its joint at the initial state, in the axes of the file.

    Args:
        kind: ``revolute`` or ``prismatic``.
        axis: the direction, a unit vector.
        place: a point of the axis, m.
        start: the initial value, rad or m.
    """

    name: str
    kind: str
    axis: Vector
    place: Vector
    start: float
    lower: float
    upper: float

    @property
    def back(self) -> Pose:
        """The motion of the child from the start to the value 0."""
        turn = tuple(-self.start * each for each in self.axis)
        if self.kind == "prismatic":
            return Pose((turn[0], turn[1], turn[2]))
        half = np.sin(-self.start / 2) * np.array(self.axis)
        spin = Pose((0.0, 0.0, 0.0), (*half.tolist(), float(np.cos(self.start / 2))))
        return Pose(self.place) @ spin @ Pose(self.place).inverse()


def joint_axes(joint: Any, state: Any, model: Any) -> list[CoordinateAxis]:
    """Return how the coordinates of a joint move its child, found from its velocity for a unit speed of each.

    Args:
        joint: the joint.
        state: the initial state of its model.
        model: the model.
    """
    body, still, axes = joint.getChildFrame().findBaseFrame(), opensim.State(state), []
    still.setU(opensim.Vector(state.getNU(), 0.0))
    for index in range(joint.numCoordinates()):
        coordinate = joint.get_coordinates(index)
        moving = opensim.State(still)
        coordinate.setLocked(moving, False)
        coordinate.setSpeedValue(moving, 1.0)
        model.realizeVelocity(moving)
        velocity = body.getVelocityInGround(moving)
        spin, linear = (np.array(triple(velocity.get(part))) for part in (0, 1))
        origin = np.array(triple(body.getPositionInGround(moving)))
        turns = float(spin @ spin) > 1e-12
        along = spin if turns else linear
        size = float(np.linalg.norm(along))
        along = along / size if size else np.array((0.0, 0.0, 1.0))
        place = origin + np.cross(spin, linear) / (spin @ spin) if turns else origin
        slides = not turns and (size > 0 or coordinate.getMotionType() == opensim.Coordinate.Translational)
        start = float(coordinate.getValue(state))
        axes.append(
            CoordinateAxis(
                coordinate.getName(), "prismatic" if slides else "revolute", _vector(along), _vector(place),
                start, *_limits(coordinate, start, state),
            )
        )  # fmt: skip
    return axes


def _limits(coordinate: Any, start: float, state: Any) -> tuple[float, float]:
    if coordinate.getLocked(state):
        return start, start
    lower, upper = float(coordinate.getRangeMin()), float(coordinate.getRangeMax())
    return (lower, upper) if lower <= start <= upper and lower < upper else (-inf, inf)


class _Writer:
    def __init__(self, model: Any, state: Any, shapes: Shapes) -> None:
        self._model, self._state, self._up = model, state, upright(model)
        self._shapes = shapes.by_frame(model, state)
        self._zero: dict[str, Pose] = {"ground": Pose()}
        """The motion of each body from the start to where all coordinates are 0."""

    def lines(self, path: Path) -> Iterator[str]:
        name = self._model.getName() or path.stem
        yield f'<sdf version="1.6"><world name={quoteattr(name)}>'
        yield f"<gravity>0 0 {-float(np.linalg.norm(triple(self._model.getGravity())))}</gravity>"
        yield f"<model name={quoteattr(name)}>"
        yield f'<link name="ground">{_pose(self._up)}{self._visuals("ground")}</link>'
        yield from _joint_lines("ground_held", "fixed", "world", "ground")
        yield from self._bodies()
        yield from self._commands()
        yield "</model></world></sdf>"

    def _bodies(self) -> Iterator[str]:
        """Yield bodies after those that hold them, as SDF needs them."""
        waiting = list(elements(self._model.getJointSet()))
        while waiting:
            ready = [each for each in waiting if _base(each.getParentFrame()) in self._zero]
            for joint in ready:
                yield from self._held(joint)
            waiting = [each for each in waiting if each not in ready]
            if not ready:
                break

    def _held(self, joint: Any) -> Iterator[str]:
        """Yield a body and the joints of its coordinates; a link without mass is between two of them."""
        parent, body = _base(joint.getParentFrame()), joint.getChildFrame().findBaseFrame()
        child, name = body.getName(), joint.getName()
        motion, held = self._zero[parent], parent
        axes = joint_axes(joint, self._state, self._model)
        for axis in axes:
            at = motion @ Pose(axis.place)
            motion = motion @ axis.back
            last = axis is axes[-1]
            link = child if last else f"{name}/{axis.name}"
            if not last:
                yield f"<link name={quoteattr(link)}>{_pose(self._up @ motion @ Pose(axis.place))}"
                yield f"<inertial>{_LEAST}</inertial></link>"
            yield from _joint_lines(axis.name, axis.kind, held, link, self._up @ at, axis)
            held = link
        if not axes:
            yield from _joint_lines(f"{name}_held", "fixed", held, child)
        self._zero[child] = motion
        place = self._up @ motion @ pose_of(body.getTransformInGround(self._state))
        contents = self._inertial(child) + self._visuals(child)
        yield f"<link name={quoteattr(child)}>{_pose(place)}{contents}</link>"

    def _inertial(self, name: str) -> str:
        body = self._model.getBodySet().get(name)
        moments, products = body.getInertia().getMoments(), body.getInertia().getProducts()
        if body.getMass() < 1e-12 or min(triple(moments)) < 2e-14:
            return f"<inertial>{_LEAST}</inertial>"
        values = (*triple(moments), *triple(products))
        inertia = "".join(f"<{tag}>{value}</{tag}>" for tag, value in zip(_TENSOR, values, strict=True))
        centre = _pose(Pose(triple(body.getMassCenter())))
        return f"<inertial><mass>{body.getMass()}</mass>{centre}<inertia>{inertia}</inertia></inertial>"

    def _visuals(self, frame: str) -> str:
        return "".join(
            f'<visual name="shape_{number}">{_pose(shape.pose)}{shape.text}</visual>'
            for number, shape in enumerate(self._shapes.get(frame, ()))
        )

    def _commands(self) -> Iterator[str]:
        muscles = list(elements(self._model.getMuscles()))
        names = [muscle.getName() for muscle in muscles]
        for muscle in muscles:
            yield _plugin("nrp_muscle", muscle.getName(), self._muscle(muscle))
        for actuator in elements(self._model.getActuators()):
            name, scalar = actuator.getName(), opensim.ScalarActuator.safeDownCast(actuator)
            if name not in names and scalar is not None:
                low, high = scalar.getMinControl(), scalar.getMaxControl()
                limits = f"<lowest>{low}</lowest><highest>{high}</highest>"
                named = f"<actuator>{escape(name)}</actuator><topic>{_word(name)}/cmd</topic>"
                yield _plugin("nrp_actuator", name, named + limits)
        for group, members in _groups(self._model, names):
            listed = "".join(f"<muscle>{escape(member)}</muscle>" for member in members)
            yield _plugin("nrp_muscle_group", group, f"{listed}<topic>{_word(group)}</topic>")

    def _muscle(self, muscle: Any) -> str:
        """Return the elements of a muscle: its lengths are those of fibres, so the tendon has none."""
        points = "".join(
            f"<point><link>{escape(frame)}</link><xyz>{_text(place)}</xyz></point>"
            for frame, place in self._path(muscle)
        )
        force, length = muscle.get_max_isometric_force(), muscle.get_optimal_fiber_length()
        numbers = f"<force>{force}</force><optimal_length>{length}</optimal_length>"
        return f"{points}{numbers}<wrapping>true</wrapping><topic>{_word(muscle.getName())}</topic>"

    def _path(self, muscle: Any) -> Iterator[tuple[str, Vector]]:
        """Yield the points of a path at the start: a body, and the place in its frame."""
        path = muscle.getGeometryPath().getCurrentPath(self._state)
        for index in range(path.getSize()):
            point = path.get(index)
            frame = point.getParentFrame()
            base = frame.findTransformInBaseFrame().shiftFrameStationToBase(point.getLocation(self._state))
            yield _base(frame), triple(base)


def _groups(model: Any, muscles: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Yield the groups of muscles in a file, and that of all muscles."""
    forces, taken = model.getForceSet(), {*muscles, ALL}
    if muscles:
        yield ALL, list(muscles)
    for index in range(forces.getNumGroups()):
        group = forces.getGroup(index)
        found = group.getMembers()
        names = [found.get(number).getName() for number in range(found.getSize())]
        members = [name for name in names if name in muscles]
        if members and group.getName() not in taken:
            taken.add(group.getName())
            yield group.getName(), members


def _base(frame: Any) -> str:
    name: str = frame.findBaseFrame().getName()
    return name


def _joint_lines(
    name: str, kind: str, parent: str, child: str, at: Pose | None = None, axis: CoordinateAxis | None = None
) -> Iterator[str]:
    yield f"<joint name={quoteattr(name)} type={quoteattr(kind)}>"
    yield f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>"
    if axis is not None and at is not None:
        yield _pose(at, "__model__")
        limit = f"<limit><lower>{axis.lower}</lower><upper>{axis.upper}</upper></limit>"
        start = f"<initial_position>{axis.start}</initial_position>"
        yield f"<axis><xyz>{_text(axis.axis)}</xyz>{limit}{start}</axis>"
    yield "</joint>"


def _plugin(file: str, name: str, elements: str) -> str:
    return f"<plugin name={quoteattr(name)} filename={quoteattr(file)}>{elements}</plugin>"


def _word(name: str) -> str:
    """Return a name as a part of a topic."""
    return re.sub(r"\W+", "_", name)


def _pose(pose: Pose, relative_to: str = "") -> str:
    frame = f" relative_to={quoteattr(relative_to)}" if relative_to else ""
    return f'<pose rotation_format="quat_xyzw"{frame}>{_text((*pose.position, *pose.orientation))}</pose>'


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _vector(values: Any) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
