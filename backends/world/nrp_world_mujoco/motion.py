"""Poses and velocities of models, and states of their joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.rigid import (
    JointStates,
    LinkMotions,
    ModelMotion,
    Pose,
    Vector,
    rotate_vector,
    rotation_vector,
)
from nrp_core.world.engine_kit.jointed import MotionOf
from nrp_world_mujoco.library import mujoco


def motion_of(
    body: Body, ident: int, held: Pose, engine: Any, state: Any, refresh: Callable[[], Any]
) -> MotionOf:
    """Return the reader of the motion of a frame fixed to a body.

    Args:
        body: the body, which moves.
        ident: its id.
        held: pose of the frame in the body's frame.
        engine: the compiled model.
        state: the state.
        refresh: returns MuJoCo's data with the present positions and velocities of bodies.
    """
    if not body.floats:
        return _Jointed(engine, ident, held, refresh)
    floating = Floating(engine, state, ident)
    return floating if held == Pose() else lambda: floating().at(held)


class Floating:
    """A base that floats freely: its frame is the model's.

    Attributes:
        position, velocity: its parts of MuJoCo's state, shapes ``(7,)`` and ``(6,)``.
        places: the indices of its pose in MuJoCo's positions: x, y, z, and the orientation x, y, z, w.
        rates: the indices of its velocity in MuJoCo's velocities.
    """

    def __init__(self, engine: Any, state: Any, ident: int) -> None:
        joint = engine.body_jntadr[ident]
        position, velocity = engine.jnt_qposadr[joint], engine.jnt_dofadr[joint]
        self.places = position + np.array([0, 1, 2, 4, 5, 6, 3])
        self.rates = velocity + np.arange(6)
        self.position = state.qpos[position : position + 7]
        self.velocity = state.qvel[velocity : velocity + 6]

    def pose(self) -> Pose:
        """Return the pose."""
        x, y, z, qw, qx, qy, qz = self.position.tolist()
        return Pose((x, y, z), (qx, qy, qz, qw))

    def __call__(self) -> ModelMotion:
        pose = self.pose()
        vx, vy, vz, wx, wy, wz = self.velocity.tolist()
        return ModelMotion(pose, (vx, vy, vz), pose.rotate((wx, wy, wz)))  # MuJoCo's is in the body's frame

    def read(self, row: FloatArray) -> None:
        """Write the same as numbers, shape ``(13,)``, without a :class:`ModelMotion`."""
        x, y, z, qw, qx, qy, qz = self.position.tolist()
        vx, vy, vz, wx, wy, wz = self.velocity.tolist()
        row[:] = (x, y, z, qx, qy, qz, qw, vx, vy, vz, *rotate_vector(qx, qy, qz, qw, (wx, wy, wz)))

    def put(self, motion: ModelMotion) -> None:
        """Set pose and velocity of the base."""
        self.position[:3] = motion.pose.position
        x, y, z, w = motion.pose.orientation
        self.position[3:] = w, x, y, z
        self.velocity[:3] = motion.linear
        self.velocity[3:] = motion.pose.rotate_back(motion.angular)

    def change_velocity(self, by: Callable[[Vector, Vector], Vector]) -> None:
        """Change the velocity of the base at its present pose.

        Args:
            by: takes its velocity along and its angular velocity about its own axes, and returns the changes
                of the forward, leftward and turning velocity.
        """
        self.velocity[:] = _changed(self.position.tolist(), self.velocity.tolist(), by)


def change_velocities(bases: Sequence[Floating], by: Callable[[Vector, Vector], Vector]) -> None:
    """Change the velocities of several bases; see :meth:`Floating.change_velocity`, here of arrays."""
    positions = np.array([base.position for base in bases])
    velocities = np.array([base.velocity for base in bases])
    changed = np.array(_changed(positions.T, velocities.T, by)).T
    for base, velocity in zip(bases, changed, strict=True):
        base.velocity[:] = velocity


def _changed(position: Any, velocity: Any, by: Callable[[Vector, Vector], Vector]) -> tuple[Any, ...]:
    _, _, _, qw, qx, qy, qz = position
    vx, vy, vz, wx, wy, wz = velocity
    forward, left, turn = by(rotate_vector(-qx, -qy, -qz, qw, (vx, vy, vz)), (wx, wy, wz))
    x, y, z = rotate_vector(qx, qy, qz, qw, (forward, left, 0.0))
    return vx + x, vy + y, vz + z, wx, wy, wz + turn


class _Jointed:
    """A frame fixed to a body that is held by a joint.

    Attributes:
        ident: the id of the body.
        held: the pose of the frame in that of the body.
    """

    def __init__(self, engine: Any, ident: int, held: Pose, refresh: Callable[[], Any]) -> None:
        self._engine, self.ident, self.held, self._refresh = engine, ident, held, refresh
        self._velocity = np.empty(6)

    def __call__(self) -> ModelMotion:
        data = self._refresh()
        x, y, z = data.xpos[self.ident].tolist()
        qw, qx, qy, qz = data.xquat[self.ident].tolist()
        body = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(self._engine, data, body, self.ident, self._velocity, 0)
        wx, wy, wz, vx, vy, vz = self._velocity.tolist()
        here = ModelMotion(Pose((x, y, z), (qx, qy, qz, qw)), (vx, vy, vz), (wx, wy, wz))
        return here.at(self.held)


class LinkReader:
    """Reads several frames at once, with the same results as their own readers.

    Args:
        frames: the readers of the frames.
        engine: the compiled model.
        refresh: updates the positions and velocities of bodies, and returns MuJoCo's data.
    """

    def __init__(self, frames: Sequence[MotionOf], engine: Any, refresh: Callable[[], Any]) -> None:
        self._engine, self._refresh = engine, refresh
        jointed = [(row, one) for row, one in enumerate(frames) if isinstance(one, _Jointed)]
        self._rows, self._ids = [row for row, _ in jointed], [one.ident for _, one in jointed]
        self._held = LinkMotions.of([ModelMotion(one.held) for _, one in jointed])
        self._others = [(row, one) for row, one in enumerate(frames) if not isinstance(one, _Jointed)]
        self._rates = np.empty((len(jointed), 6))
        self._each = list(zip(self._ids, self._rates, strict=True))
        self._n = len(frames)

    def __call__(self) -> LinkMotions:
        """Return the motions."""
        motions = LinkMotions(np.empty((self._n, 3)), np.empty((self._n, 4)), np.empty((self._n, 2, 3)))
        if self._rows:
            for whole, part in zip(motions, self._jointed(self._refresh()), strict=True):
                whole[self._rows] = part
        for row, one in self._others:
            motion = one()
            motions.positions[row], motions.orientations[row] = motion.pose.position, motion.pose.orientation
            motions.velocities[row] = motion.linear, motion.angular
        return motions

    def _jointed(self, data: Any) -> LinkMotions:
        for ident, rates in self._each:
            mujoco.mj_objectVelocity(self._engine, data, mujoco.mjtObj.mjOBJ_XBODY, ident, rates, 0)
        turns, velocities = data.xquat[self._ids][:, [1, 2, 3, 0]], self._rates.reshape(-1, 2, 3)[:, ::-1]
        return LinkMotions(data.xpos[self._ids], turns, velocities).at(self._held)


class JointReader:
    """Reads the movable joints of one model.

    Args:
        engine: the compiled model.
        state: the state.
        joints: the degree of freedom of each coordinate, in the order of the file.
    """

    def __init__(self, engine: Any, state: Any, joints: dict[str, int]) -> None:
        dofs = np.array(list(joints.values()), dtype=int)
        ids = engine.dof_jntid[dofs]
        self._names = tuple(joints)
        self._qpos, self._qvel = state.qpos, state.qvel
        self._forces = state.qfrc_actuator, state.qfrc_applied
        self._positions: IntArray = engine.jnt_qposadr[ids].astype(int)
        self._velocities = dofs
        of_balls = engine.jnt_type[ids] == mujoco.mjtJoint.mjJNT_BALL
        self._balls = [(int(first), int(self._positions[first])) for first in np.flatnonzero(of_balls)[::3]]

    @property
    def indices(self) -> IntArray:
        """The index of each coordinate among MuJoCo's positions, if no joint is a ball."""
        return self._positions

    @property
    def has_balls(self) -> bool:
        """Whether a joint is a ball, whose position is computed from four numbers."""
        return bool(self._balls)

    @property
    def places(self) -> tuple[IntArray, IntArray]:
        """Indices of the joints' positions and velocities in the state."""
        rest = [np.arange(place + 1, place + 4) for _, place in self._balls]  # indices of their quaternions
        return np.unique(np.concatenate([self._positions, *rest])), self._velocities

    def states(self) -> JointStates:
        """Return positions, velocities and efforts; the efforts are those of the last physics step."""
        dofs, (of_actuators, applied) = self._velocities, self._forces
        positions = self._qpos.take(self._positions)
        for first, place in self._balls:
            w, x, y, z = self._qpos[place : place + 4].tolist()
            positions[first : first + 3] = rotation_vector((x, y, z, w))
        efforts = of_actuators.take(dofs) + applied.take(dofs)
        return JointStates(self._names, positions, self._qvel.take(dofs), efforts)
