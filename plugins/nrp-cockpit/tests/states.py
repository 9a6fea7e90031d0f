"""The state of a run in a form that can be compared bit for bit: pickles of equal states can differ."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core.simulation import Snapshot


def plain(value: Any) -> Any:
    """Return a state as nested tuples, arrays as bytes, objects as their class and what they keep."""
    match value:
        case None | bool() | int() | str() | bytes():
            return value
        case type():
            return value.__qualname__
        case float():
            return value.hex()
        case Snapshot():
            return value.identity, value.t_ns, plain(pickle.loads(value.payload))
        case np.ndarray():
            return value.dtype.str, value.shape, value.tobytes()
        case Mapping():
            return tuple(sorted((repr(plain(key)), plain(item)) for key, item in value.items()))
        case set() | frozenset():
            return tuple(sorted(repr(plain(item)) for item in value))
        case list() | tuple():
            return tuple(map(plain, value))
    kind, *kept = value.__reduce_ex__(4)
    parts = (tuple(part) if hasattr(part, "__next__") else part for part in kept)
    return getattr(kind, "__qualname__", str(kind)), *map(plain, parts)
