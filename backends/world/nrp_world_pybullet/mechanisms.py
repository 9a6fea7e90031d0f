"""Mechanisms that elements for another engine, such as MJCF's, describe and that PyBullet lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nrp_core.findings import Code, Findings
from nrp_core.scene.model import Model
from nrp_core.scene.origin import Native
from nrp_core.world.engine_kit.mechanisms import is_set, lacking_parts

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
    of = f"'{model.name}'"
    yield from lacking_parts(model, foreign, exact)
    driven = [each.attribute("name") for each in foreign if each.tag == "joint" and is_set(each, "armature")]
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
        ("joint", "range", "the limits of {} ball joints"),
    ):
        if having := sum(each.tag == tag and is_set(each, name) for each in foreign):
            yield name, f"{what.format(having)} of {of}"
    for medium in _MEDIUM:
        if any(each.tag == "option" and is_set(each, medium) for each in foreign):
            yield medium, f"the medium that brakes {of} ({medium})"
    flags = [part for each in foreign if each.tag == "option" for part in each.children if part.tag == "flag"]
    if off := [name for name in _SWITCHES if any(flag.attribute(name) == "disable" for flag in flags)]:
        stated = ", ".join(f'{name}="disable"' for name in off)
        yield off[0], f"the <flag> of the <option> of {of}, which switches off parts of MuJoCo: {stated}"
