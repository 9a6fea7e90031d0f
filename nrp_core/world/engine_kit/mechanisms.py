"""The mechanisms of MJCF that engines other than MuJoCo lack."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence

from nrp_core.scene.model import Model
from nrp_core.scene.origin import Native
from nrp_core.world.drives.muscles import muscles_of
from nrp_core.world.engine_kit.soft_constraints import is_coupling

_SECTIONS = ("contact", "equality", "tendon")
"""Sections with mechanisms; actuators report themselves, and settings of solvers are meant for one engine."""


def lacking_parts(model: Model, foreign: Sequence[Native], exact: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the parts of these sections without an effect, each as its tag and in words.

    Args:
        model: the model.
        foreign: its elements for another engine.
        exact: its joints that move as in MuJoCo, with the couplings of MJCF.
    """
    links, pulled = {link.name for link in model.links}, _of_muscles(model, foreign)
    counts = Counter(
        (section.tag, part.tag)
        for section in foreign
        if section.tag in _SECTIONS
        for part in section.children
        if not _is_inner_exclude(part, links)
        and not (section.tag == "tendon" and part.attribute("name") in pulled)
        and not (section.tag == "equality" and is_coupling(part, exact))
    )
    for (section, tag), count in counts.items():
        which = f"the <{tag}>" if count == 1 else f"the {count} <{tag}>"
        yield tag, f"{which} in <{section}> of '{model.name}'"
    ranges = [each.attribute("actuatorfrcrange") for each in foreign if each.tag == "joint"]
    if uneven := sum(_is_uneven(each.split()) for each in ranges if each):
        what = f"the limits of effort of {uneven} joints of '{model.name}' that differ in the two directions"
        yield "actuatorfrcrange", what


def is_set(element: Native, name: str) -> bool:
    """Return whether an attribute is a number other than 0."""
    try:
        return any(float(number) for number in (element.attribute(name) or "").split())
    except ValueError:  # the engine that it is for reports that
        return False


def _is_uneven(limits: Sequence[str]) -> bool:
    try:
        return sum(map(float, limits)) != 0.0
    except ValueError:  # the engine that it is for reports that
        return False


def _of_muscles(model: Model, foreign: Sequence[Native]) -> set[str | None]:
    """Return the tendons that only muscles pull, which engines support or refuse."""
    muscles = {muscle.name for muscle in muscles_of(model)}
    actuators = [each for section in foreign if section.tag == "actuator" for each in section.children]
    others = {each.attribute("tendon") for each in actuators if each.attribute("name") not in muscles}
    return {each.attribute("tendon") for each in actuators} - others - {None}


def _is_inner_exclude(part: Native, links: Collection[str]) -> bool:
    """Return whether a part keeps two links of one model from touching, which they do in no other engine.

    A link of another model has the name of that before it, ``model/link``.
    """
    ends = (part.attribute("body1") or "", part.attribute("body2") or "")
    return part.tag == "exclude" and not any("/" in end for end in ends if end not in links)
