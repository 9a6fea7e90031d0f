"""Create elements of SDF from attributes of URDF."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from nrp_core.findings import Code
from nrp_core.scene.reading.context import Element, Notes

_QUATERNION: Final = "quat_xyzw"
_LISTS: Final = ("xyz", "rpy", _QUATERNION, "size", "scale", "rgba", "normal")
_COMMA: Final = re.compile(r",(?=\s)")
"""A comma between two numbers; one within a number, as in "0,5", stays an error."""


def new(tag: str, at: Element, *children: Element, text: str = "", **attributes: str) -> Element:
    """Create an element with the line of another one."""
    return Element(tag, attributes, at.path, at.line, list(children), text, kind=at.kind)


def numbers(element: Element, attribute: str, default: str) -> str:
    """Return three numbers of an attribute, checked."""
    text = element.attributes.get(attribute, default)
    element.parse_numbers(text, 3)
    return text


def read_commas_as_spaces(element: Element, notes: Notes) -> None:
    """Replace commas between the numbers of an attribute, which PyBullet accepts and ROS does not."""
    for name in _LISTS:
        text = element.attributes.get(name, "")
        if _COMMA.search(text):
            element.attributes[name] = _COMMA.sub("", text)
            message = f'the commas in {name}="{text}" are read as spaces, as PyBullet does: ROS refuses them'
            notes.warn(element, Code.NRP384, message, subject=name)
    for child in element.children:
        read_commas_as_spaces(child, notes)


def pose(element: Element, **attributes: str) -> Element:
    """Create the ``<pose>`` for an element's ``<origin>``."""
    origin = element.find("origin")
    if origin is None:
        return new("pose", element, **attributes)
    place, turn = numbers(origin, "xyz", "0 0 0"), origin.attributes.get(_QUATERNION)
    if turn is None:
        return new("pose", origin, text=f"{place} {numbers(origin, 'rpy', '0 0 0')}", **attributes)
    if "rpy" in origin.attributes:
        raise origin.error(f"<origin> has both rpy and {_QUATERNION}: it has one rotation")
    return new("pose", origin, text=f"{place} {turn}", rotation_format=_QUATERNION, **attributes)


def from_attributes(element: Element, *names: str) -> Iterator[Element]:
    """Yield an element for each existing attribute."""
    for name in names:
        if name in element.attributes:
            yield new(name, element, text=element.attributes[name])


def for_engine(element: Element, engine: str, **attributes: str) -> Element:
    """Return an element for one engine, in the namespace with which SDF marks it."""
    return replace(element, tag=f"{engine}:{element.tag}", attributes={**element.attributes, **attributes})
