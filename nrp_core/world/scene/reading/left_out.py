"""Read files of which not everything can be used: the least that holds what is wrong is left out, and named.

For files that people have and run as they are; an error is the better answer for those that they write.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias, TypeVar

from nrp_core.errors import SceneError
from nrp_core.world.scene.reading.xml import Element

Places: TypeAlias = Mapping[tuple[Path, int], int]
"""By file and line, how many elements there are left out, the innermost first."""
Read = TypeVar("Read")

_PARTS = frozenset(
    {"include", "model", "light", "actor", "plugin", "sensor", "visual", "collision", "joint", "link",
     "controller", "material", "inertial", "state", "physics", "scene", "gazebo", "transmission", "limit",
     "dynamics", "surface", "texture", "frame"}
)  # fmt: skip
_MOST = 300


def read_without(read: Callable[[Places], Read]) -> tuple[Read, list[str]]:
    """Return what a file holds, and what was left out of it for what reason, ``file:line: reason``.

    Args:
        read: reads the file without what stands at some places.

    Raises:
        SceneError: what is wrong is no part that can be left out.
    """
    without: Counter[tuple[Path, int]] = Counter()
    reasons: list[str] = []
    last: SceneError | None = None
    while True:
        try:
            return read(without), reasons
        except SceneError as error:
            if error.path is None or error.line is None or len(reasons) >= _MOST:
                raise last or error from None
            last = error
            without[error.path, error.line] += 1
            reasons.append(f"{error}: left out")


def leave_out(root: Element, without: Places) -> None:
    """Take out of a file what stands at some places."""
    for (path, line), count in without.items():
        if path != root.path:
            continue
        for _ in range(count):
            holder, part = _innermost(root, line)
            if holder is None:
                raise SceneError(f"{path}:{line}: no element around this line can be left out")
            holder.children = [child for child in holder.children if child is not part]


def _innermost(holder: Element, line: int) -> tuple[Element | None, Element | None]:
    """Return the innermost part around a line, with the element that it stands in."""
    around = [child for child in reversed(holder.children) if child.line <= line <= child.end_line]
    for within in sorted(around, key=lambda child: child.line != line):
        found = _innermost(within, line)
        if found[1] is not None:
            return found
        if within.tag in _PARTS:
            return holder, within
    return None, None
