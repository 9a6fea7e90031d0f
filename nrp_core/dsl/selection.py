"""Neurons of a brain that is there, chosen by name and index."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nrp_core.brain.network import IntArray, Network
from nrp_core.errors import NeuronSelectionError


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """Some neurons, in an order.

    An index means what it means to a NumPy array, but that a single one gives one neuron and a
    tuple joins what its items give: ``sensors[0, 2]``, ``sensors[0, 3:5]``.

    Args:
        ids: global ids, shape ``(n,)``.
        label: the population or view they come from.
    """

    ids: IntArray
    label: str

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def size(self) -> int:
        """Number of neurons."""
        return len(self.ids)

    def __getitem__(self, index: Any) -> Selection:
        return Selection(self._chosen(index), self.label)

    def __add__(self, other: Selection) -> Selection:
        if not isinstance(other, Selection):
            return NotImplemented
        return Selection(np.concatenate([self.ids, other.ids]), f"{self.label} + {other.label}")

    def _chosen(self, index: Any) -> IntArray:
        if isinstance(index, tuple):
            return np.concatenate([self.ids[:0], *map(self._chosen, index)])
        if isinstance(index, slice):
            return self.ids[index]
        wanted = np.asarray(index)
        if wanted.size == 0:
            return self.ids[:0]
        if wanted.dtype.kind not in ("iu" if wanted.ndim == 0 else "iub") or wanted.ndim > 1:
            raise NeuronSelectionError(f"neurons are chosen by integers, slices and lists, not {index!r}")
        try:
            return np.atleast_1d(self.ids[wanted])
        except IndexError:
            raise NeuronSelectionError(
                f"'{self.label}' has {self.size} neurons, 0..{self.size - 1}; {index!r} is not among them"
            ) from None


class BrainRoot:
    """What ``nrp.brain`` means: every population and view of a network by its name."""

    __slots__ = ("_network",)

    def __init__(self, network: Network) -> None:
        self._network = network

    def __getattr__(self, name: str) -> Selection:
        if name.startswith("_"):
            raise AttributeError(name)
        return Selection(self._network.neurons(name), name)
