"""How many steps later the spikes of a node come here than where the network was trained.

There, a spike acts on the next layer in the same step; here it takes one step at least. Each node has a lag,
and the delays are such that all inputs of a node have the same lag: then all spikes are the same, shifted by
the lag of their node.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

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
