"""Somebody who draws a brain with commands, and the brain of the paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nrp_cockpit.designer.brain.document import BrainDocument

HUSKY_CELL = {
    "cm": 0.025, "tau_m": 10, "tau_refrac": 10, "v_rest": -60.5, "v_thresh": -60, "v_reset": -60.5,
    "tau_syn_E": 2.5, "tau_syn_I": 2.5, "e_rev_I": -75, "initial_v": -60.5,
}  # fmt: skip
"""The cells of the paper's brain."""
LAW = {"U": 1, "tau_rec": 1, "tau_facil": 1, "delay": 0.1}


class Artist:
    """Somebody who draws a brain."""

    def __init__(self, path: Path) -> None:
        self.document = BrainDocument(path)

    def do(self, command: str, **arguments: Any) -> str:
        self.document.do(command, **arguments)
        return str(self.document.selected)

    def set(self, path: str, **values: Any) -> None:
        for field, value in values.items():
            self.do("set", path=path, field=field, text=str(value))

    def population(self, name: str, size: int, **cell: Any) -> str:
        path = self.do("add", path="", field="population")
        self.set(path, name=name, size=size)
        self.do("become", path=f"{path}/cells", type="IF_cond_alpha")
        self.set(f"{path}/cells", **cell)
        return path

    def projection(self, source: str, target: str, weight: float, receptor: str = "excitatory") -> str:
        path = self.do("connect", source=source, target=f"into:{target}")
        self.do("become", path=f"{path}/synapse", type="TsodyksMarkramSynapse")
        self.set(f"{path}/synapse", weight=weight, **LAW)
        self.set(path, receptor=receptor)
        return path


def draw_the_brain_of_the_paper(artist: Artist) -> None:
    """Draw the eight cells of ``braitenberg_husky``, in populations by what they do."""
    sensors = artist.population("sensors", 5, **HUSKY_CELL)
    spontaneous = artist.population("spontaneous", 1, **{**HUSKY_CELL, "v_thresh": -60.51, "v_reset": -61.6})
    actors = artist.population("actors", 2, **HUSKY_CELL)
    artist.projection(f"{sensors}[2:3]", f"{actors}[1:2]", 1.5e-4)
    artist.projection(f"{sensors}[3:4]", f"{actors}[0:1]", 1.5e-4)
    artist.projection(f"{sensors}[4:5]", f"{actors}[1:2]", 1.05e-4)
    artist.projection(spontaneous, f"{actors}[1:2]", 1.4e-4)
    artist.projection(f"{sensors}[0:2]", f"{sensors}[4:5]", 1.2e-3, "inhibitory")
    artist.projection(f"{sensors}[0:2]", spontaneous, 1.2e-3, "inhibitory")
