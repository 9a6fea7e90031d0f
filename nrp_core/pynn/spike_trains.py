"""The spike trains of a population, which are made from two arrays when they are first touched."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

import neo
import numpy as np
from neo.core.dataobject import ArrayDict
from neo.core.spiketrainlist import SpikeTrainList


class SpikeTrain(neo.SpikeTrain):
    """Neo's class, with a ``sort`` that ``numpy.sort``, and with it Matplotlib's ``eventplot``, can call."""

    def __reduce__(self) -> Any:
        """Return a copy as Neo's own class, so that files of it need only Neo."""
        function, arguments = super().__reduce__()
        return function, (neo.SpikeTrain, *arguments[1:])

    def sort(self, axis: int = -1, kind: Any = None, order: Any = None, *, stable: Any = None) -> None:
        """Sort in place; trains have one axis and no fields, so that the arguments have no effect."""
        super().sort()


class _Part(neo.SpikeTrain):
    """Some spikes of a train, without attributes: Neo's takes 16 us to copy them."""

    def __array_finalize__(self, obj: Any) -> None:
        pass


class SpikeTrains(SpikeTrainList):
    """The same list, with the same trains, which are divided in one pass.

    Neo stores the spikes of a population as two arrays and makes trains on request. It then
    compares the cell of every spike with every cell, which takes minutes for 100 000 cells, and it checks the
    times of each train.

    Args:
        found: the list that PyNN made from arrays.
        source_id: a further annotation of the trains, one for each.
    """

    def __init__(self, found: SpikeTrainList, source_id: Any = None) -> None:
        super().__init__()
        self.__dict__.update(vars(found))
        if source_id is not None:
            self._annotations: dict[str, Any] = {**vars(found)["_annotations"], "source_id": source_id}

    def __reduce__(self) -> Any:
        """Return a copy as Neo's own class, so that files of it need only Neo."""
        return SpikeTrainList, (), dict(vars(self))

    def _spiketrains_from_array(self) -> None:
        self._items: list[SpikeTrain] = []
        if self._spike_time_array is None:
            return
        order = np.argsort(self._channel_id_array, kind="stable")
        owners, channels = self._channel_id_array[order], np.asarray(self._all_channel_ids)
        first, last = (np.searchsorted(owners, channels, side=side).tolist() for side in ("left", "right"))
        each = {name: value for name, value in self._annotations.items() if _is_each(value, len(channels))}
        all_ = {name: value for name, value in self._annotations.items() if name not in each}
        every = SpikeTrain(self._spike_time_array[order], **self._spiketrain_metadata)  # checks all times
        every.segment, attributes = self.segment, vars(every)
        parts = every.view(_Part)
        for index, channel in enumerate(channels):
            train: Any = np.ndarray.__getitem__(parts, slice(first[index], last[index]))
            train.__class__ = SpikeTrain
            train.__dict__.update(attributes)
            train.t_start, train.t_stop = every.t_start.copy(), every.t_stop.copy()
            train.array_annotations = ArrayDict(len(train))
            own = {name: values[index] for name, values in each.items()}
            train.annotations = {**all_, **own, "channel_id": channel}
            self._items.append(train)


def _is_each(value: Any, n: int) -> bool:
    return not isinstance(value, str) and hasattr(value, "__len__") and len(value) == n
