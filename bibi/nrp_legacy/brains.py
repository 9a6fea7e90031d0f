"""Brains as experiments name and slice them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from nrp_core.brain.network import IntArray, Network
from nrp_core.brain.script import load_network
from nrp_core.errors import NetworkError
from nrp_core.xml_tree import Element
from nrp_legacy.code import Source, as_of_old
from nrp_legacy.elements import attribute, children, local, number
from nrp_legacy.pynn07 import add_spellings

CIRCUIT = "circuit"
_SIMULATORS = ("hbp_nrp_cle.brainsim.simulator", "python_cle.brainsim.simulator")


def load_brain(path: Path, populations: Mapping[str, Element], seed: int) -> Network:
    """Return the network of a brain file, with the names that an experiment gives its neurons.

    Args:
        path: the file.
        populations: elements that choose neurons of the file's ``circuit``, by the names for them.
        seed: all that is random follows from it.

    Raises:
        NetworkError: the file cannot be turned into a network.
    """
    if path.suffix != ".py":
        raise NetworkError(f"brains are read from .py files, not from '{path.name}'", path=path)
    code = Source.of_file(path).compiled(_unheard)
    with as_of_old():
        network = load_network(path, seed=seed, simulators=_SIMULATORS, code=code, adapt=add_spellings)
    views = dict(network.views)
    for name, chosen in populations.items():
        ids = _chosen(chosen, name, views)
        if ids is not None and ids.size:
            views[name] = ids
    return replace(network, views=views)


def remark(
    path: Path, populations: Mapping[str, Element], network: Network, notes: Callable[[str], None]
) -> None:
    """Tell what was converted in a brain file, and which names mean nothing in the network it became."""
    Source.of_file(path).compiled(notes)
    for name in populations:
        if name not in (*network.views, *network.populations):
            notes(f"population '{name}' has no neurons in {path.name}")


def _unheard(note: str) -> None:
    """Tell nobody."""


def _chosen(element: Element, name: str, views: Mapping[str, IntArray]) -> IntArray | None:
    """Return the neurons that an element picks, None where it only names what the file has."""
    circuit = views.get(CIRCUIT)
    kind = local(attribute(element, "type") or "")
    if circuit is None:
        return None
    listed = children(element, "element")
    if kind == "List" or listed:
        places = np.array([int(one.text) for one in listed], dtype=np.int64)
        return circuit[places[places < len(circuit)]]
    index, begin = number(element, "index"), number(element, "from")
    if index is not None:
        return circuit[int(index) : int(index) + 1]
    if kind == "Range" or begin is not None:
        end, step = number(element, "to"), number(element, "step")
        return circuit[int(begin or 0) : None if end is None else int(end) : int(step or 1)]
    return None if name in views else circuit
