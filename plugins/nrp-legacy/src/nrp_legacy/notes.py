"""Notes about an experiment of the platform: findings that name the parts which are converted or left out."""

from __future__ import annotations

from typing import Protocol

from nrp_core.findings import Code


class Notes(Protocol):
    """Takes a note."""

    def __call__(self, code: Code, message: str, *, subject: str | None = None) -> object:
        """Take a note.

        Args:
            code: its kind.
            message: the note.
            subject: the thing concerned, if it has a name.
        """


def unnoted(code: Code, message: str, *, subject: str | None = None) -> None:
    """Drop a note, which was taken at an earlier reading."""
