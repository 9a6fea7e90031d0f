"""Muscles of a scene in MuJoCo, and the states of actuators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final
from xml.sax.saxutils import escape

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import CapabilityError
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.muscles import LEAST_CONTROL, MUJOCO_RANGE, Muscle, muscles_of
from nrp_world_mujoco.library import mujoco

_PARAMETERS = 10
"""The size of MuJoCo's arrays of parameters."""


def add_muscles(
    scene: Scene,
    links: Mapping[str, Mapping[str, tuple[Any, Pose]]],
    spec: Any,
    actuators: Mapping[tuple[str, str], Any],
) -> Mapping[tuple[str, str], Any]:
    """Add the muscles of a scene to a specification, except those that their file has as elements of MuJoCo.

    Args:
        scene: the scene.
        links: the body of each link, and the pose of the link in it, by model.
        spec: the specification.
        actuators: the actuators that are elements of MuJoCo, by model and name.

    Returns:
        All actuators by model and name.

    Raises:
        CapabilityError: a muscle needs an element of MuJoCo and is none.
    """
    found = dict(actuators)
    for model in scene.models:
        for muscle in muscles_of(model):
            if (model.name, muscle.name) in found:
                continue
            if muscle.wraps or muscle.native:
                raise CapabilityError(
                    f"MuJoCo cannot simulate the muscle '{muscle.name}' of '{model.name}': it wraps or is an "
                    "element of its file, which is of another program"
                )
            found[model.name, muscle.name] = _add(model, muscle, links[model.name], spec)
    return found


def _add(model: Model, muscle: Muscle, links: Mapping[str, tuple[Any, Pose]], spec: Any) -> Any:
    path = f"{model.name}/{muscle.name}"
    tendon = spec.add_tendon(name=f"{path}/muscle")
    for number, point in enumerate(muscle.path):
        fixed = (spec.worldbody, model.pose)
        body, place = fixed if point.link == WORLD else links[point.link]
        site = body.add_site(name=f"{path}/point_{number}", pos=(place @ Pose(point.position)).position)
        tendon.wrap_site(site.name)
    low, high = muscle.length_range
    shape = [muscle.force, 1.0, muscle.lmin, muscle.lmax, muscle.vmax, muscle.fpmax, muscle.fvmax]
    times = [muscle.activation_s, muscle.deactivation_s, muscle.smoothing]
    parameters = _padded([*MUJOCO_RANGE, *shape])
    return spec.add_actuator(
        name=f"{path}/actuator",
        target=tendon.name,
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        dyntype=mujoco.mjtDyn.mjDYN_MUSCLE,
        gaintype=mujoco.mjtGain.mjGAIN_MUSCLE,
        biastype=mujoco.mjtBias.mjBIAS_MUSCLE,
        dynprm=_padded(times),
        gainprm=parameters,
        biasprm=parameters,
        lengthrange=[low, high],
    )


def _padded(numbers: Sequence[float]) -> list[float]:
    return [*numbers, *[0.0] * (_PARAMETERS - len(numbers))]


def muscle_elements(m: Any, number: int, points: Sequence[Mapping[str, str]]) -> str:
    """Return the elements in the plugin of a muscle of an MJCF file; empty if an actuator is another one.

    Args:
        m: the compiled model.
        number: the number of the actuator.
        points: ``link`` and ``pos`` of the sites on its path.
    """
    output = m.actuator_outadr[number]
    gear, prm = float(m.actuator_gear[output, 0]), m.actuator_gainprm[number]
    low, high, force, scale, lmin, lmax, vmax, fpmax, fvmax = prm[:9].tolist()
    short, long = (m.actuator_lengthrange[output] / gear).tolist() if gear else (0.0, 0.0)
    force = gear * (force if force >= 0 else scale / max(float(m.actuator_acc0[output]), mujoco.mjMINVAL))
    kinds = m.actuator_dyntype[number], m.actuator_gaintype[number]
    if (
        kinds != (mujoco.mjtDyn.mjDYN_MUSCLE, mujoco.mjtGain.mjGAIN_MUSCLE)
        or not (short < long and low < high and force > 0 and 0 <= lmin < 1 < lmax and vmax > 0)
        or fvmax < 1
        or fpmax <= 0
    ):
        return ""
    rise, fall, smooth = m.actuator_dynprm[number][:3].tolist()
    optimal = (long - short) / (high - low)
    wraps = len(points) < 2 or not _is_straight(m, number)
    values = {"force": force, "optimal_length": optimal, "slack_length": short - low * optimal, "lmin": lmin,
              "lmax": lmax, "vmax": vmax, "fpmax": fpmax, "fvmax": fvmax, "activation_time": rise,
              "deactivation_time": fall, "smoothing": smooth}  # fmt: skip
    path = "".join(
        f"<point><link>{escape(point['link'])}</link><xyz>{point['pos']}</xyz></point>" for point in points
    )
    numbers = "".join(f"<{tag}>{value:.17g}</{tag}>" for tag, value in values.items())
    flags = {"wrapping": wraps, "native": _is_native(m, number)}
    return path + numbers + "".join(f"<{tag}>true</{tag}>" for tag, value in flags.items() if value)


def _is_straight(m: Any, number: int) -> bool:
    """Return whether a muscle pulls along straight lines."""
    if mujoco.mjtTrn(m.actuator_trntype[number]) != mujoco.mjtTrn.mjTRN_TENDON:
        return False
    tendon = int(m.actuator_trnid[number][0])
    path = slice(m.tendon_adr[tendon], m.tendon_adr[tendon] + m.tendon_num[tendon])
    return bool((m.wrap_type[path] == mujoco.mjtWrap.mjWRAP_SITE).all())


def _is_native(m: Any, number: int) -> bool:
    """Return whether a muscle, its tendon or a joint that it moves has properties that only MuJoCo simulates.

    Such a property is a passive force that is absent, or has another curve than the active one.
    """
    passive, curve = m.actuator_biastype[number], m.actuator_biasprm[number][:9]
    control = int(m.actuator_ctrladr[number])
    low, high = m.actuator_ctrlrange[control].tolist() if m.actuator_ctrllimited[control] else (0.0, 1.0)
    own = [m.actuator_forcelimited, m.actuator_actlimited, m.actuator_actearly, m.actuator_damping]
    found = [each[number] for each in own]
    found.append(m.jnt_actfrclimited[moved_joints(m, number)])
    if mujoco.mjtTrn(m.actuator_trntype[number]) == mujoco.mjtTrn.mjTRN_TENDON:
        tendon = int(m.actuator_trnid[number][0])
        limited = (m.tendon_limited, m.tendon_actfrclimited, m.tendon_stiffness, m.tendon_damping,
                   m.tendon_frictionloss, m.tendon_armature)  # fmt: skip
        found += [each[tendon] for each in limited]
    return (
        passive != mujoco.mjtBias.mjBIAS_MUSCLE
        or bool((curve != m.actuator_gainprm[number][:9]).any())
        or low > LEAST_CONTROL
        or high < 1
        or any(np.any(each) for each in found)
    )


def moved_joints(m: Any, number: int) -> list[int]:
    """Return the joints between the parts that an actuator connects."""
    target, kind = int(m.actuator_trnid[number][0]), mujoco.mjtTrn(m.actuator_trntype[number])
    if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
        return [target]
    if kind != mujoco.mjtTrn.mjTRN_TENDON:
        return []
    moved, chains = set[int](), list[set[int]]()
    for step in range(m.tendon_adr[target], m.tendon_adr[target] + m.tendon_num[target]):
        part = int(m.wrap_objid[step])
        match mujoco.mjtWrap(m.wrap_type[step]):
            case mujoco.mjtWrap.mjWRAP_JOINT:
                moved.add(part)
            case mujoco.mjtWrap.mjWRAP_SITE:
                chains.append(_joints_above(m, int(m.site_bodyid[part])))
    shared = set[int].intersection(*chains) if chains else set[int]()
    return sorted(moved.union(*chains) - shared)


def _joints_above(m: Any, body: int) -> set[int]:
    found = set[int]()
    while body:
        found |= {*range(m.body_jntadr[body], m.body_jntadr[body] + m.body_jntnum[body])}
        body = int(m.body_parentid[body])
    return found


class ActuatorGroup:
    """The places of some actuators in the arrays of MuJoCo.

    Args:
        model: the compiled model.
        actuators: their numbers.

    Attributes:
        controls: the places of their controls.
    """

    def __init__(self, model: Any, actuators: Sequence[int]) -> None:
        m, first = model, model.actuator_actadr[actuators]
        self.controls = _places(m.actuator_ctrladr[actuators])
        outputs = m.actuator_outadr[actuators]  # lengths, forces and gears are those of outputs
        gears = m.actuator_gear[outputs, 0]
        self._gears = np.where(gears != 0, gears, 1.0)
        self._outputs, self._active = _places(outputs), _places(np.flatnonzero(first >= 0))
        self._activations = _places((first + m.actuator_actnum[actuators] - 1)[self._active])

    def states(self, data: Any) -> FloatArray:
        """Return lengths, velocities, tensions and activations from MuJoCo's data, shape ``(4, n)``."""
        found = np.zeros((4, len(self._gears)))
        np.divide(data.actuator_length[self._outputs], self._gears, out=found[0])
        np.divide(data.actuator_velocity[self._outputs], self._gears, out=found[1])
        np.multiply(data.actuator_force[self._outputs], -self._gears, out=found[2])
        found[3, self._active] = data.act[self._activations]
        return found


def _places(numbers: IntArray) -> IntArray | slice:
    """Return numbers as a slice if they are consecutive, which is a faster index."""
    first = int(numbers[0]) if len(numbers) else 0
    after = first + len(numbers)
    return slice(first, after) if np.array_equal(numbers, np.arange(first, after)) else numbers


COMPLETE: Final = mujoco.mjtState.mjSTATE_INTEGRATION
"""Everything on which the next step depends."""


class PresentState:
    """Reads actuators and sensors at the present time.

    After a step, MuJoCo's own fields have the lengths, forces and measurements of its start, and the
    activations of its end. So they are computed for the present state in separate data.

    Args:
        model: the compiled model.
    """

    def __init__(self, model: Any) -> None:
        self._now: Any = None
        self._computed = b""
        self._complete = False
        of_contacts = (model.actuator_trntype == mujoco.mjtTrn.mjTRN_BODY).any()
        self._find_positions = mujoco.mj_fwdPosition if of_contacts else _find_lengths

    def states(self, m: Any, state: FloatArray, group: ActuatorGroup) -> FloatArray:
        """Return lengths, velocities, tensions and activations from a complete state, shape ``(4, n)``."""
        return group.states(self._compute(m, state, complete=False))

    def sensor(self, m: Any, state: FloatArray, sensor: int) -> FloatArray:
        """Return the values of a sensor from a complete state."""
        first, now = m.sensor_adr[sensor], self._compute(m, state, complete=True)
        numbers: FloatArray = now.sensordata[first : first + m.sensor_dim[sensor]].copy()
        return numbers

    def _compute(self, m: Any, numbers: FloatArray, *, complete: bool) -> Any:
        """Return data of a state, with accelerations and sensors on request."""
        if self._now is None:  # created on demand: many runs do not need it
            self._now = mujoco.MjData(m)
        now, state = self._now, numbers.tobytes() + m.actuator_biasprm.tobytes()  # copies differ in gains
        if (self._complete or not complete) and state == self._computed:
            return now
        mujoco.mj_setState(m, now, numbers, COMPLETE)
        if complete:
            mujoco.mj_forward(m, now)
        else:
            self._find_positions(m, now)
            mujoco.mj_fwdVelocity(m, now)
            mujoco.mj_fwdActuation(m, now)
        self._computed, self._complete = state, complete
        return now


def _find_lengths(model: Any, data: Any) -> None:
    """Compute positions as far as lengths and velocities of actuators need them: no inertia, no contacts."""
    mujoco.mj_fwdKinematics(model, data)
    mujoco.mj_transmission(model, data)
