"""Comparison of recorded data, as sPyNNaker's helper of this name: an exception for the first difference."""

from __future__ import annotations

from typing import Any

import numpy as np


def compare_spiketrain(spiketrain1: Any, spiketrain2: Any, same_length: bool = True) -> None:
    """Compare two spike trains; without ``same_length``, up to the end of the shorter one."""
    first, second = np.asarray(spiketrain1.magnitude), np.asarray(spiketrain2.magnitude)
    n = min(len(first), len(second))
    _require(not same_length or len(first) == len(second), f"{len(first)} spikes against {len(second)}")
    _require(np.array_equal(first[:n], second[:n]), f"spikes at {first[:n]} ms against {second[:n]} ms")


def compare_spiketrains(
    spiketrains1: Any, spiketrains2: Any, same_data: bool = True, same_length: bool = True
) -> None:
    """Compare two lists of spike trains, one by one."""
    if not same_data and not (len(spiketrains1) and len(spiketrains2)):
        return
    _require(
        len(spiketrains1) == len(spiketrains2), f"{len(spiketrains1)} trains against {len(spiketrains2)}"
    )
    for first, second in zip(spiketrains1, spiketrains2, strict=True):
        compare_spiketrain(first, second, same_length)


def compare_analogsignal(as1: Any, as2: Any, same_length: bool = True) -> None:
    """Compare two signals; without ``same_length``, up to the end of the shorter one."""
    first, second = np.asarray(as1.magnitude), np.asarray(as2.magnitude)
    n = min(len(first), len(second))
    _require(as1.name == as2.name, f"'{as1.name}' against '{as2.name}'")
    _require(not same_length or len(first) == len(second), f"{len(first)} samples against {len(second)}")
    _require(np.array_equal(first[:n], second[:n]), f"'{as1.name}' has different values")


def compare_segments(segment1: Any, segment2: Any, same_data: bool = True, same_length: bool = True) -> None:
    """Compare two runs: their spikes and all signals that both have, or all that either has."""
    compare_spiketrains(segment1.spiketrains, segment2.spiketrains, same_data, same_length)
    signals = [{signal.name: signal for signal in part.analogsignals} for part in (segment1, segment2)]
    _require(
        not same_data or signals[0].keys() == signals[1].keys(),
        f"{list(signals[0])} against {list(signals[1])}",
    )
    for name in signals[0].keys() & signals[1].keys():
        compare_analogsignal(signals[0][name], signals[1][name], same_length)


def compare_blocks(
    neo1: Any, neo2: Any, same_runs: bool = True, same_data: bool = True, same_length: bool = True
) -> None:
    """Compare the data of two populations, run by run."""
    n = len(neo1.segments), len(neo2.segments)
    _require(not same_runs or n[0] == n[1], f"{n[0]} runs against {n[1]}")
    for first, second in zip(neo1.segments, neo2.segments, strict=False):
        compare_segments(first, second, same_data, same_length)


def _require(same: bool, difference: str) -> None:
    if not same:
        raise AssertionError(f"the data differ: {difference}")
