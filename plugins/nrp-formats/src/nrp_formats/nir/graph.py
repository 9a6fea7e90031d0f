"""The graph in a file: nodes without subgraphs, the edges between them, and the delays of their spikes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.paths import existing_file

Edge = tuple[str, str]


def returning(order: list[str], edges: Iterable[Edge]) -> set[Edge]:
    """Return the edges that close a loop; a spike takes one step on these where the network was trained."""
    after: dict[str, list[str]] = {name: [] for name in order}
    for start, end in edges:
        after[start].append(end)
    found: set[Edge] = set()
    done: set[str] = set()

    def follow(name: str, path: tuple[str, ...]) -> None:
        for end in after[name]:
            if end in (*path, name):
                found.add((name, end))
            elif end not in done:
                follow(end, (*path, name))
        done.add(name)

    for name in order:
        if name not in done:
            follow(name, ())
    return found


def lags_of(order: list[str], shortest: Mapping[Edge, int], late: Mapping[str, int]) -> dict[str, int]:
    """Return the lag of each node, in steps.

    Args:
        order: names of the nodes.
        shortest: for each edge that does not close a loop, its shortest delay in the file, in steps.
        late: 1 for a node on whose voltage an input acts one step after its arrival.
    """
    lags = dict.fromkeys(order, 0)
    for _ in order:
        for (start, end), delay in shortest.items():
            lags[end] = max(lags[end], lags[start] + late[end] + max(1 - delay, 0))
    return lags


_ENDS: Final = frozenset({"Input", "Output"})
_KINDS: Final = {"c": "complex", "b": "of flags", "S": "a text", "U": "a text", "O": "a text"}
_CONVOLUTIONS: Final = frozenset({"Conv1d", "Conv2d"})


@dataclass(frozen=True)
class Graph:
    """Nodes by name, in the order of the file, and edges.

    Args:
        path: the file.
        nodes: objects of the library ``nir``; the nodes of a subgraph ``a`` are named ``a.b``.
        before: names of the source nodes of each node's edges.
        metadata: the file's data on the graph as a whole.
    """

    path: Path
    nodes: dict[str, Any]
    before: dict[str, list[str]]
    metadata: dict[str, Any]

    def error(self, name: str, message: str) -> NetworkError:
        """Return the error about a node."""
        kind = type(self.nodes[name]).__name__
        return NetworkError(f"node '{name}' ({kind}): {message}", path=self.path)


def read_graph(path: Path | str) -> Graph:
    """Read a file.

    Raises:
        NetworkError: it is missing, or is not such a file.
    """
    import nir

    path = existing_file(path)
    try:
        found = _read(nir, path)
    except Exception as error:  # the library raises exceptions of any type
        raise NetworkError(f"is not a NIR file: {str(error) or type(error).__name__}", path=path) from error
    nodes: dict[str, Any] = {}
    edges: list[tuple[str, str]] = []
    _flatten(found, "", nodes, edges)
    before: dict[str, list[str]] = {name: [] for name in nodes}
    for start, end in dict.fromkeys(edges):
        for name in (start, end):
            if name not in nodes:
                raise NetworkError(f"an edge names the node '{name}', which does not exist", path=path)
        before[end].append(start)
    graph = Graph(path, nodes, before, dict(found.metadata))
    for name, node in nodes.items():
        _require_numbers(graph, name, vars(node))
    return graph


def _read(nir: Any, path: Path) -> Any:
    """Return the graph of a file, with no claim about the extent of inputs, which early files do not make."""
    import h5py

    with h5py.File(path, "r") as file:
        nodes = nir.serialization.hdf2dict(file["node"])
    _require_types(nir, "", nodes)
    _forget_extents(nodes)
    return nir.dict2NIRNode({**nodes, "type_check": False})


def _require_types(nir: Any, name: str, node: Any) -> None:
    """Refuse a node of an unknown type; the library would fail without naming it.

    Raises:
        ValueError: one was found.
    """
    kind = node.get("type") if isinstance(node, dict) else None
    types = {each.__name__ for each in vars(nir.ir).values() if isinstance(each, type)}
    if not isinstance(kind, str) or kind not in types:
        owner = f"the node '{name}'" if name else "the graph"
        near = did_you_mean(kind, types) if isinstance(kind, str) else ""
        raise ValueError(f"{owner} is of the type {kind!r}, which does not exist{near}")
    for part, inside in node.get("nodes", {}).items():
        _require_types(nir, f"{name}.{part}".lstrip("."), inside)


def _forget_extents(node: dict[str, Any]) -> None:
    if node.get("type") in _CONVOLUTIONS:
        node["input_shape"] = None
    for part in node.get("nodes", {}).values():
        _forget_extents(part)


def _require_numbers(graph: Graph, name: str, fields: Mapping[str, Any]) -> None:
    """Raise an error unless the arrays of a node are real and finite; a threshold may be infinite.

    Raises:
        NetworkError: a value is a text, a flag, complex, not a number or infinite; or an extent is not one.
    """
    if type(graph.nodes[name]).__name__ in _ENDS:
        _require_extent(graph, name, np.ravel(fields["input_type"]["input"]))
    for field, value in fields.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind in "iu":
            continue
        if value.dtype.kind != "f":
            kind = _KINDS.get(value.dtype.kind, "not numbers")
            raise graph.error(name, f"{field} is {kind}; it must be real")
        wrong = np.isnan(value) if field == "v_threshold" else ~np.isfinite(value)
        if wrong.any():
            place = [int(i) for i in np.argwhere(wrong)[0]]
            raise graph.error(name, f"{field}{place or ''} is {value[wrong][0]}; it must be a finite number")


def _require_extent(graph: Graph, name: str, extent: np.ndarray[Any, Any]) -> None:
    """Raise an error unless the extent of an input or an output is one or several whole numbers above 0.

    Raises:
        NetworkError: it is something else.
    """
    if extent.dtype.kind not in "iuf" or not ((extent > 0) & (extent % 1 == 0)).all():
        shown = extent.tolist()
        raise graph.error(name, f"its shape is {shown!r:.60}; it must be of whole numbers above 0")


def _flatten(graph: Any, prefix: str, nodes: dict[str, Any], edges: list[tuple[str, str]]) -> None:
    """Add a graph to flat nodes and edges.

    An edge to a subgraph leads to its input, an edge from one begins at its output; ``a.b`` is the node ``b``
    of the subgraph ``a``.
    """
    inside: dict[str, Any] = {}
    for name, node in graph.nodes.items():
        if type(node).__name__ == "NIRGraph":
            inside[name] = node
            _flatten(node, f"{prefix}{name}.", nodes, edges)
        else:
            nodes[prefix + name] = node

    def end_of(name: str, side: str, kind: str) -> str:
        found = [*getattr(inside[name], side)] if name in inside else []
        if name in inside and len(found) != 1:
            raise NetworkError(
                f"subgraph '{prefix}{name}' has {len(found)} nodes of kind {kind}; an edge must name one of "
                f"them, such as '{name}.{found[0] if found else kind.lower()}'"
            )
        return ".".join([f"{prefix}{name}", *found])

    for start, end in graph.edges:
        edges.append((end_of(start, "outputs", "Output"), end_of(end, "inputs", "Input")))
