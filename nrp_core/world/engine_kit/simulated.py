"""Bodies as every engine simulates them: stable springs, velocity decay, unsupported mechanisms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import expm1

from nrp_core.findings import Code, Findings
from nrp_core.world.engine_kit.planar_servo import without_wheel_friction
from nrp_core.world.rigid import Pose, Vector, Wrench
from nrp_core.world.scene.merged_bodies import Body, bodies_of, joint_inertias
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.origin import Native

STIFF = 0.5
"""``stiffness * step^2 / (inertia + damping * step)`` above which a spring is stiff; engines take dampers at
the end of a step, so that the limit of stability is at least 2."""


def with_steady_springs(bodies: Sequence[Body], step_s: float) -> tuple[Body, ...]:
    """Return bodies whose springs are stable with the step.

    A stiff spring gets ``stiffness * step`` as additional damping, which is backward Euler. One that the
    damper of its joint holds acts as it is.

    Args:
        bodies: the bodies of one model.
        step_s: the physics step.
    """
    inertias = joint_inertias(bodies) if any(body.joint and body.joint.stiffness for body in bodies) else {}
    steady = []
    for body in bodies:
        joint = body.joint
        if joint and joint.stiffness:
            held = inertias.get(joint.name, 0.0) + joint.damping * step_s
            if joint.stiffness * step_s**2 > STIFF * held:
                body = replace(body, joint=replace(joint, damping=joint.damping + joint.stiffness * step_s))
        steady.append(body)
    return tuple(steady)


@dataclass(frozen=True, slots=True)
class Decay:
    """The coefficients of the wrench on a body by which its velocity decays exponentially.

    The wrench is constant in a step, so they take the decay of a whole step into account, and no rate is too
    large for the step.

    Args:
        linear: of its centre of mass, N s/m.
        angular: about its principal axes, N m s/rad.
    """

    linear: float
    angular: Vector

    @classmethod
    def of(cls, body: Body, step_s: float) -> Decay | None:
        """Return the decay of a body; None without one.

        Args:
            body: the body.
            step_s: the physics step.
        """
        if body.inertial is None or not any(body.decay):
            return None
        linear, angular = (-expm1(-rate * step_s) / step_s for rate in body.decay)
        ix, iy, iz = body.inertial.inertia[:3]
        return cls(linear * body.inertial.mass, (angular * ix, angular * iy, angular * iz))

    def wrench(self, axes: Pose, linear: Vector, angular: Vector) -> Wrench:
        """Return the wrench in the next step.

        Args:
            axes: the orientation of the principal axes in the world.
            linear: the velocity of the centre of mass, m/s.
            angular: the angular velocity in the world, rad/s.
        """
        x, y, z = (-self.linear * v for v in linear)
        torque = [-k * w for k, w in zip(self.angular, axes.rotate_back(angular), strict=True)]
        return Wrench((x, y, z), axes.rotate((torque[0], torque[1], torque[2])))


_MECHANISMS = ("contact", "equality", "tendon")
"""Sections with mechanisms; actuators report themselves, and settings of solvers are meant for one engine."""
_MEDIUM = ("density", "viscosity")
"""What an ``<option>`` says of the medium around a model; both are 0 for none."""
_NAMED = 3
"""The number of joints that a report names."""


def report_mechanisms(model: Model, engine: str, namespace: str, warnings: Findings) -> None:
    """Report the mechanisms of a model that only another engine has.

    Args:
        model: the model.
        engine: the name of this engine, for messages.
        namespace: that of the elements for this engine.
        warnings: receives the reports.
    """
    foreign = [each for each in model.native if each.namespace != namespace]
    for subject, part in _lacking(model, foreign):
        warnings.add(Code.NRP260, f"{engine} does not have {part}", subject=subject)
    if any(each.tag == "contact" and each.attribute("self") == "true" for each in foreign):
        message = f"in {engine} parts of '{model.name}' do not touch each other, as its file says they do"
        warnings.add(Code.NRP260, message, subject="contact")


def _lacking(model: Model, foreign: Sequence[Native]) -> Iterator[tuple[str, str]]:
    """Yield the parts of a model that elements for another engine describe, each with its subject."""
    of, links = f"'{model.name}'", {link.name for link in model.links}
    counts = Counter(
        (section.tag, part.tag)
        for section in foreign
        if section.tag in _MECHANISMS
        for part in section.children
        if not _is_inner_exclude(part, links)
    )
    for (section, tag), count in counts.items():
        which = f"the <{tag}>" if count == 1 else f"the {count} <{tag}>"
        yield tag, f"{which} in <{section}> of {of}"
    motors = [each.attribute("name") for each in foreign if each.tag == "joint" and _has(each, "armature")]
    if motors:
        joints = ", ".join(f"'{name}'" for name in motors[:_NAMED]) + (
            ", ..." if len(motors) > _NAMED else ""
        )
        yield "armature", f"the inertia of the motors (armature) of {of} at {joints}"
    for tag, name, what in (
        ("body", "gravcomp", "the partial gravcomp of {} bodies"),
        ("joint", "stiffness", "the springs of {} ball joints"),
    ):
        if having := sum(each.tag == tag and _has(each, name) for each in foreign):
            yield name, f"{what.format(having)} of {of}"
    for medium in _MEDIUM:
        if any(each.tag == "option" and _has(each, medium) for each in foreign):
            yield medium, f"the medium that brakes {of} ({medium})"


def _has(element: Native, name: str) -> bool:
    """Return whether an attribute is a number other than 0."""
    try:
        return float(element.attribute(name) or 0) != 0
    except ValueError:  # the engine that it is for reports that
        return False


def _is_inner_exclude(part: Native, links: Collection[str]) -> bool:
    """Return whether a part keeps two links of one model from touching, which they do in no other engine.

    A link of another model has the name of that before it, ``model/link``.
    """
    ends = (part.attribute("body1") or "", part.attribute("body2") or "")
    return part.tag == "exclude" and not any("/" in end for end in ends if end not in links)


def simulated_bodies(model: Model, step_s: float, physical: bool) -> tuple[Body, ...]:
    """Return the bodies of a model, prepared for an engine.

    Args:
        model: the model.
        step_s: the physics step.
        physical: whether wheels move the robot by friction.
    """
    return with_steady_springs(without_wheel_friction(model, bodies_of(model), physical), step_s)
