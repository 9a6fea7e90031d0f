"""The connectome of the adult hermaphrodite of *C. elegans*: 302 neurons and their chemical synapses,
with each other and with muscles.

``edges.csv`` and ``muscles.csv`` have the sections in which synapses are seen (Cook et al. 2019,
doi:10.1038/s41586-019-1352-7). OpenWorm publishes them in cect 0.3.5 (https://pypi.org/project/cect/) under
the MIT licence in ``LICENSE``; the supplement of the article states none. ``neurons.csv`` names
the 26 neurons with GABA of McIntire et al. (1993), Nature 364:337. :mod:`.tables` made all three.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np


def synapses(sources: Sequence[str], targets: Sequence[str]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the numbers of sections with a synapse between cells, shape ``(sources, targets)``."""
    found = np.zeros((len(sources), len(targets)))
    rows, columns = ({name: n for n, name in enumerate(names)} for names in (sources, targets))
    for name in ("edges.csv", "muscles.csv"):
        with (Path(__file__).parent / name).open(encoding="utf-8") as file:
            for edge in csv.DictReader(file):
                if edge["pre"] in rows and edge["post"] in columns:
                    found[rows[edge["pre"]], columns[edge["post"]]] += float(edge["weight"])
    return found
