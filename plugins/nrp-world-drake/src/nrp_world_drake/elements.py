"""Elements of MJCF in the file of a model: the inertia of motors, and mechanisms that Drake lacks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from nrp_core.world import Code, Findings, Model

_SECTIONS = ("contact", "equality", "tendon")
_NUMBERS = {"gravcomp": "body", "stiffness": "joint", "density": "option", "viscosity": "option"}
"""Attributes that are effects if they are not 0, and the elements that have them."""


def armatures_of(model: Model) -> Mapping[str, float]:
    """Return the inertia of the motors of a model's joints by their names, kg m^2 or kg."""
    elements = [each for each in model.native if each.tag == "joint"]
    found = {each.attribute("name") or "": _number(each.attribute("armature")) for each in elements}
    return {name: inertia for name, inertia in found.items() if inertia > 0}


def report_mechanisms(model: Model, warnings: Findings) -> None:
    """Report the mechanisms of a model that Drake does not have."""
    for subject, what in _lacking(model):
        message = f"Drake does not have {what} of '{model.name}'"
        warnings.add(Code.NRP260, message, subject=subject)


def _lacking(model: Model) -> Iterator[tuple[str, str]]:
    links = {link.name for link in model.links}
    sections = [each for each in model.native if each.tag in _SECTIONS]
    pairs = [(section.tag, part) for section in sections for part in section.children]
    # in no engine but MuJoCo links of one model touch each other, so that nothing has to exclude them
    counts = Counter(
        (section, part.tag)
        for section, part in pairs
        if part.tag != "exclude" or not {part.attribute("body1"), part.attribute("body2")} <= links
    )
    for (section, tag), count in counts.items():
        yield tag, f"the {count} <{tag}> in <{section}>"
    for name, tag in _NUMBERS.items():
        if count := sum(each.tag == tag and _number(each.attribute(name)) != 0 for each in model.native):
            yield name, f"the {name} of {count} <{tag}>"
    shapes = [shape for link in model.links for shape in link.collisions]
    if count := sum(bool(shape.torsion or shape.rolling) for shape in shapes):
        yield "torsional", f"the torsional and rolling friction of {count} collisions"
    if any(each.tag == "contact" and each.attribute("self") == "true" for each in sections):
        yield "contact", "the contacts between parts"


def _number(text: str | None) -> float:
    """Return the number in an attribute, 0 for none; MuJoCo reports what is not a number."""
    try:
        return float(text or 0)
    except ValueError:
        return 0.0
