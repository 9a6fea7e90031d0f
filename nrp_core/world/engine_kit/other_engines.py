"""Mechanisms that the elements of a model describe for another engine."""

from __future__ import annotations

from collections import Counter

from nrp_core.findings import Code, Findings
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.origin import Native

_MECHANISMS = ("contact", "equality", "tendon")
"""Sections with mechanisms; actuators report themselves, and settings are meant for one engine alone."""


def report_mechanisms(model: Model, engine: str, namespace: str, warnings: Findings) -> None:
    """Report the mechanisms of a model that only another engine has.

    Args:
        model: the model.
        engine: the name of this engine, for messages.
        namespace: that of the elements for this engine.
        warnings: receives the reports.
    """
    counts = Counter(
        (section.tag, part.tag)
        for section in model.native
        if section.namespace != namespace and section.tag in _MECHANISMS
        for part in section.children
        if not _is_inner_exclude(part)
    )
    for (section, tag), count in counts.items():
        which = f"the <{tag}>" if count == 1 else f"the {count} <{tag}>"
        message = f"{engine} does not have {which} in <{section}> of '{model.name}'"
        warnings.add(Code.NRP345, message, subject=tag)
    foreign = (each for each in model.native if each.namespace != namespace and each.tag == "contact")
    if any(each.attribute("self") == "true" for each in foreign):
        message = f"in {engine} parts of '{model.name}' do not touch each other, as its file says they do"
        warnings.add(Code.NRP345, message, subject="contact")


def _is_inner_exclude(part: Native) -> bool:
    """Return whether a part keeps two links of one model from touching, which they do in no other engine."""
    ends = (part.attribute("body1") or "", part.attribute("body2") or "")
    return part.tag == "exclude" and not any("/" in end for end in ends)
