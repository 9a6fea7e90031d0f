"""Valid mappings of transfer functions whose effect differs from their declaration."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from nrp_core.brain.network.data import Network
from nrp_core.dsl.functions.csv_recorder import inside
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.mappings import MapCSVRecorder, MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters.binding import Mapping
from nrp_core.dsl.selection.selection import BrainRoot, Selection
from nrp_core.dsl.selection.selectors import select
from nrp_core.errors import NrpError
from nrp_core.findings import Code, Finding, Level


def doubtful_mappings(function: TransferFunction, network: Network) -> Iterator[Finding]:
    """Yield findings about mappings that select a neuron twice or write a file with another name."""
    for name, mapping in function.mappings.items():
        match mapping:
            case MapSpikeSource() | MapSpikeSink():
                verb = "drives" if mapping.drives else "reads"
                for ids in _chosen(mapping, network):
                    most = int(np.unique(ids, return_counts=True)[1].max())
                    if most > 1:
                        message = f"'{name}' {verb} the same neuron {most} times: {mapping.selector!r}"
                        yield _at(mapping, Code.NRP211, message)
                        break
            case MapCSVRecorder(filename=str(filename)) if inside(filename) != filename:
                message = f"the rows of '{name}' are written to '{inside(filename)}', not to '{filename}'"
                yield _at(mapping, Code.NRP315, message)


def _chosen(
    mapping: MapSpikeSource | MapSpikeSink, network: Network
) -> Iterator[np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """Yield the neurons of each device of a mapping; unbindable mappings are reported elsewhere."""
    try:
        selected = select(mapping.selector, BrainRoot(network))
    except (NrpError, ValueError, TypeError):
        return
    yield from (one.ids for one in ([selected] if isinstance(selected, Selection) else selected))


def _at(mapping: Mapping, code: Code, message: str) -> Finding:
    place = mapping.place
    return Finding(code, message, Level.WARNING, Path(place.path), place.line)
