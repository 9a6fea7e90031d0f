"""The result of a backend's check of this machine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """One property of this machine.

    Args:
        subject: the property, e.g. ``OpenGL without a display``.
        present: whether the machine has it.
        meaning: the consequence for the user, in one line.
        remedy: a command that would change it, if any.
        needed: whether the backend requires it.
    """

    subject: str
    present: bool
    meaning: str
    remedy: str = ""
    needed: bool = False
