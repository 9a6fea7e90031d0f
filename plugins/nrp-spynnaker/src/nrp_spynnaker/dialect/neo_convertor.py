"""Rows of numbers from recorded data: cell, time in ms, value; sPyNNaker's helper of this name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import quantities

from nrp_core.brain import FloatArray
from nrp_core.errors import NetworkError


def convert_analog_signal(signal_array: Any, time_unit: Any = quantities.ms) -> FloatArray:
    """Return the samples of a signal cell after cell, shape ``(n_cells * n_samples, 3)``."""
    times = np.asarray(signal_array.times.rescale(time_unit).magnitude)
    cells = np.asarray(signal_array.annotations.get("channel_names", range(signal_array.shape[1])))
    values = np.asarray(signal_array.magnitude).T.ravel()
    return np.column_stack([np.repeat(cells, len(times)), np.tile(times, len(cells)), values])


def convert_spiketrains(spiketrains: Iterable[Any]) -> FloatArray:
    """Return the spikes cell after cell, shape ``(n_spikes, 2)``."""
    rows = [np.empty((0, 2))]
    for place, train in enumerate(spiketrains):
        times = np.asarray(train.rescale(quantities.ms).magnitude)
        cell = train.annotations.get("source_index", place)
        rows.append(np.column_stack([np.full(len(times), cell, float), times]))
    return np.concatenate(rows)


def convert_spikes(neo: Any, run: int = 0) -> FloatArray:
    """Return the spikes of a run, numbered from 0, as :func:`convert_spiketrains` does."""
    return convert_spiketrains(_segment(neo, run).spiketrains)


def convert_data(data: Any, name: str, run: int = 0) -> FloatArray:
    """Return a recorded variable of a run.

    Raises:
        NetworkError: the run or variable does not exist.
    """
    if name == "spikes":
        return convert_spikes(data, run)
    signals = _segment(data, run).filter(name=name)
    if not signals:
        raise NetworkError(f"the data have no '{name}' in run {run}: record it before the run")
    return convert_analog_signal(signals[0])


def convert_data_list(data: Any, name: str, runs: Sequence[int] | None = None) -> list[FloatArray]:
    """Return a recorded variable of several runs, by default of all."""
    return [convert_data(data, name, run) for run in (range(len(data.segments)) if runs is None else runs)]


def convert_spikes_list(data: Any, runs: Sequence[int] | None = None) -> list[FloatArray]:
    """Return the spikes of several runs, by default of all."""
    return convert_data_list(data, "spikes", runs)


def convert_v_list(data: Any, runs: Sequence[int] | None = None) -> list[FloatArray]:
    """Return the voltage of several runs, by default of all."""
    return convert_data_list(data, "v", runs)


def convert_gsyn_exc_list(data: Any, runs: Sequence[int] | None = None) -> list[FloatArray]:
    """Return the excitatory input of several runs, by default of all."""
    return convert_data_list(data, "gsyn_exc", runs)


def convert_gsyn_inh_list(data: Any, runs: Sequence[int] | None = None) -> list[FloatArray]:
    """Return the inhibitory input of several runs, by default of all."""
    return convert_data_list(data, "gsyn_inh", runs)


def convert_gsyn(gsyn_exc: Any, gsyn_inh: Any, run: int = 0) -> FloatArray:
    """Return rows of cell, time, excitatory and inhibitory input of a run.

    Raises:
        NetworkError: the two have different cells or times.
    """
    excited = convert_data(gsyn_exc, "gsyn_exc", run)
    inhibited = convert_data(gsyn_inh, "gsyn_inh", run)
    if not np.array_equal(excited[:, :2], inhibited[:, :2]):
        raise NetworkError("gsyn_exc and gsyn_inh were recorded from different cells or at different times")
    return np.column_stack([excited, inhibited[:, 2]])


def count_spiketrains(spiketrains: Iterable[Any]) -> int:
    """Return the number of spikes in a list of trains."""
    return sum(len(train) for train in spiketrains)


def count_spikes(neo: Any) -> int:
    """Return the number of spikes of the first run."""
    return count_spiketrains(_segment(neo, 0).spiketrains)


def _segment(data: Any, run: int) -> Any:
    if not 0 <= run < len(data.segments):
        raise NetworkError(f"the data have no run {run}; they have {len(data.segments)}, numbered from 0")
    return data.segments[run]
