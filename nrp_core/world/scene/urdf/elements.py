"""Elements of SDF, made from what URDF says in attributes."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.world.scene.reading.xml import Element


def new(tag: str, at: Element, *children: Element, text: str = "", **attributes: str) -> Element:
    """Make an element that stands where another one does."""
    return Element(tag, attributes, at.path, at.line, list(children), text, kind=at.kind)


def numbers(element: Element, attribute: str, default: str) -> str:
    """Return three numbers of an attribute, checked."""
    text = element.attributes.get(attribute, default)
    element.parse_numbers(text, 3)
    return text


def pose(element: Element, **attributes: str) -> Element:
    """Make the ``<pose>`` that an element's ``<origin>`` means."""
    origin = element.find("origin")
    if origin is None:
        return new("pose", element, **attributes)
    text = f"{numbers(origin, 'xyz', '0 0 0')} {numbers(origin, 'rpy', '0 0 0')}"
    return new("pose", origin, text=text, **attributes)


def from_attributes(element: Element, *names: str) -> Iterator[Element]:
    """Yield an element for each of the attributes that are there."""
    for name in names:
        if name in element.attributes:
            yield new(name, element, text=element.attributes[name])
