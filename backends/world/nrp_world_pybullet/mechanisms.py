"""Mechanisms that elements for another engine, such as MJCF's, describe and that PyBullet lacks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence

from nrp_core.findings import Code, Findings
from nrp_core.scene.model import Model
from nrp_core.scene.origin import Native
from nrp_core.world.drives.muscles import muscles_of
from nrp_core.world.engine_kit.soft_constraints import is_coupling

_MECHANISMS = ("contact", "equality", "tendon")
"""Sections with mechanisms; actuators report themselves, and settings of solvers are meant for one engine."""
_MEDIUM = ("density", "viscosity")
"""What an ``<option>`` says of the medium around a model; both are 0 for none."""
_SWITCHES = ("contact", "spring", "damper", "limit", "gravity")
"""What a ``<flag>`` of an ``<option>`` can switch off for MuJoCo alone."""
_NAMED = 3
"""The number of joints that a report names."""


def report_mechanisms(model: Model, exact: Sequence[str], warnings: Findings) -> None:
    """Report the mechanisms of a model that only another engine has.

    Args:
        model: the model.
        exact: its joints that move as in MuJoCo, with the couplings and the inertia of motors of MJCF.
        warnings: receives the reports.
    """
    foreign = [each for each in model.native if each.namespace != "pybullet"]
    for subject, part in _lacking(model, foreign, exact):
        warnings.add(Code.NRP260, f"PyBullet does not have {part}", subject=subject)
    if any(each.tag == "contact" and each.attribute("self") == "true" for each in foreign):
        message = f"in PyBullet parts of '{model.name}' do not touch each other, as its file says they do"
        warnings.add(Code.NRP260, message, subject="contact")


def _lacking(model: Model, foreign: Sequence[Native], exact: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the parts of a model that elements for another engine describe, each with its subject."""
    of, links = f"'{model.name}'", {link.name for link in model.links}
    pulled = _of_muscles(model, foreign)
    counts = Counter(
        (section.tag, part.tag)
        for section in foreign
        if section.tag in _MECHANISMS
        for part in section.children
        if not _is_inner_exclude(part, links)
        and not (section.tag == "tendon" and part.attribute("name") in pulled)
        and not (section.tag == "equality" and is_coupling(part, exact))
    )
    for (section, tag), count in counts.items():
        which = f"the <{tag}>" if count == 1 else f"the {count} <{tag}>"
        yield tag, f"{which} in <{section}> of {of}"
    driven = [each.attribute("name") for each in foreign if each.tag == "joint" and _has(each, "armature")]
    motors = [name for name in driven if name not in exact]
    if motors:
        joints = ", ".join(f"'{name}'" for name in motors[:_NAMED]) + (
            ", ..." if len(motors) > _NAMED else ""
        )
        yield "armature", f"the inertia of the motors (armature) of {of} at {joints}"
    for tag, name, what in (
        ("body", "gravcomp", "the partial gravcomp of {} bodies"),
        (
            "joint",
            "stiffness",
            "the springs of {} joints, which are ball joints or have springs that are not linear",
        ),
        ("joint", "damping", "the dampers of {} joints that are not linear"),
    ):
        if having := sum(each.tag == tag and _has(each, name) for each in foreign):
            yield name, f"{what.format(having)} of {of}"
    for medium in _MEDIUM:
        if any(each.tag == "option" and _has(each, medium) for each in foreign):
            yield medium, f"the medium that brakes {of} ({medium})"
    flags = [part for each in foreign if each.tag == "option" for part in each.children if part.tag == "flag"]
    if off := [name for name in _SWITCHES if any(flag.attribute(name) == "disable" for flag in flags)]:
        stated = ", ".join(f'{name}="disable"' for name in off)
        yield off[0], f"the <flag> of the <option> of {of}, which switches off parts of MuJoCo: {stated}"


def _of_muscles(model: Model, foreign: Sequence[Native]) -> set[str | None]:
    """Return the tendons that only muscles pull, which PyBullet supports."""
    muscles = {muscle.name for muscle in muscles_of(model)}
    actuators = [each for section in foreign if section.tag == "actuator" for each in section.children]
    others = {each.attribute("tendon") for each in actuators if each.attribute("name") not in muscles}
    return {each.attribute("tendon") for each in actuators} - others - {None}


def _has(element: Native, name: str) -> bool:
    """Return whether an attribute is a number other than 0."""
    try:
        return any(float(number) for number in (element.attribute(name) or "").split())
    except ValueError:  # the engine that it is for reports that
        return False


def _is_inner_exclude(part: Native, links: Collection[str]) -> bool:
    """Return whether a part keeps two links of one model from touching, which they do in no other engine.

    A link of another model has the name of that before it, ``model/link``.
    """
    ends = (part.attribute("body1") or "", part.attribute("body2") or "")
    return part.tag == "exclude" and not any("/" in end for end in ends if end not in links)
