"""What a script sets in vain: a value that is set again, or never runs, since nothing runs in between."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray

_Key = tuple[int, str]


class Settings:
    """The settings of parameters since the network last ran.

    An owner is a population or a projection. A setting is overwritten if one later setting changes the values
    of all its cells before anything runs or reads them: a value for all and exceptions for some are right.
    """

    def __init__(self) -> None:
        self._sizes: list[int] = []
        self._last: dict[_Key, IntArray] = {}
        self._since: dict[_Key, str] = {}
        self._had_effect: set[_Key] = set()

    def change(self, owner: Any, name: str, size: int, cells: IntArray, differs: Any) -> bool:
        """Note a setting; return whether it overwrites an earlier one.

        Args:
            owner: what has the parameter, with a label.
            name: the parameter.
            size: number of values that the owner has.
            cells: the indices of those that are set.
            differs: whether each of them differs from its value before.
        """
        key = (id(owner), name)
        self._since[key] = owner.label
        if key not in self._last:
            self._last[key] = np.full(size, -1)
        last = self._last[key]
        before = last[cells]
        overwritten = before[differs & (before >= 0)]
        settings, counts = np.unique(overwritten, return_counts=True)
        sizes = [self._sizes[number] for number in settings.tolist()]
        last[cells] = len(self._sizes)
        self._sizes.append(len(cells))
        return any(count == size for count, size in zip(counts.tolist(), sizes, strict=True))

    def read(self, owner: Any, name: str) -> None:
        """Note that values were read, as those are from which further ones are computed."""
        self._last.pop((id(owner), name), None)

    def run(self) -> None:
        """Note that the network runs with all values."""
        self._had_effect.update(self._since)
        self._sizes.clear()
        self._last.clear()
        self._since.clear()

    def idle(self) -> Iterator[tuple[str, str]]:
        """Yield the owner's label and the name of each parameter that was set only after the last run."""
        for (owner, name), label in self._since.items():
            if (owner, name) not in self._had_effect:
                yield label, name
