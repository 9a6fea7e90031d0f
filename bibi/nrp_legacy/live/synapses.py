"""Synapses of a brain file, as transfer functions meet them."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.network.data import Projection
from nrp_core.errors import CapabilityError
from nrp_legacy.live.built import Built


class Synapses:
    """A projection.

    Args:
        built: what it is part of.
        label: of the projection.
    """

    def __init__(self, built: Built, label: str) -> None:
        self._built, self.label = built, label

    def __len__(self) -> int:
        return int(self._built.projection(self.label).size)

    def size(self) -> int:
        """Return how many they are."""
        return len(self)

    def get(self, name: Any, format: str = "list", with_address: bool = True, **_options: Any) -> Any:  # noqa: A002
        """Return weights (PyNN's units) or delays (ms).

        Args:
            name: ``weight`` or ``delay``; of several, a list of them.
            format: ``array`` for a matrix of the cells that have synapses, NaN where there is none, else
                ``list``.
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
        """Let them have another ``weight`` from now on: one number, a list, or a matrix as of :meth:`get`.

        Raises:
            CapabilityError: something else is to change, which no brain here can.
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
        """Let them have other weights from now on."""
        self.set(weight=weights)


def _places(projection: Projection) -> tuple[IntArray, IntArray]:
    """Return which of the cells that have synapses each one comes from and goes to."""
    ends = (projection.pre_index, projection.post_index)
    pre, post = (np.unique(cells, return_inverse=True)[1] for cells in ends)
    return pre, post
