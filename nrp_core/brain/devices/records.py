"""The states of sources and membranes as arrays of one record, which compiled code changes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np


def _record(floats: Sequence[str], integers: Sequence[str]) -> np.dtype[np.void]:
    fields = [*((name, "f8") for name in floats), *((name, "i8") for name in integers)]
    return np.dtype((np.record, fields))


ANCHORS: Final = ("anchor_ms", "anchor_u", "anchored_rate")
"""The point at which the rate changed last, in real and operational time, and the rate since then."""
TRAIN: Final = _record(
    ("rate", *ANCHORS, "last_u", "needed_u", "weight", "delay_ms"),
    (
        "u",
        "v",
        "n_drawn",
        "shares",
        "neurons",
        "n_neurons",
        "next",
        "n_due",
        "copies",
        "inhibitory",
        "active",
    ),
)
"""A source; ``u``, ``v``, ``shares`` and ``neurons`` are addresses."""

CONSTANTS: Final = ("alpha", "tau_m_ms", "tau_syn_ms", "cm_nf", "settled_mv")
CHANGING: Final = ("at_ms", "current", "slope", "above")
MEMBRANE: Final = _record(
    (*CONSTANTS, *CHANGING, "delay_ms", "now_ms"),
    ("waiting", "queue", "room", "received", "weights", "n_neurons", "active"),
)
"""A membrane; ``queue``, ``received`` and ``weights`` are addresses."""
