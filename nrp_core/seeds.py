"""One seed, many independent random streams, each known by a name.

A stream depends on the root seed and its name alone, never on the order of creation: adding a
device does not change the noise of the others. No global generator is read. They are seeded only
while a brain script runs, which may draw from them.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from numbers import Integral

import numpy as np

from nrp_core.errors import ExperimentError


def require_seed(seed: object) -> int:
    """Return a seed as an integer.

    Raises:
        ExperimentError: it is none.
    """
    if not isinstance(seed, Integral) or isinstance(seed, bool):
        raise ExperimentError(f"a seed is an integer, not {seed!r:.60}")
    return int(seed)


@dataclass(frozen=True, slots=True)
class Seeds:
    """A family of named random streams.

    Args:
        root: the experiment's seed, any integer.
        path: the names that lead here, joined by ``/``.
    """

    root: int
    path: str = ""

    def child(self, name: str) -> Seeds:
        """Return the family below ``name``."""
        return Seeds(self.root, f"{self.path}/{name}" if self.path else name)

    def stream(self, name: str) -> np.random.Generator:
        """Return a new counter-based generator (Philox) for ``name``; equal names give equal numbers."""
        return np.random.Generator(np.random.Philox(key=self._key(name, 16)))

    def integer(self, name: str, bits: int = 32) -> int:
        """Return an unsigned integer of ``bits`` bits, for engines that take a seed of their own."""
        return self._key(name, 16) >> (128 - bits)

    def _key(self, name: str, n_bytes: int) -> int:
        text = f"{self.root}:{self.path}/{name}".encode()
        return int.from_bytes(hashlib.blake2b(text, digest_size=n_bytes).digest(), "big")
