"""Elements of MJCF in the file of a model that are mechanisms which Drake lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nrp_core.world import Code, Findings, Model
from nrp_core.world.engine_kit.mechanisms import is_set, lacking_parts

_NUMBERS = {
    "gravcomp": "body", "stiffness": "joint", "range": "joint", "density": "option", "viscosity": "option",
}  # fmt: skip
"""Attributes that are effects if they are not 0, and the elements that have them."""


def report_mechanisms(model: Model, coupled: Sequence[str], warnings: Findings) -> None:
    """Report the mechanisms of a model that Drake does not have.

    Args:
        model: the model.
        coupled: its joints with the couplings of MJCF.
        warnings: receives the reports.
    """
    for subject, what in _lacking(model, coupled):
        warnings.add(Code.NRP260, f"Drake does not have {what}", subject=subject)


def _lacking(model: Model, coupled: Sequence[str]) -> Iterator[tuple[str, str]]:
    of = f"of '{model.name}'"
    yield from lacking_parts(model, model.native, coupled)
    for name, tag in _NUMBERS.items():
        if count := sum(each.tag == tag and is_set(each, name) for each in model.native):
            yield name, f"the {name} of {count} <{tag}> {of}"
    shapes = [shape for link in model.links for shape in link.collisions]
    if count := sum(bool(shape.torsion or shape.rolling) for shape in shapes):
        yield "torsional", f"the torsional and rolling friction of {count} collisions {of}"
    if any(each.tag == "contact" and each.attribute("self") == "true" for each in model.native):
        yield "contact", f"the contacts between parts {of}"
