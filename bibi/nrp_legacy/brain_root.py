"""``nrp.config.brain_root``: the variables of the brain file, and its neurons and synapses while it runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from nrp_core.brain.network import FloatArray, IntArray, Network, Projection
from nrp_core.dsl import brain as any_brain
from nrp_core.dsl.selectors import Selector
from nrp_core.errors import LifecycleError
from nrp_core.experiment.run import Run

_PLAIN = (bool, int, float, complex, str, bytes, type(None), np.generic, np.ndarray)


def plain_variables(variables: Mapping[str, Any]) -> dict[str, Any]:
    """Return those variables of a file that hold numbers, texts, and collections of them."""
    return {name: value for name, value in variables.items() if name[0] != "_" and _is_plain(value)}


def _is_plain(value: Any) -> bool:
    if isinstance(value, dict):
        return all(map(_is_plain, value)) and all(map(_is_plain, value.values()))
    if isinstance(value, (list, tuple, set, frozenset)):
        return type(value).__module__ == "builtins" and all(map(_is_plain, value))
    return type(value) in _PLAIN or isinstance(value, (np.generic, np.ndarray))


class BrainRoot:
    """The module of the brain file, as transfer functions see it; what they set on it stays."""

    def __init__(self) -> None:
        self._network: Network | None = None
        self._run: Run | None = None
        self._changed: dict[str, FloatArray] = {}

    def __deepcopy__(self, memo: object) -> BrainRoot:
        """Return the root itself: a variable that begins with it keeps the run's."""
        return self

    def know(self, network: Network) -> None:
        """Take the network that the file has built."""
        self._network = network

    def begin(self, run: Run) -> None:
        """Take part in a run."""
        self._network, self._run = run.brain.network, run
        run.loop.hooks.after_reset.append(lambda _loop: self._changed.clear())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        network = self._network
        if network is not None:
            if name in (variables := getattr(network, "variables", {})):
                return variables[name]
            if name in (labels := getattr(network, "labels", {})):
                return Synapses(self, labels[name])
            if name in network.views or name in network.populations:
                return Cells(self, getattr(any_brain, name), network.neurons(name))
        return getattr(any_brain, name)

    # -- for its parts

    @property
    def running(self) -> Run:
        """The run.

        Raises:
            LifecycleError: there is none yet.
        """
        if self._run is None:
            raise LifecycleError("the brain can be changed once the simulation runs")
        return self._run

    def parameter(self, name: str) -> FloatArray:
        """Return a parameter of all neurons; NaN for those that have none of this name."""
        assert self._network is not None
        if name not in self._changed:
            values = np.full(self._network.size, np.nan)
            for label, population in self._network.populations.items():
                values[self._network.ids_of(label)] = population.parameters.get(name, np.nan)
            self._changed[name] = values
        return self._changed[name]

    def synapses(self, label: str) -> Projection:
        """Return a projection."""
        assert self._network is not None
        return next(one for one in self._network.projections if one.label == label)


class Cells(Selector):
    """Neurons of the brain file: a selector that knows how many they are, and their parameters.

    Args:
        root: whose they are.
        selector: how transfer functions name them.
        ids: global ids.
    """

    __slots__ = ("_ids", "_root")

    def __init__(self, root: BrainRoot, selector: Selector, ids: IntArray) -> None:
        super().__init__(selector._find, repr(selector))
        self._root, self._ids = root, ids

    def __len__(self) -> int:
        return len(self._ids)

    @property
    def size(self) -> int:
        """How many they are."""
        return len(self._ids)

    def __getitem__(self, index: Any) -> Selector:
        chosen = super().__getitem__(index)
        if isinstance(index, (int, np.integer, slice, list, np.ndarray)):
            return Cells(self._root, chosen, np.atleast_1d(self._ids[index]))
        return chosen

    def __iter__(self) -> Iterator[Selector]:  # type: ignore[override]
        return (self[i] for i in range(len(self._ids)))

    def get(self, names: Any, *_how: Any, **_options: Any) -> Any:
        """Return a parameter: one number where all are equal, as in PyNN; of several names a list."""
        if not isinstance(names, str):
            return [self.get(name) for name in names]
        values = self._root.parameter(names)[self._ids]
        return float(values[0]) if (values == values[0]).all() else values.copy()

    def set(self, *old: Any, **parameters: Any) -> None:
        """Let them have other parameters from now on."""
        if old:
            given = {old[0]: old[1]} if isinstance(old[0], str) else dict(old[0])
            parameters = {**given, **parameters}
        self._root.running.brain.set_parameters(self._ids, parameters)
        for name, values in parameters.items():
            self._root.parameter(name)[self._ids] = values


class Synapses:
    """A projection of the brain file.

    Args:
        root: whose it is.
        label: of the projection.
    """

    def __init__(self, root: BrainRoot, label: str) -> None:
        self._root, self._label = root, label

    def __len__(self) -> int:
        return int(self._root.synapses(self._label).size)

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
        projection = self._root.synapses(self._label)
        values = (
            projection.delay_ms if name == "delay" else self._root.running.brain.read_weights(self._label)
        )
        pre, post = _places(projection)
        if format == "array":
            matrix = np.full((pre.max(initial=-1) + 1, post.max(initial=-1) + 1), np.nan)
            matrix[pre, post] = values
            return matrix
        rows = zip(pre.tolist(), post.tolist(), values.tolist(), strict=True)
        return list(rows) if with_address else values.tolist()

    def set(self, weight: Any) -> None:
        """Let them have other weights from now on: one number, a list, or a matrix as of :meth:`get`."""
        values = np.asarray(weight, dtype=float)
        if values.ndim > 1:
            values = values[_places(self._root.synapses(self._label))]
        self._root.running.brain.set_weights(self._label, values)

    def getWeights(self, format: str = "list", **_options: Any) -> Any:  # noqa: A002, N802 - PyNN 0.7
        """Return weights."""
        return self.get("weight", format, with_address=False)

    def setWeights(self, weights: Any) -> None:  # noqa: N802 - PyNN 0.7
        """Let them have other weights from now on."""
        self.set(weights)


def _places(projection: Projection) -> tuple[IntArray, IntArray]:
    """Return which of the cells that have synapses each one comes from and goes to."""
    ends = (projection.pre_index, projection.post_index)
    pre, post = (np.unique(cells, return_inverse=True)[1] for cells in ends)
    return pre, post
