"""Robot and room files as trees of XML."""

from __future__ import annotations

from pathlib import Path

from nrp_core._support import xml as xml_tree
from nrp_core._support.xml import Element
from nrp_core.errors import SceneError

__all__ = ["Element", "parse_xml", "read_xml", "without_lines"]


def read_xml(path: Path) -> Element:
    """Read a file.

    Raises:
        SceneError: it cannot be read, is not well-formed, or has a document type.
    """
    return xml_tree.read_xml(path, SceneError)


def parse_xml(text: bytes, path: Path) -> Element:
    """Parse XML; ``path`` is for messages.

    Raises:
        SceneError: it is not well-formed, or has a document type.
    """
    return xml_tree.parse_xml(text, path, SceneError)


def without_lines(element: Element) -> Element:
    """Return a generated element, with all lines 1 because it is not in a file of the user."""
    element.line = 1
    for child in element.children:
        without_lines(child)
    return element
