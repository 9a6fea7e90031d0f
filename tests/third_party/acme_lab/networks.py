"""A connector, a synapse law, and networks in files of edges."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pyNN.connectors import MapConnector
from pyNN.parameters import LazyArray

from nrp_core.brain import Network, builder
from nrp_core.network.picking import Selection, with_views
from nrp_core.network.pynn.equation_models import equation_synapse


class Ring(MapConnector):
    """Connects each cell to the one that is some steps further, in a ring."""

    def __init__(self, step: int) -> None:
        super().__init__()
        self.step = step

    def connect(self, projection: Any) -> None:
        n, m = projection.pre.size, projection.post.size
        self._connect_with_map(projection, LazyArray(lambda i, j: (j - i) % m == self.step, shape=(n, m)))


Depression = equation_synapse(
    "dD/dt = (1 - D)/tau_D : 1 (event-driven)",
    on_pre="share = D; D *= depression",
    parameters={"tau_D": "300 ms", "depression": 0.9},
    initial={"D": 1},
)


def read_edges(path: Path, *, populations: Mapping[str, Selection] | None = None, seed: int = 0) -> Network:
    """Return the network of a file with lines ``source target weight``: a current keeps its cells firing."""
    edges = [(int(i), int(j), float(w), 1.0) for i, j, w in map(str.split, path.read_text().splitlines())]
    sim = builder(seed)
    sim.setup(timestep=0.1)
    size = 1 + max(max(i, j) for i, j, *_ in edges)
    cells = sim.Population(size, sim.IF_curr_exp(i_offset=1.0), label="cells")
    sim.Projection(cells, cells, sim.FromListConnector(edges), sim.StaticSynapse())
    return with_views(sim.network(), populations or {})
