"""The synapses that formed and vanished, as events of Neo.

Their form is that of sPyNNaker 7.4.1: an event ``rewiring_form`` and an event ``rewiring_elim``, with labels
such as ``3_5_formation`` (source cell 3, target cell 5).
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from neo import Event
from pyNN import recording
from quantities import ms

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import from_milliseconds, nanoseconds
from nrp_core.network.changes import Rewirings

REWIRING: Final = recording.Variable(name="rewiring", location=None, label=None)
_KINDS: Final[tuple[Any, ...]] = (("form", "formation", True), ("elim", "elimination", False))


def events_of(changes: Iterable[Rewirings], since_ms: float) -> list[Any]:
    """Return the changes of all projections onto a population from a time on, by time and cells."""
    every = [*changes]
    nothing = np.empty(0)
    time_ms, pre, post, formed = (
        np.concatenate([nothing, *(getattr(one, name) for one in every)])
        for name in ("time_ms", "pre_index", "post_index", "formed")
    )
    order = np.lexsort((formed, post, pre, time_ms))
    order = order[nanoseconds(time_ms[order]) >= from_milliseconds(since_ms)]
    columns = [each[order] for each in (time_ms, pre, post)]
    chosen = {flag: formed[order] == flag for flag in (True, False)}
    return [_event(*names, *(each[chosen[flag]] for each in columns)) for *names, flag in _KINDS]


def _event(name: str, change: str, time_ms: FloatArray, pre: FloatArray, post: FloatArray) -> Any:
    labels = [f"{a:.0f}_{b:.0f}_{change}" for a, b in zip(pre, post, strict=True)]
    return Event(
        times=time_ms * ms, labels=np.array(labels, dtype=str), name=f"{REWIRING.name}_{name}",
        description=f"Synapse {change} events",
    )  # fmt: skip
