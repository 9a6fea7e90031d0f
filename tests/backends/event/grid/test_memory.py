"""The memory that a grid needs while it is built."""

import tracemalloc
from collections.abc import Callable

import numpy as np

from nrp_core.brain.backends import brains
from nrp_core.network.data import Network, Population, Projection

N = 1000


def test_a_million_delays_are_put_on_the_grid_in_parts(cells: Callable[..., Population]) -> None:
    random = np.random.default_rng(1)
    projection = Projection(
        "wires", "cells", "cells", "excitatory",
        random.integers(0, N, N * N, np.int32), np.repeat(np.arange(N, dtype=np.int32), N),
        np.broadcast_to(0.1, N * N), random.uniform(1.0, 5.0, N * N),
    )  # fmt: skip
    network = Network({"cells": cells("cells", "IF_curr_exp", N)}, (projection,))
    backend = brains().load("event")
    options = backend.options.model_validate({"resolution": "0.1 ms"})

    def build() -> None:
        backend.open(network, seed=0, options=options).close()

    build()  # loads the kernels
    tracemalloc.start()
    build()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20 * projection.size  # the steps of all delays at once, and what they come from, take 50
