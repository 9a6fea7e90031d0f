"""Formats that packages add, by entry points in ``nrp_core.scene_readers``.

An entry point is named as the root element of the files, and is a function that is given a path and returns
the SDF that the file means and a list of warnings.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element, parse_xml, without_lines

GROUP = "nrp_core.scene_readers"

Reader = Callable[[Path], tuple[str, list[str]]]


def added_formats() -> set[str]:
    """Return the root elements of the formats that installed packages add."""
    return set(entry_points(group=GROUP).names)


def read_added(root: Element, notes: Notes) -> Element | None:
    """Return the ``<sdf>`` that a file of another format means, None where nothing reads its root element.

    Raises:
        SceneError: the file cannot be used, or what would read it does not import.
    """
    for entry in entry_points(group=GROUP, name=root.tag):
        try:
            read: Reader = entry.load()
        except ImportError as error:
            raise root.error(f"what reads <{root.tag}> does not import ({entry.value}): {error}") from None
        text, warnings = read(root.path)
        for warning in warnings:
            notes.warn(root, warning)
        return without_lines(parse_xml(text.encode(), root.path))
    return None
