"""The graph in a file: nodes without subgraphs, and the edges between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.errors import NetworkError
from nrp_core.paths import existing_file

INSTALL = "pip install nir"
_CONVOLUTIONS: Final = frozenset({"Conv1d", "Conv2d"})


@dataclass(frozen=True)
class Graph:
    """Nodes by name, in the order of the file, and edges.

    Args:
        path: the file.
        nodes: objects of the library ``nir``; the nodes of a subgraph ``a`` are named ``a.b``.
        before: names of the nodes from which edges come, for each node.
        metadata: what the file says about the graph as a whole.
    """

    path: Path
    nodes: dict[str, Any]
    before: dict[str, list[str]]
    metadata: dict[str, Any]

    def error(self, name: str, message: str) -> NetworkError:
        """Return the error about a node."""
        kind = type(self.nodes[name]).__name__
        return NetworkError(f"node '{name}' ({kind}): {message}", path=self.path)


def library() -> Any:
    """Return the module ``nir``.

    Raises:
        NetworkError: it is not installed.
    """
    try:
        import nir
    except ImportError as error:
        raise NetworkError(f"files of NIR need the library nir ({error}); try: {INSTALL}") from error
    return nir


def read_graph(path: Path | str) -> Graph:
    """Read a file.

    Raises:
        NetworkError: it is missing, or is not such a file; or ``nir`` is not installed.
    """
    path = existing_file(path)
    nir = library()
    try:
        found = _read(nir, path)
    except Exception as error:  # the library raises whatever it meets
        raise NetworkError(f"is not a NIR file: {error or type(error).__name__}", path=path) from error
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
    _forget_extents(nodes)
    return nir.dict2NIRNode({**nodes, "type_check": False})


def _forget_extents(node: dict[str, Any]) -> None:
    if node.get("type") in _CONVOLUTIONS:
        node["input_shape"] = None
    for part in node.get("nodes", {}).values():
        _forget_extents(part)


def _require_numbers(graph: Graph, name: str, fields: Mapping[str, Any]) -> None:
    """Raise an error unless the arrays of a node are real and finite; a threshold may be infinite.

    Raises:
        NetworkError: a value is complex, not a number or infinite.
    """
    for field, value in fields.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fc":
            continue
        if value.dtype.kind == "c":
            raise graph.error(name, f"{field} is complex; it must be real")
        wrong = np.isnan(value) if field == "v_threshold" else ~np.isfinite(value)
        if wrong.any():
            place = [int(i) for i in np.argwhere(wrong)[0]]
            raise graph.error(name, f"{field}{place or ''} is {value[wrong][0]}; it must be a finite number")


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
