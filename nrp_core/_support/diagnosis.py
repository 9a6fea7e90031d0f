"""What a backend finds when it looks at the machine it is to run on."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One thing about this machine.

    Args:
        subject: what was looked at, e.g. ``OpenGL without a display``.
        present: whether it is there.
        meaning: what follows from that for the user, in one line.
        remedy: one command that would change it, where there is one.
        needed: whether the backend cannot be opened without it.
    """

    subject: str
    present: bool
    meaning: str
    remedy: str = ""
    needed: bool = False
