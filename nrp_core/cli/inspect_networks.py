"""``nrp inspect`` of a network file: its cells, signs, hubs, the paths between its groups, and a map."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import typer

from nrp_core._support.arrays import IntArray
from nrp_core.cli.output import document
from nrp_core.network.data import Network
from nrp_core.network.files import read_network
from nrp_core.network.files.network_file import SUFFIX

_MAX_GROUPS = 8
_MAX_DRAWN = 30
_MAX_HUBS = 5
_MAX_SYNAPSES_APART = 6
_QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


def is_network(file: Path) -> bool:
    """Return whether a file has the suffix of network files."""
    return file.suffix == SUFFIX and file.is_file()


def inspect_network(file: Path, image: Path | None, *, as_json: bool) -> None:
    """Print the contents of a network file, and draw its map.

    Raises:
        NetworkError: the file cannot be read.
    """
    network = read_network(file)
    found = describe(network)
    if image is not None:
        _draw_map(network, image)
    if as_json:
        document({"file": file, "image": image, **found})
        return
    for line in _lines(file.name, found):
        typer.echo(line)


def describe(network: Network) -> dict[str, Any]:
    """Return numbers about the cells and synapses of a network."""
    ends = _ends(network)
    out, into = (np.bincount(one, minlength=network.size) for one in ends)
    excites, inhibits = (_sources(network, excite) > 0 for excite in (True, False))
    groups = sorted(network.views, key=lambda name: -len(network.views[name]))
    return {
        "populations": {one.label: f"{one.size} {one.cell_type}" for one in network.populations.values()},
        "groups": {name: len(network.views[name]) for name in groups},
        "synapses": {one.label: one.size for one in network.projections},
        "signs": {
            "excite": int((excites & ~inhibits).sum()), "inhibit": int((inhibits & ~excites).sum()),
            "both": int((excites & inhibits).sum()), "neither": int((~excites & ~inhibits).sum()),
        },
        "out_degrees": _quantiles(out),
        "in_degrees": _quantiles(into),
        "hubs": {_name(network, cell): int(out[cell]) for cell in np.argsort(-out)[:_MAX_HUBS] if out[cell]},
        "synapses_apart": paths(network, ends, _telling(network)),
        "remarks": network.remarks,
    }  # fmt: skip


def paths(network: Network, ends: tuple[IntArray, IntArray], groups: list[str]) -> dict[str, dict[str, int]]:
    """Return the smallest number of synapses from each group to every group that it reaches."""
    from scipy.sparse import csr_array

    n = network.size
    pre, post = ends
    forward = csr_array((np.ones(len(pre), np.int8), (post, pre)), (n, n), dtype=bool)
    found: dict[str, dict[str, int]] = {}
    for source in groups:
        reached = np.zeros(n, bool)
        reached[network.views[source]] = True
        front, found[source] = reached.copy(), {}
        for apart in range(1, _MAX_SYNAPSES_APART + 1):
            hit = (forward @ front).astype(bool)
            for target in groups:
                if target not in found[source] and hit[network.views[target]].any():
                    found[source][target] = apart
            front = hit & ~reached
            reached |= hit
            if not front.any():
                break
    return found


def _draw_map(network: Network, path: Path) -> None:
    """Draw the cells at their positions, or without positions the numbers of synapses between groups."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 7), layout="constrained")
    axes = figure.add_subplot()
    placed = [one for one in network.populations.values() if one.positions_um is not None]
    if placed:
        inhibits = _sources(network, False) > _sources(network, True)
        for one in placed:
            assert one.positions_um is not None
            x, y = one.positions_um[:, :2].T
            shade = np.where(inhibits[network.ids_of(one.label)], "#b03000", "#2060a0")
            axes.scatter(x, y, s=max(0.2, min(20.0, 2e4 / one.size)), c=shade, linewidths=0)
        axes.set(xlabel="x (µm)", ylabel="y (µm)", aspect="equal")
        axes.set_title("cells: red ones mostly inhibit, blue ones excite")
    else:
        groups = {name: network.views[name] for name in _telling(network, _MAX_DRAWN)}
        which = f", the largest {len(groups)} of {len(network.views)}"
        if not groups:
            parts = np.array_split(np.arange(network.size), min(_MAX_DRAWN, max(network.size, 1)))
            groups, which = {f"from {ids[0]}": ids for ids in parts if len(ids)}, " of cells by number"
        counts = _counts_between(network, list(groups.values()))
        norm = LogNorm(0.3, max(2.0, counts.max(initial=0.0)))  # one synapse is grey
        shown = axes.imshow(np.where(counts, counts, np.nan), cmap="Greys", norm=norm)
        axes.set_xticks(range(len(groups)), groups, rotation=90)
        axes.set_yticks(range(len(groups)), groups)
        axes.set(xlabel="to", ylabel="from", title=f"synapses between groups{which}")
        if counts.any():
            figure.colorbar(shown, label="synapses").ax.yaxis.set_major_formatter("{x:g}")
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def _counts_between(network: Network, groups: list[IntArray]) -> np.ndarray:
    pre, post = _ends(network)
    counts = np.zeros((len(groups), len(groups)))
    for row, sources in enumerate(groups):
        targets = np.bincount(post[np.isin(pre, sources)], minlength=network.size)
        counts[row] = [targets[ids].sum() for ids in groups]
    return counts


def _telling(network: Network, most: int = _MAX_GROUPS) -> list[str]:
    """Return the largest groups, without those that contain most of the cells."""
    small = [name for name, ids in network.views.items() if len(ids) <= network.size / 2]
    return sorted(small, key=lambda name: -len(network.views[name]))[:most]


def _ends(network: Network) -> tuple[IntArray, IntArray]:
    """Return the global ids of the sources and of the targets of all synapses."""
    none, offsets = np.empty(0, np.int64), network.offsets
    pre = [offsets[one.pre] + one.pre_index for one in network.projections]
    post = [offsets[one.post] + one.post_index for one in network.projections]
    return np.concatenate([none, *pre]), np.concatenate([none, *post])


def _sources(network: Network, excite: bool) -> IntArray:
    """Return the number of excitatory or of inhibitory synapses of each cell."""
    counts = np.zeros(network.size, np.int64)
    for one in network.projections:
        if one.is_excitatory is excite and not one.is_electrical and one.neuromodulation is None:
            ids = network.offsets[one.pre] + one.pre_index
            counts += np.bincount(ids, minlength=network.size)
    return counts


def _quantiles(degrees: IntArray) -> list[float]:
    return np.quantile(degrees, _QUANTILES).tolist() if len(degrees) else []


def _name(network: Network, cell: int) -> str:
    """Return the smallest group of a cell with its id."""
    own = [name for name, ids in network.views.items() if cell in ids]
    smallest = min(own, key=lambda name: len(network.views[name]), default="")
    return f"{smallest} ({cell})" if smallest else str(cell)


def _lines(name: str, found: dict[str, Any]) -> Iterator[str]:
    yield f"{name}: {', '.join(f'{label}: {what}' for label, what in found['populations'].items())}"
    groups = [f"{group} {size}" for group, size in found["groups"].items()]
    more = f" and {len(groups) - 30} more" if len(groups) > 30 else ""
    yield f"groups: {', '.join(groups[:30]) or 'none'}{more}"
    yield "synapses: " + ", ".join(f"{size} {label}" for label, size in found["synapses"].items())
    yield "cells by sign: " + ", ".join(f"{count} {sign}" for sign, count in found["signs"].items())
    for title, key in (("from", "out_degrees"), ("to", "in_degrees")):
        numbers = ", ".join(f"{value:g}" for value in found[key])
        yield f"synapses {title} a cell (minimum, quartiles, maximum): {numbers}"
    yield "hubs: " + ", ".join(f"{cell} {count}" for cell, count in found["hubs"].items())
    for source, targets in found["synapses_apart"].items():
        reached = ", ".join(f"{target} {apart}" for target, apart in targets.items())
        yield f"synapses on the shortest path from {source} to: {reached or 'none of the groups'}"
    yield from found["remarks"]
