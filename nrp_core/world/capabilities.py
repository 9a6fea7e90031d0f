"""Capabilities of world backends."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from nrp_core.findings import Code, Findings
from nrp_core.findings.refusals import immovable, no_drive, no_joint, refusal
from nrp_core.scene.model import Joint, Model, Scene
from nrp_core.simulation import Determinism


@dataclass(frozen=True, slots=True)
class WorldCapabilities:
    """The capabilities of a world backend.

    Args:
        step_ns: its physics step, ns.
        determinism: how far two runs agree.
        renderers: its camera renderers, the preferred one first; empty for no cameras. The core draws with
            ``raster`` and ``realistic``, the engine with others.
        snapshot: its state can be saved and restored.
        releases_gil: it releases the GIL while it steps.
        dynamics: it simulates forces. Otherwise only robots with a drive move, as one rigid body, as
            commanded and until they touch something; a scene with other movable models is refused.
        links: it reports the pose of every link, which lasers, inertial sensors and link states need.
        contacts: it reports contacts.
        joint_control: single joints can be controlled, and forces be applied to bodies.
        joint_wrenches: it reports the force and torque in a joint.
        ball_joints: it has ball joints. Otherwise a scene with one is refused.
        ball_control: ball joints can be led to orientations. Otherwise a scene in which one is, is refused.
        coupled_joints: joints can follow others, as in gearboxes and screws. Otherwise a scene with one is
            refused.
        loops: joints can close loops and tie two models. Otherwise such joints are left out, with a warning.
        own_actuators: it has the actuators and sensors that elements for it in a model's file describe.
            Otherwise a scene with a muscle of such properties is refused.
        muscles: it has muscles along straight lines. Otherwise a scene with one is refused.
        wrapping: it has muscles that wrap around shapes. Otherwise a scene with one is refused.
        changes: models can be moved, added and deleted while it runs.
        real_time: time advances on its own, as on a robot, so the loop must keep up.
        poses: it reports the poses of models.
        slip: the largest share of a commanded velocity that a drive loses to tyres; 0 where drives move their
            robots exactly.
        own_scene: it has its own scene. Then the experiment's scene only names models and their topics and is
            not checked against the engine.
    """

    step_ns: int
    determinism: Determinism = Determinism.MACHINE
    renderers: tuple[str, ...] = ()
    snapshot: bool = False
    releases_gil: bool = False
    dynamics: bool = True
    links: bool = False
    contacts: bool = False
    joint_control: bool = False
    joint_wrenches: bool = False
    ball_joints: bool = False
    ball_control: bool = False
    coupled_joints: bool = False
    loops: bool = False
    own_actuators: bool = False
    muscles: bool = False
    wrapping: bool = False
    changes: bool = False
    real_time: bool = False
    poses: bool = True
    slip: float = 0.0
    own_scene: bool = False

    def lacking_for(self, scene: Scene) -> str:
        """Return the capability that a scene needs and this backend lacks, as a message; '' if none."""
        for model in scene.models if not self.own_scene else ():
            if not (self.dynamics or model.static or model.drives):
                return immovable(model.name)
            for drive in (*model.drives, *scene.drives):
                if lacking := [need for need in drive.needs if not getattr(self, need)]:
                    return no_drive(model.name, drive.name, lacking[0])
            for joint in model.joints if self.dynamics and not model.static else ():
                for need in needs_of(model, joint):
                    if not getattr(self, need):
                        return no_joint(model.name, joint.name, need)
        return ""


def check_scene(scene: Scene, capabilities: WorldCapabilities, engine: object, warnings: Findings) -> None:
    """Check that an engine can simulate a scene, and warn of loops and ties if it leaves them open.

    Raises:
        CapabilityError: the scene needs a capability that the engine does not have.
    """
    if lacking := capabilities.lacking_for(scene):
        raise refusal(engine, lacking)
    if capabilities.loops or capabilities.own_scene or not capabilities.dynamics:
        return
    for model in scene.models:
        for loop in model.loops:
            message = (
                f"the joint '{loop.name}' of '{model.name}' closes a loop, which this engine leaves open"
            )
            warnings.add(Code.NRP260, message, subject=loop.name)
    for tie in scene.ties:
        message = f"the joint '{tie.name}' holds two models together, which this engine leaves apart"
        warnings.add(Code.NRP260, message, subject=tie.name)


def needs_of(model: Model, joint: Joint) -> Iterator[str]:
    """Yield the capabilities that a joint of a model needs in addition to dynamics."""
    if joint.kind == "ball":
        yield "ball_joints"
        if any(controller.joint == joint.name for controller in model.controllers):
            yield "ball_control"
    if joint.mimic is not None:
        yield "coupled_joints"
