"""Nodes whose cells never fire, whatever their inputs do."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from nrp_formats.nir.neurons import Cells, Step


def never_fires(cells: Cells, matrices: Iterable[Any], step: Step) -> str:
    """Return that no cell of a node can fire, with the one that comes nearest; empty if one can.

    Args:
        cells: the cells.
        matrices: the weights onto them in the file, sparse, a row for each cell. A cell sends at most one
            spike in a step, so if all that excite spike in every step, the voltage rises to a limit.
        step: the step of the network.
    """
    threshold = cells.parameters["v_thresh"]
    if not threshold.size or not np.isfinite(threshold).all():
        return "its threshold is inf" if threshold.size and np.isinf(threshold).all() else ""
    tau_ms, cm, offset = (cells.parameters.get(name, np.ones(1)) for name in ("tau_m", "cm", "i_offset"))
    weight = np.zeros(len(threshold))
    for matrix in matrices:
        weight += np.asarray(matrix.maximum(0).sum(axis=1)).ravel() * cells.per_weight
    driven = offset * tau_ms / cm
    if cells.cell_type == "IF_curr_delta":
        driven = driven + weight / -np.expm1(-step.h_ms / tau_ms)
    else:
        driven = driven + weight / -np.expm1(-step.h_ms / cells.parameters["tau_syn_E"]) * tau_ms / cm
    highest = cells.parameters["v_rest"] + driven
    if (np.maximum(highest, cells.parameters["v_rest"]) >= threshold).any():
        return ""
    nearest = int(np.argmin(threshold - highest))
    return (
        f"all inputs together, in every step, take it to {highest[nearest]:.3g}, and its threshold is "
        f"{threshold[nearest]:.3g}"
    )
