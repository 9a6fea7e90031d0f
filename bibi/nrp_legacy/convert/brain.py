"""The brain of an imported experiment: its script, if that means the same there, else the network itself."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.brain.files import save_network
from nrp_core.brain.network import IntArray, Network
from nrp_core.brain.picking import CIRCUIT
from nrp_core.errors import NrpError
from nrp_core.experiment.networks import network_from
from nrp_legacy.brains import NotedNetwork
from nrp_legacy.code import Source, as_of_old
from nrp_legacy.convert.edits import Edits

SCRIPT, NETWORK = "brain.py", "brain.nrpnet"
_SIMULATORS = ("hbp_nrp_cle", "python_cle")


def write_brain(
    path: Path, network: Network, names: list[str], seed: int, folder: Path
) -> tuple[dict[str, Any], list[str]]:
    """Write the brain into a folder; return its section of the experiment file, and what was changed.

    Args:
        path: the file of the brain.
        network: what it means.
        names: the populations that the experiment names.
        seed: of the experiment.
        folder: where to.
    """
    plain = Network(network.populations, network.projections, network.views, network.timestep_ms)
    changed = [f"{path.name}: {note}" for note in getattr(network, "notes", ())]
    if isinstance(network, NotedNetwork) and network.injections:
        changed.append(f"{path.name}: currents that change with time are not part of a network: left out")
    section = _script(path, plain, names, seed, folder)
    if section is not None:
        return section, changed
    (folder / SCRIPT).unlink(missing_ok=True)
    save_network(plain, folder / NETWORK)
    return {"model": NETWORK}, [*changed, f"{path.name} is the network {NETWORK} that it builds"]


def _script(path: Path, network: Network, names: list[str], seed: int, folder: Path) -> dict[str, Any] | None:
    """Return the section for the script itself; None where it does not mean the same by itself."""
    if path.suffix != ".py":
        return None
    try:
        (folder / SCRIPT).write_text(_with_our_simulator(Source.of_file(path).text), encoding="utf-8")
        populations = _populations(network, names)
        with as_of_old():
            own = network_from(folder / SCRIPT, populations=populations, seed=seed)
    except (SyntaxError, NrpError):
        return None
    same_cells = replace(own, views={}).digest == replace(network, views={}).digest
    if not same_cells or any(not _same(own.views, network.views, name) for name in network.views):
        return None
    return {"model": SCRIPT, **({"populations": populations} if populations else {})}


def _same(own: Mapping[str, IntArray], meant: Mapping[str, IntArray], name: str) -> bool:
    return name in own and np.array_equal(own[name], meant[name])


def _with_our_simulator(text: str) -> str:
    edits = Edits(text)
    for node in ast.walk(ast.parse(text)):
        names = getattr(node, "names", [])
        if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] in _SIMULATORS:
            edits.replace(node, f"import nrp_core.pynn as {names[0].asname or names[0].name}")
        elif isinstance(node, ast.Import) and names[0].name.partition(".")[0] in _SIMULATORS:
            edits.replace(node, f"import nrp_core.pynn as {names[0].asname or 'sim'}")
    return edits.done()


def _populations(network: Network, names: list[str]) -> dict[str, str | list[int]]:
    """Return which cells of the circuit have the names of an experiment."""
    circuit = network.views.get(CIRCUIT)
    if circuit is None:
        return {}
    place = {int(neuron): i for i, neuron in enumerate(circuit)}
    found = {
        name: [place[int(one)] for one in network.views[name]] for name in names if name in network.views
    }
    return {name: _short(places) for name, places in found.items() if places}


def _short(places: list[int]) -> str | list[int]:
    step = places[1] - places[0] if len(places) > 1 else 1
    if step > 0 and places == list(range(places[0], places[-1] + 1, step)):
        return f"{places[0]}:{places[-1] + 1}" + (f":{step}" if step > 1 else "")
    return places
