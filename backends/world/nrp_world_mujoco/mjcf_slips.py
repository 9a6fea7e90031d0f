"""Values of an MJCF file that MuJoCo accepts and that contradict the unit of angles of the file."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Final

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Findings
from nrp_core.world.scene.reading.xml import Element

_TURNS_RAD: Final = 4 * pi
"""Two turns: an orientation needs half of one."""
_FULL_RAD: Final = 6.3
"""A full turn as files round it."""
_RIGHT_ANGLES_RAD: Final = (pi / 4, pi / 2, pi, 3 * pi / 2)
_ROUNDED: Final = 2e-3
_RANGES: Final = ("range", "forcerange", "ctrlrange", "actuatorfrcrange")
_HINGED: Final = ("", "hinge")


def warn_of_slips(root: Element, warnings: Findings) -> None:
    """Warn of angles in the other unit, and of ranges whose ends are exchanged.

    Args:
        root: the root of an MJCF file; the files that it includes are not looked at.
        warnings: receives the findings.
    """
    elements = list(_all(root))
    units = [one.attributes.get("angle") for one in elements if one.tag == "compiler"]
    in_degrees = "radian" not in units
    for element in elements:
        for message in (*_orientation(element, in_degrees), *_exchanged(element)):
            warnings.add(Code.NRP298, message, path=element.path, line=element.line)
    if in_degrees:
        _warn_of_limits(elements, warnings)


def _all(element: Element) -> Iterator[Element]:
    yield element
    for child in element.children:
        yield from _all(child)


def _numbers(element: Element, attribute: str) -> tuple[float, ...]:
    """Return the numbers of an attribute; none if it is missing, or refused by MuJoCo."""
    text = element.attributes.get(attribute, "")
    try:
        return element.parse_numbers(text, len(text.split())) if text.strip() else ()
    except SceneError:
        return ()


def _named(element: Element) -> str:
    name = element.attributes.get("name")
    return f"<{element.tag}>" + (f" '{name}'" if name else "")


def _orientation(element: Element, in_degrees: bool) -> Iterator[str]:
    given = _numbers(element, "euler")
    owner = f"the euler of the {_named(element)} is {element.attributes.get('euler')}"
    if not in_degrees and any(abs(angle) > _TURNS_RAD for angle in given):
        yield f"{owner} rad, more than two turns; is it meant in degrees?"
    elif in_degrees and any(
        abs(abs(angle) - right) < _ROUNDED for angle in given for right in _RIGHT_ANGLES_RAD
    ):
        yield f'{owner} degrees; is it meant in radians? Then the file needs <compiler angle="radian"/>'


def _exchanged(element: Element) -> Iterator[str]:
    for name in _RANGES:
        ends = _numbers(element, name)
        if len(ends) == 2 and ends[0] > ends[1]:
            yield f"the {name} of the {_named(element)} begins at {ends[0]:g} and ends at {ends[1]:g}"


def _warn_of_limits(elements: list[Element], warnings: Findings) -> None:
    """Warn if no hinge of a file in degrees moves by more than a full turn in radians."""
    hinges = [one for one in elements if one.tag == "joint" and one.attributes.get("type", "") in _HINGED]
    limited = [(one, ends) for one in hinges if (ends := _numbers(one, "range")) and any(ends)]
    if limited and all(abs(end) <= _FULL_RAD for _, ends in limited for end in ends):
        first, ends = limited[0]
        message = (
            f"the {_named(first)} has a range of {' to '.join(f'{end:g}' for end in ends)} degrees, and no "
            f"joint of the file one of more than {_FULL_RAD:g}; are they radians? Then it needs "
            '<compiler angle="radian"/>'
        )
        warnings.add(Code.NRP298, message, path=first.path, line=first.line)
