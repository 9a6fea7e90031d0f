"""Reads networks of the Neuromorphic Intermediate Representation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.brain.network.data import Network
from nrp_core.brain.network.picking import Selection, with_views
from nrp_core.brain.pynn import builder

STEP_MS = 1.0


@checks_arguments()
def read_nir(
    path: Path | str,
    *,
    populations: Mapping[str, Selection] | None = None,
    seed: int = 0,
) -> Network:
    """Read a trained network; its inputs are cells that devices drive, and one of its steps takes 1 ms.

    A brain script with ``sim.load_nir`` has all options.

    Args:
        path: the file.
        populations: additional named selections of its neurons.
        seed: has no effect, since the file holds no random values to draw.

    Raises:
        NetworkError: the file cannot be read, or has a node that cannot be built.
        NeuronSelectionError: ``populations`` reaches outside the network.
    """
    sim = builder(seed)
    sim.setup(timestep=STEP_MS)
    sim.load_nir(path, inputs="cells")
    return with_views(sim.network(), populations or {})
