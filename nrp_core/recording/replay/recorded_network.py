"""The network of a recording, as far as a recorded brain needs it, without its script."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core.brain.network.cells import CELLS
from nrp_core.brain.network.data import Network, Population


def recorded_network(run: Mapping[str, Any]) -> Network | None:
    """Return the populations and named groups of a recording, with PyNN's default parameters and no synapses.

    Args:
        run: the data of ``run.json``.

    Returns:
        None if the recording does not have them all: it is of an earlier version, or has other cells.
    """
    brain = run.get("brain") or {}
    populations = dict(brain.get("populations") or {})
    if "members" not in brain or any(one["cell_type"] not in CELLS for one in populations.values()):
        return None
    views = {name: np.array(ids, np.int64) for name, ids in brain["members"].items()}
    return Network({label: _population(label, **one) for label, one in populations.items()}, views=views)


def _population(label: str, size: int, cell_type: str) -> Population:
    cell = CELLS[cell_type]
    parameters = {name: np.full(size, parameter.default) for name, parameter in cell.parameters.items()}
    values = {name: np.full(size, parameter.default) for name, parameter in cell.state.items()}
    return Population(label, size, cell_type, parameters, values)
