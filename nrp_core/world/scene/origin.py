"""Where models come from, for engines that read files themselves or know more than a scene says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Native:
    """An element with a namespace, such as ``<mujoco:option cone="pyramidal"/>``, as it stands in a file.

    SDF leaves elements with a namespace to those who know it; the core hands them to the engine.

    Args:
        namespace: ``mujoco``.
        tag: ``option``.
        attributes: names and values, in the order of the file.
        text: its own characters, stripped.
        children: the elements in it, of any namespace; that of an element without one is empty.
    """

    namespace: str
    tag: str
    attributes: tuple[tuple[str, str], ...] = ()
    text: str = ""
    children: tuple[Native, ...] = ()


@dataclass(frozen=True, slots=True)
class Source:
    """The element of a file that a model was read from.

    Args:
        file: the file, unpacked if it came in an archive.
        element: the name of its ``<model>`` or ``<robot>``.
        line: of that element.
        without: lines of elements that were left out, since they are wrong and the experiment allows it.
    """

    file: Path
    element: str
    line: int
    without: tuple[int, ...] = ()
