"""What a world backend has."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_core.simulation import Determinism
from nrp_core.world.scene.model import Joint, Scene


@dataclass(frozen=True, slots=True)
class WorldCapabilities:
    """What a world backend has, asked as questions.

    Args:
        step_ns: what is its physics step?
        determinism: how far do two runs agree?
        renderers: which camera renderers are there, the preferred one first? None: no cameras. The core draws
            with ``raster`` and ``realistic``, the engine with others.
        snapshot: can its state be saved and restored?
        releases_gil: can it step while Python code runs in another thread?
        dynamics: do things fall, push and swing? Otherwise only robots with a drive move, as one rigid body,
            as they are commanded and as far as there is room; a scene with other movable models is refused.
        links: does it tell where every link is? Lasers, inertial sensors and poses of links need it.
        contacts: does it tell what touches what?
        joint_control: can single joints be driven, and bodies pushed by forces?
        joint_wrenches: does it tell the force and torque that a joint carries?
        ball_joints: are there joints that turn about every axis? A scene with one is refused otherwise.
        coupled_joints: can joints follow others, as in gearboxes and screws? Likewise.
        changes: can models be moved, added and deleted while it runs?
        real_time: does time pass by itself, so that the loop must keep up? A robot does not wait.
        poses: does it report where models are?
        own_scene: does it bring its world itself? Then the scene only names models and their topics, and
            nothing in it has to be possible in the engine.
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
    coupled_joints: bool = False
    changes: bool = False
    real_time: bool = False
    poses: bool = True
    own_scene: bool = False

    def lacking_for(self, scene: Scene) -> str:
        """Return the capability that a scene needs and this backend lacks, as a message; '' if none."""
        for model in scene.models if not self.own_scene else ():
            if not (self.dynamics or model.static or model.drives):
                return f"has no dynamics: '{model.name}' would not move; make it static"
            for joint in model.joints if self.dynamics and not model.static else ():
                for need in needs_of(joint):
                    if not getattr(self, need):
                        return f"has no {need.replace('_', ' ')}, such as '{model.name}/{joint.name}'"
        return ""


def needs_of(joint: Joint) -> tuple[str, ...]:
    """Return the capabilities that a joint rests on, beside dynamics."""
    ball = ("ball_joints",) if joint.kind == "ball" else ()
    return ball if joint.mimic is None else (*ball, "coupled_joints")
