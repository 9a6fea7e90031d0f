"""Selected neurons of an existing brain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.network.data import Network
from nrp_core.dsl.selection.regions import Region, distances_um, point
from nrp_core.errors import NeuronSelectionError

GROUP: Final = "group"


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """An ordered selection of neurons.

    Indices work as in NumPy, with two differences: a single index gives a selection of one neuron, and a
    tuple joins the selections of its items: ``sensors[0, 2]``, ``sensors[0, 3:5]``.

    Args:
        ids: global ids, shape ``(n,)``.
        label: the name of their population or view.
        network: their network, which has their positions.
    """

    ids: IntArray
    label: str
    network: Network | None = None

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def size(self) -> int:
        """Number of neurons."""
        return len(self.ids)

    def __getitem__(self, index: Any) -> Selection:
        return self._of(self._chosen(index))

    def __add__(self, other: Selection) -> Selection:
        if not isinstance(other, Selection):
            return NotImplemented
        ids = np.concatenate([self.ids, other.ids])
        return Selection(ids, f"{self.label} + {other.label}", self.network)

    def __radd__(self, other: int) -> Selection:
        if other != 0:  # sum() begins with 0
            return NotImplemented
        return self

    @property
    def positions_um(self) -> FloatArray:
        """Their positions, shape ``(n, 3)``.

        Raises:
            NeuronSelectionError: the network has no positions.
        """
        if self.network is None:
            raise NeuronSelectionError(f"'{self.label}' has no positions")
        return self.network.positions_of(self.ids)

    def within(self, region: Region) -> Selection:
        """Return the neurons in a region, in order; there may be none.

        Raises:
            NeuronSelectionError: they have no positions, or the argument is not a region.
        """
        if not isinstance(region, Region):
            raise NeuronSelectionError(f"a region is a Box or a Sphere, not {region!r}")
        return self._of(self.ids[region.contains(self.positions_um)])

    def nearest(self, center: Sequence[float], n: int = 1) -> Selection:
        """Return the ``n`` neurons nearest to a point (um), the nearest first; ties go to the first neurons.

        Raises:
            NeuronSelectionError: they have no positions, the argument is not a point, or there are fewer
                than ``n``.
        """
        if not isinstance(n, (int, np.integer)) or isinstance(n, bool) or not 0 < n <= self.size:
            raise NeuronSelectionError(
                f"'{self.label}' has {self.size} neurons; cannot select the nearest {n!r}"
            )
        distances = distances_um(self.positions_um, point(center, "the center of a search", finite=True))
        return self._of(self.ids[np.argsort(distances, kind="stable")[:n]])

    def _of(self, ids: IntArray) -> Selection:
        return Selection(ids, self.label, self.network)

    def _chosen(self, index: Any) -> IntArray:
        if isinstance(index, tuple):
            return np.concatenate([self.ids[:0], *map(self._chosen, index)])
        if isinstance(index, slice):
            return self.ids[index]
        wanted = np.asarray(index)
        if wanted.size == 0:
            return self.ids[:0]
        if wanted.dtype.kind not in ("iu" if wanted.ndim == 0 else "iub") or wanted.ndim > 1:
            raise NeuronSelectionError(f"neurons are selected by integers, slices and lists, not {index!r}")
        try:
            return np.atleast_1d(self.ids[wanted])
        except IndexError:
            raise NeuronSelectionError(
                f"'{self.label}' has {self.size} neurons, 0..{self.size - 1}; {index!r} is out of range"
            ) from None


class Groups:
    """Populations and groups by their names, which need not be names of Python: ``group["5-HT"]``.

    Args:
        find: returns the neurons of a name.
    """

    __slots__ = ("_find",)

    def __init__(self, find: Callable[[str], Selection]) -> None:
        self._find = find

    def __repr__(self) -> str:
        return "the groups of the brain"

    def __getitem__(self, name: str) -> Selection:
        if not isinstance(name, str):
            raise NeuronSelectionError(f"brain.group is indexed by the name of a group, not by {name!r}")
        return self._find(name)


class BrainRoot:
    """The value of ``nrp.brain``: every population and view of a network by its name.

    ``group`` has them by name too, unless one of them is called ``group``.
    """

    __slots__ = ("_network",)

    def __init__(self, network: Network) -> None:
        self._network = network

    def __getitem__(self, name: object) -> Any:
        meant = f"nrp.brain.group[{name!r}]" if isinstance(name, str) else f"nrp.brain.NAME[{name!r}]"
        raise NeuronSelectionError(f"nrp.brain holds populations by their names: write {meant}")

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        network = self._network
        if name == GROUP and name not in network.views and name not in network.populations:
            return Groups(self._named)
        return self._named(name)

    def _named(self, name: str) -> Selection:
        return Selection(self._network.neurons(name), name, self._network)
