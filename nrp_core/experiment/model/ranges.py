"""Ranges of settings that are drawn with each seed, because a finding must not depend on the exact value."""

from __future__ import annotations

import re
from dataclasses import dataclass

from nrp_core.seeds import Seeds

_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_RANGE = re.compile(rf"(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER})\s*(?P<unit>[^\d\s].*)?")


@dataclass(frozen=True, slots=True)
class Range:
    """The range from which a setting is drawn, uniformly.

    Args:
        low, high: the ends.
        unit: their unit; may be empty.
    """

    low: float
    high: float
    unit: str

    @classmethod
    def parse(cls, value: object) -> Range:
        """Read ``4..8 s``; a range is returned as it is.

        Raises:
            ValueError: it has another form, or its end is not above its beginning.
        """
        if isinstance(value, cls):
            return value
        found = _RANGE.fullmatch(str(value).strip())
        if found is None:
            raise ValueError(f"a range is written LOW..HIGH UNIT, as 4..8 s, not '{value}'")
        low, high = float(found["low"]), float(found["high"])
        if not low < high:
            raise ValueError(f"{low:g}..{high:g} is not a range: its end must be above its beginning")
        return cls(low, high, (found["unit"] or "").strip())

    def __str__(self) -> str:
        return f"{self.low:g}..{self.high:g} {self.unit}".strip()

    def override(self, key: str, seed: int) -> str:
        """Return the setting ``key`` for a seed, the same on every backend, in thousandths of the range."""
        drawn = Seeds(seed).child("vary").stream(key).integers(0, 1000, endpoint=True) / 1000
        return f"{key}={self.low + drawn * (self.high - self.low):.9g} {self.unit}".strip()


def keyed_range(text: str) -> tuple[str, Range]:
    """Read ``events.go.at=4..8 s``: a dotted key, as in an override, and its range.

    Raises:
        ValueError: it has another form.
    """
    key, equals, value = text.partition("=")
    if not (equals and key.strip()):
        raise ValueError(f"a range is written KEY=LOW..HIGH UNIT, as events.go.at=4..8 s, not '{text}'")
    return key.strip(), Range.parse(value)
