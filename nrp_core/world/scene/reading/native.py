"""Elements for a specific engine."""

from __future__ import annotations

from nrp_core.world.scene.origin import Native
from nrp_core.world.scene.reading.xml import Element

_OF_SDF = ("gz", "ignition", "experimental", "xacro")
"""Namespaces that do not belong to an engine."""


def native_of(element: Element) -> tuple[Native, ...]:
    """Return the children of an element with the namespace of an engine."""
    spaced = [child for child in element.children if ":" in child.tag]
    return tuple(_native(child) for child in spaced if child.tag.partition(":")[0] not in _OF_SDF)


def _native(element: Element) -> Native:
    namespace, _, tag = element.tag.rpartition(":")
    children = tuple(map(_native, element.children))
    attributes = tuple(element.attributes.items())
    return Native(namespace, tag, attributes, element.text, children, element.path, element.line)
