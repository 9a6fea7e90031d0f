"""A sort by small numbers."""

from __future__ import annotations

import numpy as np

from nrp_core.brain.network.drawing.loops import Array

_FEW = 1 << 16
"""Up to this number, a sort by comparing takes less time than loading a compiler."""


def sorted_by(keys: Array, values: Array, n_keys: int) -> tuple[Array, Array]:
    """Return values in the stable order of their keys below ``n_keys``, and the number of each key."""
    counts = np.bincount(keys, minlength=n_keys)
    if len(keys) <= _FEW:
        return values[np.argsort(keys, kind="stable")], counts
    from nrp_core.brain.network.drawing.compiled import place_by

    out = np.empty_like(values)
    place_by(keys, values, np.cumsum(counts) - counts, out)
    return out, counts
