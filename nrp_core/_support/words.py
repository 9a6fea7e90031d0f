"""Lists in sentences."""

from __future__ import annotations

from collections.abc import Sequence


def first_of(words: Sequence[str], most: int, between: str = ", ") -> str:
    """Return the first words of a list, and how many more there are; empty for an empty list."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return between.join(words[:most]) + more
