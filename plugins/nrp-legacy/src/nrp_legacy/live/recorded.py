"""What was recorded of cells, as objects of Neo, which have the names of its older versions, too."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray

State = tuple[str, FloatArray, FloatArray]
"""A variable, times (ms), and values of shape ``(n, n_cells)``."""

_UNITS = {"v": "mV", "gsyn_exc": "uS", "gsyn_inh": "uS"}


def block_of(
    name: str, ids: Iterable[int], spikes: FloatArray, states: Iterable[State], now_ms: float
) -> Any:
    """Return a block with one segment: a train for each cell, and a signal for each state variable.

    Args:
        name: the name of the cells.
        ids: the cells.
        spikes: index of the cell and time (ms) of each spike, shape ``(n, 2)``.
        states: the samples of state variables.
        now_ms: the time, at which the trains end.
    """
    import neo

    class Segment(neo.Segment):  # type: ignore[misc]
        @property
        def analogsignalarrays(self) -> Any:
            """The signals, as Neo called them before 0.5."""
            return self.analogsignals

    segment = Segment()
    segment.analogsignals.extend([_signal(*state) for state in states])
    for i, cell in enumerate(ids):
        times = np.minimum(spikes[spikes[:, 0] == i, 1], now_ms)
        segment.spiketrains.append(
            neo.SpikeTrain(times, t_stop=now_ms, units="ms", source_id=cell, source_index=i)
        )
    block = neo.Block(name=name)
    block.segments.append(segment)
    return block


def _signal(variable: str, times_ms: FloatArray, values: FloatArray) -> Any:
    import neo
    from quantities import ms

    step_ms = times_ms[1] - times_ms[0] if len(times_ms) > 1 else 1.0
    begin_ms = times_ms[0] if len(times_ms) else 0.0
    return neo.AnalogSignal(
        values, units=_UNITS.get(variable, ""), name=variable,
        t_start=begin_ms * ms, sampling_period=step_ms * ms,
    )  # fmt: skip
