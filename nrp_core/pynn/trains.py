"""Neo's list of spike trains, divided into trains in one pass.

Neo stores the spikes of a population as two arrays and makes trains when somebody asks for one. It then
compares the cell of every spike with every cell, which takes minutes for 100 000 cells.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

import numpy as np
from neo import SpikeTrain
from neo.core.spiketrainlist import SpikeTrainList


class SpikeTrains(SpikeTrainList):
    """The same list, with the same trains.

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
        owners, times = self._channel_id_array[order], self._spike_time_array[order]
        channels = np.asarray(self._all_channel_ids)
        first, last = (np.searchsorted(owners, channels, side=side) for side in ("left", "right"))
        each = {name: value for name, value in self._annotations.items() if _is_each(value, len(channels))}
        all_ = {name: value for name, value in self._annotations.items() if name not in each}
        for index, channel in enumerate(channels):
            train = SpikeTrain(times[first[index] : last[index]], **self._spiketrain_metadata)
            own = {name: values[index] for name, values in each.items()}
            train.annotate(**all_, **own, channel_id=channel)
            train.segment = self.segment
            self._items.append(train)


def _is_each(value: Any, n: int) -> bool:
    return not isinstance(value, str) and hasattr(value, "__len__") and len(value) == n
