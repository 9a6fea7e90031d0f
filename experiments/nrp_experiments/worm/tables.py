"""Make the tables of the worm of ``cect/cache/Cook2019HermReader.json`` in the wheel of cect.

python -m nrp_experiments.worm.tables cect/cache/Cook2019HermReader.json FOLDER
"""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path

GABA = {"AVL", "DVB", "RIS", "RMED", "RMEV", "RMEL", "RMER"}
GABA |= {f"DD{i}" for i in range(1, 7)} | {f"VD{i}" for i in range(1, 14)}
APART = {"CANL", "CANR"}
"""Neurons without a synapse."""


def write(path: Path, rows: Iterable[tuple[object, ...]]) -> None:
    """Write rows as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def is_neuron(cell: str) -> bool:
    """Return whether a cell is a neuron: muscles have lower case, or are named as glia are."""
    return cell.isupper() and not re.match("GLR|M[DV][LR]", cell)


def main(source: Path, folder: Path) -> None:
    """Write ``neurons.csv``, ``edges.csv`` between neurons, and ``muscles.csv`` from neurons to muscles."""
    worm = json.loads(source.read_text("utf-8"))
    cells = worm["nodes"]
    synapses = [
        (pre, post, int(number))
        for pre, row in zip(cells, worm["connections"]["Generic_CS"], strict=True)
        for post, number in zip(cells, row, strict=True)
        if number
    ]
    ends = {end for synapse in synapses for end in synapse[:2]}
    neurons = {cell for cell in ends if is_neuron(cell)} | APART
    among = [synapse for synapse in synapses if neurons.issuperset(synapse[:2])]
    onto = [synapse for synapse in synapses if synapse[0] in neurons and re.match("M[DV][LR]", synapse[1])]
    write(folder / "edges.csv", [("pre", "post", "weight"), *among])
    write(folder / "muscles.csv", [("pre", "post", "weight"), *onto])
    transmitters = [(cell, "gaba" if cell in GABA else "") for cell in sorted(neurons)]
    write(folder / "neurons.csv", [("name", "transmitter"), *transmitters])


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
