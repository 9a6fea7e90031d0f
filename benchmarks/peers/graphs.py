"""The networks of benchmarks/networks.py as plain numbers, the same for all simulators; needs NumPy alone.

``cuba`` and ``coba`` are those of Vogels & Abbott (2005, J Neurosci 25:10786) with the numbers of PyNN's
example VAbenchmarks.py; ``brunel`` is model A of Brunel (2000, J Comput Neurosci 8:183), g = 5, eta = 2,
with the numbers of NEST's example brunel_delta_nest.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

MODELS = ("cuba", "coba", "brunel")
CHUNK = 1000

Indices = npt.NDArray[np.uint16]
Values = npt.NDArray[np.float64]


@dataclass
class Graph:
    """A network of excitatory and inhibitory neurons; every neuron has the same number of sources of a kind.

    Units as in PyNN: ms, mV, nF, nA, uS; weights in nA (cuba), uS (coba), mV (brunel). Pairs hold what
    belongs to excitatory and to inhibitory sources.
    """

    model: str
    sizes: tuple[int, int]
    cells: dict[str, float]
    weight: tuple[float, float]
    delay: float
    sources: tuple[Indices, Indices]
    """The sources of each neuron, excitatory first, as indices in their kind; shape ``(n, in_degree)``."""
    initial: dict[str, npt.NDArray[np.float64]]
    noise: tuple[float, float] = (0.0, 0.0)
    """Rate (Hz) and weight of an independent Poisson train into each neuron."""
    own_weights: Sequence[Values] | None = None
    own_delays: Sequence[Values] | None = None
    """Shaped as ``sources``."""

    @property
    def n(self) -> int:
        return sum(self.sizes)

    @property
    def size(self) -> int:
        return sum(sources.size for sources in self.sources)

    def pre(self, kind: int) -> npt.NDArray[np.int64]:
        """Return the sources of all synapses of a kind, as numbers among all neurons."""
        return self.sources[kind].reshape(-1).astype(np.int64) + kind * self.sizes[0]

    def post(self, kind: int) -> npt.NDArray[np.int64]:
        """Return the neurons that they end on."""
        return np.repeat(np.arange(self.n), self.sources[kind].shape[1])


_LEAKY = {"tau_m": 20.0, "i_offset": 0.0}
_VA = {**_LEAKY, "cm": 0.2, "tau_refrac": 5.0, "v_reset": -60.0, "v_thresh": -50.0, "tau_syn_E": 5.0,
       "tau_syn_I": 10.0}  # fmt: skip


def make(model: str, n: int, *, seed: int = 1, weights: str = "equal", delays: str = "equal") -> Graph:
    """Return a network of n neurons; weights and delays ``equal`` or ``own`` of each synapse."""
    rng = np.random.default_rng(seed)
    sizes = (n * 4 // 5, n - n * 4 // 5)
    graph = _brunel(sizes, rng) if model == "brunel" else _vogels_abbott(model, sizes, rng)
    if weights == "own":
        graph.own_weights = tuple(
            w * rng.uniform(0.5, 1.5, s.shape) for w, s in zip(graph.weight, graph.sources, strict=True)
        )
    if delays == "own":
        shapes = (sources.shape for sources in graph.sources)
        graph.own_delays = tuple(np.asarray(rng.integers(15, 31, shape) * 0.1, float) for shape in shapes)
    return graph


def _vogels_abbott(model: str, sizes: tuple[int, int], rng: np.random.Generator) -> Graph:
    n, sources = sum(sizes), _fixed_in_degree(sizes, (sizes[0] // 50, sizes[1] // 50), rng)
    if model == "cuba":
        initial = {"v": rng.uniform(-60.0, -50.0, n)}
        return Graph(model, sizes, {**_VA, "v_rest": -49.0}, (0.0162, -0.09), 0.2, sources, initial)
    initial = {
        "v": -60.0 + (rng.standard_normal(n) * 5.0 - 5.0),
        "gsyn_exc": np.maximum(rng.standard_normal(n) * 1.5 + 4.0, 0.0) * 0.01,
        "gsyn_inh": np.maximum(rng.standard_normal(n) * 12.0 + 20.0, 0.0) * 0.01,
    }
    cells = {**_VA, "v_rest": -60.0, "e_rev_E": 0.0, "e_rev_I": -80.0}
    return Graph(model, sizes, cells, (0.006, 0.067), 0.2, sources, initial)


def _brunel(sizes: tuple[int, int], rng: np.random.Generator) -> Graph:
    """Reduce weights as the in-degree grows, so that networks of all sizes fire alike."""
    degrees = (sizes[0] // 10, sizes[1] // 10)
    sources = _fixed_in_degree(sizes, degrees, rng)
    cells = {**_LEAKY, "v_rest": 0.0, "cm": 1.0, "tau_refrac": 2.0, "v_reset": 0.0, "v_thresh": 20.0}
    weight = 100.0 / degrees[0]
    threshold_rate = 1e3 * cells["v_thresh"] / (weight * cells["tau_m"])  # of the whole input, Hz
    initial = {"v": np.zeros(sum(sizes))}
    noise = (2 * threshold_rate, weight)
    return Graph("brunel", sizes, cells, (weight, -5 * weight), 1.5, sources, initial, noise)


def _fixed_in_degree(
    sizes: tuple[int, int], degrees: tuple[int, int], rng: np.random.Generator
) -> tuple[Indices, Indices]:
    """Draw the sources of each neuron at random, with repetition, using little extra memory."""
    n = sum(sizes)
    exc, inh = np.empty((n, degrees[0]), np.uint16), np.empty((n, degrees[1]), np.uint16)
    for first in range(0, n, CHUNK):
        last = min(first + CHUNK, n)
        exc[first:last] = rng.integers(0, sizes[0], (last - first, degrees[0]), dtype=np.uint16)
        inh[first:last] = rng.integers(sizes[0], n, (last - first, degrees[1]), dtype=np.uint16) - sizes[0]
    return exc, inh
