"""Codes of earlier versions; their numbers are not used again."""

from __future__ import annotations

from typing import Final

REMOVED: Final = {
    "0.3": (
        "NRP220",
        "NRP232",
        "NRP234",
        "NRP236",
        "NRP242",
        "NRP250",
        "NRP251",
        "NRP298",
        "NRP300",
        "NRP304",
        "NRP305",
        "NRP307",
        "NRP309",
        "NRP317",
        "NRP320",
        "NRP323",
        "NRP324",
        "NRP328",
        "NRP331",
        "NRP352",
    ),
}
"""By the version in which they were removed."""


def removed_in(code: str) -> str | None:
    """Return the version in which a code was removed; None if it was not."""
    return next((version for version, codes in REMOVED.items() if code in codes), None)
