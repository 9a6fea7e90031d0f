"""MuJoCo with one fault each: a few per cent, a sign, something forgotten; the named test finds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from nrp_conformance import WorldBackendTests
from nrp_conformance.report import Outcome
from nrp_conformance.run import run_tests
from nrp_world_mujoco.backend import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine as E

from nrp_core.scene.model import Box, Collision, Inertial, Link, Scene
from nrp_core.scene.rigid import BodyVelocity, JointStates, ModelMotion, Pose, ServoTarget, Touch
from nrp_core.world.backend import WorldOptions
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import ImageArray
from nrp_core.world.sensors.camera import Camera

WRONG: dict[str, tuple[str, type[MujocoBackend]]] = {}
ARC, SIDEWAYS = "a_curve_is_exactly_the_commanded_arc", "a_planar_drive_moves_exactly_as_commanded"
SIZE, EDGES = "a_shape_has_its_exact_size", "edges_are_in_the_pixels_of_a_pinhole"
SLOPE = "contacts_report_the_forces_on_a_box_on_a_slope"
SWING, SPEED = "a_position_servo_swings_by_its_gains", "a_velocity_servo_reaches_its_velocity_by_its_gain"
AXES = "inertia_has_its_principal_axes_where_the_file_puts_them"


class _Opens(MujocoBackend):
    """Opens an engine with other methods, in a scene with a change."""

    methods: ClassVar[dict[str, Any]] = {}

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        models = tuple(replace(m, links=tuple(map(self.changed, m.links))) for m in scene.models)
        wrong: Any = type("WrongEngine", (E,), dict(self.methods))
        has = self.capabilities(options)
        engine: Engine = wrong(replace(scene, models=models), seed=seed, capabilities=has, options=options)
        return engine

    @staticmethod
    def changed(link: Link) -> Link:
        return link


def wrong(fault: str, found_by: str, **methods: Any) -> None:
    """Add an engine with other methods."""
    WRONG[fault] = f"test_{found_by}", type("Wrong", (_Opens,), {"methods": methods})


def in_file(fault: str, found_by: str, change: Callable[[Link], Link]) -> None:
    """Add an engine that loads other links than those of the scene."""
    WRONG[fault] = f"test_{found_by}", type("Wrong", (_Opens,), {"changed": staticmethod(change)})


def compiled(fault: str, found_by: str, change: Callable[[E, Any], None]) -> None:
    """Add an engine with another compiled model."""

    def open_it(self: E, scene: Scene, built: Any) -> None:
        E._open(self, scene, built)
        change(self, self._model)

    wrong(fault, found_by, _open=open_it)


def scaled(fault: str, found_by: str, array: str, factor: float) -> None:
    """Add an engine in which an array of the compiled model is scaled."""

    def scale(_: E, model: Any) -> None:
        getattr(model, array)[:] *= factor

    compiled(fault, found_by, scale)


def driven(fault: str, found_by: str, change: Callable[[BodyVelocity], BodyVelocity]) -> None:
    """Add an engine whose drives get other commands."""
    wrong(fault, found_by, _do_set_drive=lambda s, m, d, v: E._do_set_drive(s, m, d, change(v)))


def aimed(fault: str, found_by: str, name: str, factor: float) -> None:
    """Add an engine with a factor on one number of every servo's target."""

    def aim(self: E, model: str, joint: str, aim: ServoTarget) -> None:
        E._do_set_servo_target(self, model, joint, replace(aim, **{name: factor * getattr(aim, name)}))

    wrong(fault, found_by, _do_set_servo_target=aim)


def touched(fault: str, found_by: str, change: Callable[[Touch], Touch]) -> None:
    """Add an engine that reports other contacts."""
    wrong(fault, found_by, _do_touches=lambda s: [change(touch) for touch in E._do_touches(s)])


def seen(fault: str, found_by: str, change: Callable[[ImageArray], ImageArray]) -> None:
    """Add an engine with other images."""
    wrong(fault, found_by, _do_render=lambda s, *path: change(E._do_render(s, *path)).copy())


def moved(fault: str, found_by: str, change: Callable[[E, str, ModelMotion], ModelMotion]) -> None:
    """Add an engine that reports other motions."""
    wrong(
        fault, found_by, read_motion=Engine.read_motion,
        _do_model_motion=lambda s, m: change(s, m, E._do_model_motion(s, m)),
    )  # fmt: skip


def optics(change: Callable[[Camera], Camera]) -> Callable[[Link], Link]:
    def link(each: Link) -> Link:
        sensors = tuple(change(s) if isinstance(s, Camera) else s for s in each.sensors)
        return replace(each, sensors=sensors)

    return link


def inertial(change: Callable[[Inertial], Inertial]) -> Callable[[Link], Link]:
    return lambda link: replace(link, inertial=link.inertial and change(link.inertial))


def slow_when_backing(velocity: BodyVelocity) -> BodyVelocity:
    return replace(velocity, forward=max(velocity.forward, 0.98 * velocity.forward))


def pass_through(engine: E, model: Any) -> None:
    """Let robots collide with everything but robots."""
    driven = {each.name for each in engine.scene.models if each.drives}
    for geom, (owner, _) in enumerate(engine._built.owners):
        if model.geom_contype[geom]:
            model.geom_contype[geom], model.geom_conaffinity[geom] = (2, 1) if owner in driven else (1, 3)


def lighter(_: E, model: Any) -> None:
    model.opt.gravity[:] *= 0.95


def larger(collision: Collision) -> Collision:
    """Return a shape of which boxes are 2 % larger."""
    shape = collision.geometry
    return (
        replace(collision, geometry=Box(tuple(1.02 * s for s in shape.size)))
        if isinstance(shape, Box)
        else collision
    )


def slower(_: E, __: str, motion: ModelMotion) -> ModelMotion:
    x, y, z = motion.linear
    return replace(motion, linear=(0.98 * x, 0.98 * y, 0.98 * z))


def flattened(_: E, __: str, motion: ModelMotion) -> ModelMotion:
    return replace(motion, pose=Pose.from_rpy(motion.pose.position, 0.0, 0.0, motion.pose.yaw))


def grounded(engine: E, name: str, motion: ModelMotion) -> ModelMotion:
    """Leave a robot at the height at which it started."""
    x, y, z = motion.pose.position
    model = engine.scene.model(name)
    height = model.pose.position[2] if model.drives else z
    return replace(motion, pose=replace(motion.pose, position=(x, y, height)))


def commanded(engine: E, name: str, motion: ModelMotion) -> ModelMotion:
    """Report the commanded velocity of a robot."""
    command = next((drive._command for (model, _), drive in engine._drives.items() if model == name), None)
    return replace(motion, linear=motion.pose.rotate((command.forward, 0.0, 0.0))) if command else motion


def straight(touch: Touch) -> Touch:
    """Leave out the friction of a contact."""
    push = np.dot(touch.force, touch.normal)
    x, y, z = (push * np.array(touch.normal)).tolist()
    return replace(touch, force=(x, y, z))


def wrapped(states: JointStates) -> JointStates:
    return replace(states, positions=(states.positions + np.pi) % (2 * np.pi) - np.pi)


def keep_servos(self: E, seed: int) -> None:
    gains, controls = self._model.actuator_biasprm.copy(), self._data.ctrl.copy()
    E._do_reset(self, seed)
    for number in self._built.servos.values():
        self._model.actuator_biasprm[number], self._data.ctrl[number] = gains[number], controls[number]


def forget_velocities(self: E, saved: Any) -> None:
    E._do_restore(self, saved)
    self._data.qvel[:] = 0.0


def show_the_last(self: E, *path: str) -> ImageArray:
    """Return each image one frame late."""
    kept = self.__dict__.setdefault("_kept", {})
    image = E._do_render(self, *path)
    last, kept[path] = kept.get(path, image), image
    return np.array(last)


def joints(fault: str, found_by: str, change: Callable[[E, str, JointStates], JointStates]) -> None:
    """Add an engine that reports other states of joints."""
    wrong(
        fault, found_by, read_joints=Engine.read_joints,
        _do_joint_states=lambda s, m: change(s, m, E._do_joint_states(s, m)),
    )  # fmt: skip


def before(engine: E, model: str, now: Any) -> Any:
    """Return what was reported at the last time."""
    told = engine.__dict__.setdefault("_told", {})
    last_ns, last, shown = told.get(model, (engine.now_ns, now, now))
    if last_ns != engine.now_ns:
        shown = last
    told[model] = engine.now_ns, now, shown
    return shown


def turned_with_the_body(_: E, __: str, motion: ModelMotion) -> ModelMotion:
    return replace(motion, angular=motion.pose.inverse().rotate(motion.angular))


driven("turns 2 % slow", ARC, lambda v: replace(v, turn=0.98 * v.turn))
driven("forward 2 % slow", ARC, lambda v: replace(v, forward=0.98 * v.forward))
driven("backward 2 % slow", ARC, slow_when_backing)
driven("sideways 2 % slow", SIDEWAYS, lambda v: replace(v, left=0.98 * v.left))
driven("fast robots are held back", ARC, lambda v: replace(v, forward=min(1.5, v.forward)))
driven("slow robots stand", ARC, lambda v: v if abs(v.forward) > 0.03 else BodyVelocity())
driven("turns the other way when backing", ARC, lambda v: replace(v, turn=-v.turn) if v.forward < 0 else v)
compiled("robots pass through each other", "robots_do_not_pass_through_each_other", pass_through)
moved("roll and pitch dropped", "a_robot_keeps_its_roll_and_pitch_on_level_ground", flattened)
moved("height of robots dropped", "a_robot_falls_like_everything_else", grounded)
moved("commanded velocity at a wall", "the_velocity_at_a_wall_is_the_real_one", commanded)
moved(
    "turn rates in the frame of the body", "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    turned_with_the_body,
)  # fmt: skip
moved("motions one step late", "a_run_ends_exactly_at_the_requested_time", before)
joints("joints one step late", SWING, before)
joints(
    "velocities of joints have the other sign", "a_joint_is_slowed_by_its_damping",
    lambda _, __, found: replace(found, velocities=-found.velocities),
)  # fmt: skip
joints(
    "efforts of joints have the other sign", "an_effort_accelerates_a_joint",
    lambda _, __, found: replace(found, efforts=-found.efforts),
)  # fmt: skip
moved("velocity 2 % low", "velocities_are_those_of_the_arc", slower)
compiled("gravity 5 % less", "a_body_falls_along_gravity_by_half_g_t_squared", lighter)
scaled("friction 10 % low", "a_sliding_body_is_slowed_by_the_friction_of_its_shape", "geom_friction", 0.9)
scaled("friction ignored", "a_sliding_body_is_slowed_by_the_friction_of_its_shape", "geom_friction", 1e-5)
scaled("joint damping 5 % up", "a_joint_is_slowed_by_its_damping", "dof_damping", 1.05)
scaled("friction of joints ignored", "a_joint_turns_once_its_friction_is_overcome", "dof_frictionloss", 0.0)
scaled("springs 5 % stiff", "a_spring_swings_about_its_equilibrium", "jnt_stiffness", 1.05)
scaled("limits of joints 2 % wide", "a_joint_stops_at_its_limit", "jnt_range", 1.02)
scaled(
    "limits of efforts 5 % high", "a_servo_obeys_the_effort_limit_of_its_joint",
    "actuator_forcerange", 1.05,
)  # fmt: skip
scaled("coupled joints 2 % off", "a_mimic_joint_follows_its_leader", "eq_data", 1.02)
aimed("a servo's velocity has the other sign", SPEED, "velocity", -1.0)
aimed("a servo's velocity 5 % slow", SPEED, "velocity", 0.95)
aimed("a servo's position has the other sign", SWING, "position", -1.0)
aimed("a servo's stiffness 5 % low", SWING, "stiffness", 0.95)
aimed("a servo's damping 5 % low", SWING, "damping", 0.95)
wrong(
    "efforts on joints 2 % low", "an_effort_on_a_joint_accelerates_it_by_effort_over_inertia",
    _do_set_joint_effort=lambda s, m, j, effort: E._do_set_joint_effort(s, m, j, 0.98 * effort),
)  # fmt: skip
in_file("shapes 2 % large", SIZE, lambda link: replace(link, collisions=tuple(map(larger, link.collisions))))
in_file(
    "only the first shape of a link", "a_link_stands_on_any_of_its_shapes",
    lambda link: replace(link, collisions=link.collisions[:1]),
)  # fmt: skip
in_file(
    "only the first visual of a link", "every_visual_of_a_link_is_rendered",
    lambda link: replace(link, visuals=link.visuals[:1]),
)  # fmt: skip
wrong(
    "angles of joints wrapped", "a_joint_without_limits_counts_its_turns",
    _do_joint_states=lambda s, m: wrapped(E._do_joint_states(s, m)),
)  # fmt: skip
in_file("inertia 5 % up", AXES, inertial(lambda i: replace(i, inertia=tuple(1.05 * m for m in i.inertia))))
in_file(
    "products of inertia dropped",
    AXES,
    inertial(lambda i: replace(i, inertia=(*i.inertia[:3], 0.0, 0.0, 0.0))),
)
in_file("axes of inertia not turned", AXES, inertial(lambda i: replace(i, pose=Pose(i.pose.position))))
in_file("field of view 2 % wide", EDGES, optics(lambda c: replace(c, horizontal_fov=1.02 * c.horizontal_fov)))
in_file(
    "field of view 2 % narrow", EDGES, optics(lambda c: replace(c, horizontal_fov=0.98 * c.horizontal_fov))
)
in_file("camera 2 cm high", EDGES, optics(lambda c: replace(c, pose=Pose((0.0, 0.0, 0.02)) @ c.pose)))
seen("camera one pixel aside", EDGES, lambda image: np.roll(image, 1, axis=1))
seen("camera one pixel down", EDGES, lambda image: np.roll(image, 1, axis=0))
seen("camera mirrored", "left_is_left", lambda image: image[:, ::-1])
wrong("camera one frame late", "an_image_shows_the_moment_of_its_stamp", _do_render=show_the_last)
touched(
    "forces of contacts have the other sign", SLOPE, lambda t: replace(t, force=tuple(-f for f in t.force))
)
touched("forces of contacts 5 % low", SLOPE, lambda t: replace(t, force=tuple(0.95 * f for f in t.force)))
touched("contacts without friction", SLOPE, straight)
touched("depth of contacts has the other sign", SLOPE, lambda t: replace(t, depth=-t.depth))
wrong("snapshot forgets velocities", "a_snapshot_keeps_everything_that_moves", _do_restore=forget_velocities)
wrong("reset keeps targets of servos", "a_reset_ends_forces_and_targets", _do_reset=keep_servos)


def pulling(fault: str, found_by: str, row: int, factor: float) -> None:
    """Add an engine that scales one of the states of muscles."""

    def states(self: E, model: str, muscles: Any) -> Any:
        found = E._do_actuator_states(self, model, muscles)
        found[row] *= factor
        return found

    wrong(fault, found_by, _do_actuator_states=states)


def keep_controls(self: E, seed: int) -> None:
    controls = self._data.ctrl.copy()
    E._do_reset(self, seed)
    self._data.ctrl[:] = controls


CURVES = "a_muscle_reports_its_state_by_its_curves"
pulling("velocities of muscles have the other sign", CURVES, 1, -1.0)
pulling("tensions of muscles 2 % high", CURVES, 2, 1.02)
pulling("tensions of muscles are negative", CURVES, 2, -1.0)
scaled("muscles pull half as far from the joint", "a_muscle_pulls_its_limb_with_its_tension", "site_pos", 0.5)
scaled(
    "muscles are activated fast", "an_activation_follows_its_control_by_its_time_constants",
    "actuator_dynprm", 0.8,
)  # fmt: skip
wrong("reset keeps controls of muscles", "a_reset_ends_activations_and_controls", _do_reset=keep_controls)


def failing(backend: type[MujocoBackend], test: str) -> bool:
    """Return whether a test of the kit, which MuJoCo passes, fails for a backend."""
    tests = type("Wrong", (WorldBackendTests,), {"make_backend": classmethod(lambda cls: backend())})
    results = run_tests(tests, only=[test], traceback="native")
    assert results
    assert {result.outcome for result in results} <= {Outcome.PASSED, Outcome.FAILED}
    return any(result.outcome is Outcome.FAILED for result in results)


@pytest.mark.one_of(8)
@pytest.mark.parametrize("fault", WRONG)
def test_a_wrong_dynamic_world_is_found(fault: str) -> None:
    found_by, backend = WRONG[fault]
    assert failing(backend, found_by)
