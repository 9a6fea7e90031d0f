"""Brains of 2014 in HDF5 files: adaptive exponential cells with depressing and facilitating synapses.

One dataset for each parameter holds a value per cell, in NEST's units; ``syn_<n>`` holds the synapses from
cell n (from 1 on), one per column: target, delay (ms), weight (nS), U, tau_rec, tau_facil (ms). Cells with
``excitatory`` above 100 are excitatory.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pyNN.standardmodels.cells import EIF_cond_alpha_isfa_ista

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.files.hdf5 import array, reading
from nrp_core.brain.network.data import Network, Population, Projection
from nrp_core.brain.network.synapses import TSODYKS_MARKRAM
from nrp_legacy.nest.models import CELLS, recovering

CELL = "aeif_cond_alpha"
LABEL = "circuit"
_TIMES_MS = {"tau_syn_E": 1.8, "tau_syn_I": 8.0}
"""Time constants of synapses where the file has none."""
_EXCITES = 100


def read_h5_brain(path: Path) -> Network:
    """Return the network of a file.

    Raises:
        NetworkError: it is not such a file.
    """
    with reading(path) as file:
        size = len(array(file, "x"))
        cells = _cells(file, size)
        excites = array(file, "excitatory") > _EXCITES
        projections = [
            projection
            for receptor, chosen in (("excitatory", excites), ("inhibitory", ~excites))
            if (projection := _projection(file, receptor, np.flatnonzero(chosen))) is not None
        ]
    return Network({LABEL: cells}, tuple(projections), {LABEL: np.arange(size)}, timestep_ms=0.1)


def _cells(file: Any, size: int) -> Population:
    parameters: dict[str, FloatArray] = {}
    for name, default in EIF_cond_alpha_isfa_ista.default_parameters.items():
        source = CELLS[CELL].parameters.get(name)
        if name in _TIMES_MS:
            values = array(file, name, float) if name in file else np.full(size, _TIMES_MS[name])
        elif name == "tau_m":
            values = array(file, "C_m", float) / array(file, "g_L", float)
        elif source is not None and source.name in file:
            values = array(file, source.name, float) * source.scale
        else:
            values = np.full(size, float(default))
        parameters[name] = np.ascontiguousarray(values)
    positions = np.stack([array(file, axis, float) for axis in "xyz"], axis=1)
    initial = {"v": parameters["v_rest"].copy()}
    initial |= {
        name: np.full(size, float(value))
        for name, value in EIF_cond_alpha_isfa_ista.default_initial_values.items()
        if name != "v"
    }
    cell_type = CELLS[CELL].cell_type
    return Population(LABEL, size, cell_type, parameters, initial, positions_um=positions)


def _projection(file: Any, receptor: str, sources: np.ndarray[Any, Any]) -> Projection | None:
    tables = {i: array(file, f"syn_{i + 1}", float) for i in sources.tolist() if f"syn_{i + 1}" in file}
    if not tables:
        return None
    rows = np.concatenate([table[:6] for table in tables.values()], axis=1)
    pre = np.repeat(list(tables), [table.shape[1] for table in tables.values()])
    target, delay, weight, u, recovery, facilitation = rows
    return Projection(
        receptor, LABEL, LABEL, receptor, pre.astype(np.int32), target.astype(np.int32) - 1,
        np.abs(weight) * 1e-3, delay, TSODYKS_MARKRAM,
        {"U": u, "tau_rec": recovering(recovery), "tau_facil": facilitation},
    )  # fmt: skip
