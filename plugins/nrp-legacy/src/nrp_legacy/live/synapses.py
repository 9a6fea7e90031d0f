"""Synapses of a brain file, for transfer functions."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Projection
from nrp_core.errors import CapabilityError
from nrp_legacy.live.built import BuiltBrain


class Synapses:
    """A projection.

    Args:
        built: the objects of the brain file.
        label: the label of the projection.
    """

    def __init__(self, built: BuiltBrain, label: str) -> None:
        self._built, self.label = built, label

    def __len__(self) -> int:
        return int(self._built.projection(self.label).size)

    def size(self) -> int:
        """Return the number of synapses."""
        return len(self)

    def get(self, name: Any, format: str = "list", with_address: bool = True, **_options: Any) -> Any:  # noqa: A002
        """Return weights (PyNN's units) or delays (ms).

        Args:
            name: ``weight`` or ``delay``; several names give a list.
            format: ``array`` for a matrix over the cells with synapses, NaN for no synapse, else ``list``.
            with_address: whether entries of a list begin with source and target.
        """
        if not isinstance(name, str):
            return [self.get(one, format, with_address) for one in name]
        projection = self._built.projection(self.label)
        values = projection.delay_ms if name == "delay" else self._built.brain.read_weights(self.label)
        pre, post = _places(projection)
        if format == "array":
            matrix = np.full((pre.max(initial=-1) + 1, post.max(initial=-1) + 1), np.nan)
            matrix[pre, post] = values
            return matrix
        rows = zip(pre.tolist(), post.tolist(), values.tolist(), strict=True)
        return list(rows) if with_address else values.tolist()

    def set(self, **values: Any) -> None:
        """Set ``weight``: one number, a list, or a matrix as from :meth:`get`.

        Raises:
            CapabilityError: another parameter is to change, which brains here do not support.
        """
        if values.keys() - {"weight"}:
            raise CapabilityError(
                f"{', '.join(values)}: only the weight of a synapse can change during a run"
            )
        weight = np.asarray(values["weight"], dtype=float)
        if weight.ndim > 1:
            weight = weight[_places(self._built.projection(self.label))]
        self._built.brain.set_weights(self.label, weight)

    def getWeights(self, format: str = "list", **_options: Any) -> Any:  # noqa: A002, N802 - PyNN 0.7
        """Return weights."""
        return self.get("weight", format, with_address=False)

    def getDelays(self, format: str = "list", **_options: Any) -> Any:  # noqa: A002, N802 - PyNN 0.7
        """Return delays."""
        return self.get("delay", format, with_address=False)

    def setWeights(self, weights: Any) -> None:  # noqa: N802 - PyNN 0.7
        """Set weights."""
        self.set(weight=weights)


def _places(projection: Projection) -> tuple[IntArray, IntArray]:
    """Return the indices of the source and target of each synapse among the cells with synapses."""
    ends = (projection.pre_index, projection.post_index)
    pre, post = (np.unique(cells, return_inverse=True)[1] for cells in ends)
    return pre, post
