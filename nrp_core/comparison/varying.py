"""Settings that are drawn anew with each seed, because a finding must not hang on their exact value."""

from __future__ import annotations

import re
from dataclasses import dataclass

from nrp_core.seeds import Seeds

_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
_RANGE = re.compile(
    rf"(?P<key>[^=]+)=\s*(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER})\s*(?P<unit>[^\d\s].*)?"
)


@dataclass(frozen=True, slots=True)
class Varied:
    """A setting and the range that it is drawn from, uniformly.

    Args:
        key: dotted, as in an override.
        low, high: the ends.
        unit: of both; may be empty.
    """

    key: str
    low: float
    high: float
    unit: str

    @classmethod
    def parse(cls, text: str) -> Varied:
        """Read ``events.go.at=4..8 s``.

        Raises:
            ValueError: it is written otherwise, or its end is not above its beginning.
        """
        found = _RANGE.fullmatch(text.strip())
        if found is None:
            raise ValueError(f"a range is written KEY=LOW..HIGH UNIT, as events.go.at=4..8 s, not '{text}'")
        low, high = float(found["low"]), float(found["high"])
        if not low < high:
            raise ValueError(f"{low:g}..{high:g} is no range: its end must be above its beginning")
        return cls(found["key"].strip(), low, high, (found["unit"] or "").strip())

    def __str__(self) -> str:
        return f"{self.key}={self.low:g}..{self.high:g} {self.unit}".strip()

    def override(self, seed: int) -> str:
        """Return the setting for a seed, the same on every backend, in thousandths of the range."""
        drawn = Seeds(seed).child("vary").stream(self.key).integers(0, 1000, endpoint=True) / 1000
        return f"{self.key}={self.low + drawn * (self.high - self.low):.9g} {self.unit}".strip()
