"""Read files with invalid parts: the smallest element around an error is left out and reported.

This is for existing files that run as they are; for files under development an error is better.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias, TypeVar

from nrp_core.errors import SceneError
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.scene.reading.xml import Element

Places: TypeAlias = Mapping[tuple[Path, int], int]
"""Number of elements to leave out by file and line, the innermost first."""
Read = TypeVar("Read")

_PARTS = frozenset(
    {"include", "model", "light", "actor", "plugin", "sensor", "visual", "collision", "joint", "link",
     "controller", "material", "inertial", "state", "physics", "scene", "gazebo", "transmission", "limit",
     "dynamics", "surface", "texture", "frame"}
)  # fmt: skip
_MOST = 300


def read_without(read: Callable[[Places], Read]) -> tuple[Read, list[Finding]]:
    """Return the contents of a file, and the findings for which elements are left out, each once.

    Args:
        read: reads the file without the elements at some places.

    Raises:
        SceneError: the error is not in an element that can be left out.
    """
    without: Counter[tuple[Path, int]] = Counter()
    reasons: list[Finding] = []
    last: SceneError | None = None
    while True:
        try:
            return read(without), list(
                dict.fromkeys(reasons)
            )  # a line may hold other elements that went first
        except SceneError as error:
            if error.path is None or error.line is None or len(reasons) >= _MOST:
                raise last or error from None
            last = error
            without[error.path, error.line] += 1
            reasons.append(
                Finding(Code.NRP260, f"{error.message}: left out", Level.WARNING, error.path, error.line)
            )


def leave_out(root: Element, without: Places) -> None:
    """Remove the elements at some places from a file."""
    for (path, line), count in without.items():
        if path != root.path:
            continue
        for _ in range(count):
            holder, part = _innermost(root, line)
            if holder is None:
                raise SceneError(f"{path}:{line}: no element around this line can be left out")
            holder.children = [child for child in holder.children if child is not part]


def _innermost(holder: Element, line: int) -> tuple[Element | None, Element | None]:
    """Return the innermost element around a line that can be left out, with its parent."""
    around = [child for child in reversed(holder.children) if child.line <= line <= child.end_line]
    for within in sorted(around, key=lambda child: child.line != line):
        found = _innermost(within, line)
        if found[1] is not None:
            return found
        if within.tag in _PARTS:
            return holder, within
    return None, None
