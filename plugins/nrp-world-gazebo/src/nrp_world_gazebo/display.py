"""The display that Gazebo's renderer draws for: one of this system, or one in memory."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from shutil import which

IN_MEMORY = "Xvfb"
"""The program of a display in memory."""
_ON_DISPLAY = """
shown=$1; shift
Xvfb -displayfd 3 -screen 0 64x64x24 -nolisten tcp 3>"$shown" &
while [ ! -s "$shown" ] && kill -0 $! 2>/dev/null; do sleep 0.02; done
DISPLAY=:$(cat "$shown") exec "$@"
"""


def display_for(root: Path | None) -> str:
    """Return what Gazebo can draw for: a display of this system or ``Xvfb``; empty for nothing.

    Args:
        root: the folder of another system in which it runs.
    """
    if root is None:
        return os.environ.get("DISPLAY", "") or (IN_MEMORY if which(IN_MEMORY) else "")
    return IN_MEMORY if (root / "usr/bin" / IN_MEMORY).exists() else ""


def on_display(line: Sequence[str], root: Path | None, folder: Path) -> list[str]:
    """Return a command with a display, in memory unless this system has one.

    Args:
        line: the command.
        root: the folder of another system in which it runs.
        folder: a folder that both systems have.
    """
    if display_for(root) != IN_MEMORY:
        return list(line)
    return ["sh", "-c", _ON_DISPLAY, "sh", str(folder / "display"), *line]
