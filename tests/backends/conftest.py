"""Networks for brain backends, made of few words."""

from collections.abc import Callable

import numpy as np
import pytest

from nrp_core.network.cells import CELLS
from nrp_core.network.data import Population, Projection
from nrp_core.network.synapses import STATIC


@pytest.fixture
def cells() -> Callable[..., Population]:
    """Make cells with the defaults of their type; what is given is the same for all or one for each."""

    def make(
        label: str, cell_type: str, size: int = 1, initial: dict[str, object] | None = None, **given: object
    ) -> Population:
        def each(values: dict[str, object]) -> dict[str, np.ndarray]:
            return {name: np.full(size, value, dtype=float) for name, value in values.items()}

        defaults = {name: parameter.default for name, parameter in CELLS[cell_type].parameters.items()}
        return Population(label, size, cell_type, each(defaults | given), each(initial or {}))

    return make


@pytest.fixture
def spike_source() -> Callable[..., Population]:
    """Make cells that emit given spikes (ms)."""

    def make(label: str, *trains: list[float]) -> Population:
        arrays = tuple(np.array(train, dtype=float) for train in trains)
        return Population(label, len(trains), "SpikeSourceArray", {}, {}, arrays)

    return make


@pytest.fixture
def connect() -> Callable[..., Projection]:
    """Make synapses from ``(pre, post)`` pairs; numbers are the same for all or one for each."""

    def make(
        pre: str, post: str, weight: object, delay: object = 1.0, *,
        pairs: list[tuple[int, int]] | None = None, receptor: str = "excitatory", kind: str = STATIC,
        label: str = "", plasticity: dict[str, str] | None = None, **parameters: object,
    ) -> Projection:  # fmt: skip
        pre_index, post_index = np.array(pairs or [(0, 0)], np.int32).T.copy()
        n = len(pre_index)

        def each(value: object) -> np.ndarray:
            return np.full(n, value, dtype=float)

        return Projection(
            label or f"{pre}-{post}-{receptor}", pre, post, receptor, pre_index, post_index, each(weight),
            each(delay), kind, {name: each(value) for name, value in parameters.items()}, plasticity or {},
        )  # fmt: skip

    return make
