"""sPyNNaker's panel for figures of ``pyNN.utility.plotting``: spikes are points, other data are heat maps."""

from __future__ import annotations

from itertools import repeat
from typing import Any, NoReturn

import numpy as np
from neo import AnalogSignal, Block, Segment, SpikeTrain

from nrp_core.brain import FloatArray


class SpynnakerPanel:
    """A part of a figure.

    Args:
        data: lists of spike trains, signals, segments, blocks, or arrays of sPyNNaker 7: rows of cell and
            time, or of cell, time and value.
        options: ``data_labels``, ``line_properties``, options of PyNN's ``Panel``, and for segments and
            blocks the ``name`` of the variable and the ``run``.
    """

    def __init__(self, *data: Any, **options: Any) -> None:
        self.data = [*data]
        self.data_labels = options.pop("data_labels", repeat(None))
        self.line_properties = options.pop("line_properties", repeat({}))
        self.options = options

    def plot(self, axes: Any) -> None:
        """Draw the data.

        Raises:
            ValueError: the data have an unknown form, or several variables without a ``name``.
        """
        from pyNN.utility.plotting import handle_options

        for datum, label, properties in zip(self.data, self.data_labels, self.line_properties, strict=False):
            options = {**properties, **self.options}
            chosen = _chosen(datum, options.pop("name", None), options.pop("run", None))
            handle_options(axes, options)
            points = _points(chosen)
            if points is not None:
                axes.plot(points[1], points[0], "b.", **{"markersize": 0.5, **options})
                axes.set_ylabel("Neuron index")
            else:
                image = axes.imshow(
                    _matrix(chosen), cmap="hot", interpolation="none", origin="lower", aspect="auto"
                )
                axes.figure.colorbar(image)
            if label:
                axes.text(0.95, 0.95, label, transform=axes.transAxes, ha="right", va="top")


def _chosen(datum: Any, name: str | None, run: int | None) -> Any:
    """Return the spike trains or the signal in a segment or block, and other data unchanged."""
    if isinstance(datum, Block):
        if run is None and len(datum.segments) != 1:
            raise ValueError(f"the block has {len(datum.segments)} segments; choose one by run=")
        datum = datum.segments[run or 0]
    if isinstance(datum, Segment):
        known = {signal.name: signal for signal in datum.analogsignals}
        known |= {"spikes": datum.spiketrains} if len(datum.spiketrains) else {}
        if name is None and len(known) != 1:
            raise ValueError(f"the segment has {', '.join(known) or 'no data'}; choose a variable by name=")
        datum = known[name or next(iter(known))]
    if isinstance(datum, list) and len(datum) == 1 and not isinstance(datum[0], SpikeTrain):
        return datum[0]
    return datum


def _points(datum: Any) -> tuple[FloatArray, FloatArray] | None:
    """Return cells and times, ms, of spikes; None for other data."""
    if isinstance(datum, np.ndarray):
        is_spikes = not isinstance(datum, AnalogSignal) and datum.ndim == 2 and datum.shape[1] == 2
        return (datum[:, 0], datum[:, 1]) if is_spikes else None
    trains = [*datum]
    if not trains or not all(isinstance(train, SpikeTrain) for train in trains):
        _refuse(datum)
    cells = np.repeat(
        [float(one.annotations["source_index"]) for one in trains], [len(one) for one in trains]
    )
    return cells, np.concatenate([one.rescale("ms").magnitude for one in trains])


def _matrix(datum: Any) -> FloatArray:
    """Return values by cell and step."""
    if isinstance(datum, AnalogSignal):
        return np.asarray(datum.magnitude.T, float)
    if datum.ndim != 2 or datum.shape[1] != 3:
        _refuse(datum)
    cells, steps = datum[:, 0].astype(int), datum[:, 1].astype(int)
    values = np.full((cells.max() + 1, steps.max() + 1), np.nan)
    values[cells, steps] = datum[:, 2]
    return values


def _refuse(datum: Any) -> NoReturn:
    raise ValueError(
        f"SpynnakerPanel draws spike trains, signals, segments, blocks and rows of numbers, not {datum!r:.60}"
    )
