"""Formats that packages add, by entry points in ``nrp_core.scene_readers``.

An entry point has the name of the root element of the files. It is a function that takes a path and returns
the equivalent SDF and a list of warnings: findings, or texts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from nrp_core.errors import BackendError
from nrp_core.findings import Finding, Findings
from nrp_core.registry import Registry
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element, parse_xml, without_lines

Reader = Callable[[Path], tuple[str, Sequence[Finding | str]]]

READERS: Registry[Reader] = Registry("nrp_core.scene_readers", "scene reader")


def added_formats() -> set[str]:
    """Return the root elements of the formats that installed packages add."""
    return set(READERS.names())


def read_added(root: Element, notes: Notes) -> Element | None:
    """Return the equivalent ``<sdf>`` of a file in another format, None without a reader of its root element.

    Raises:
        SceneError: the file cannot be used, or its reader does not import or exists twice.
    """
    if root.tag not in READERS.names():
        return None
    try:
        read = READERS.load(root.tag)
    except BackendError as error:
        raise root.error(str(error)) from error
    text, warnings = read(root.path)
    for warning in Findings(warnings):
        place = replace(root, path=warning.path or root.path, line=warning.line or root.line)
        notes.warn(place, warning.code, warning.message, subject=warning.subject)
    return without_lines(parse_xml(text.encode(), root.path))
