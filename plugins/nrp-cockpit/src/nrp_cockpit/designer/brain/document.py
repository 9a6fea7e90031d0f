"""A drawn brain, or the network of a script written by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from nrp_cockpit.designer.brain.edit import INTO, BrainEdit
from nrp_cockpit.designer.brain.graph import Box, Wire, drawn_graph, network_graph, placed_brain
from nrp_cockpit.designer.brain.interventions import FIELD, Intervention, yaml_of
from nrp_cockpit.designer.brain.model import Brain
from nrp_cockpit.designer.brain.script import read_script, reason_against, script_of
from nrp_cockpit.designer.changes import refusals
from nrp_cockpit.designer.drawing import Drawing, command_of
from nrp_cockpit.designer.layout import write_layout
from nrp_cockpit.designer.tree import node_data
from nrp_core.errors import ExperimentError
from nrp_core.network.data import Network

BY_HAND = "written by hand and cannot be edited here"


class BrainDocument(Drawing):
    """A brain with the interventions in it, and its history.

    Args:
        path: the script, which need not exist.
        network: the network of the run, shown if the script was not drawn.
        interventions: those in the brain at first; they can be edited in every brain.

    Attributes:
        text: the script.
        is_drawn: whether the designer wrote it and can edit it.

    Raises:
        ExperimentError: the file cannot be read.
    """

    def __init__(
        self, path: Path, network: Network | None = None, interventions: Sequence[Intervention] = ()
    ) -> None:
        self.origin = path if path.exists() else None
        self._network = network
        self._saved = read_text(path) if self.origin else ""
        brain = read_script(self._saved) if self.origin else Brain()
        self.is_drawn = brain is not None
        self.notes = [] if self.is_drawn else [BY_HAND]
        super().__init__(path, replace(brain or Brain(), intervention=tuple(interventions)))

    @property
    def brain(self) -> Brain:
        """The present brain."""
        brain: Brain = self.state.model
        return brain

    @property
    def cells(self) -> list[str]:
        """The names of cells that interventions can mean."""
        if self.is_drawn or self._network is None:
            return [one.name for one in self.brain.population]
        return list(dict.fromkeys((*self._network.populations, *self._network.views)))

    @property
    def text(self) -> str:
        """The present script."""
        return script_of(self.brain) if self.is_drawn else self._saved

    @property
    def is_saved(self) -> bool:
        return self.text == self._saved or (
            self.origin is None and replace(self.brain, intervention=()) == Brain()
        )

    @property
    def graph(self) -> tuple[list[Box], list[Wire]]:
        """The boxes in their places, and the wires."""
        shown: tuple[list[Box], list[Wire]] = ([], [])
        if self.is_drawn:
            shown = drawn_graph(self.brain)
        elif self._network is not None:
            shown = network_graph(self._network)
        return placed_brain(*shown, self.state.moved), shown[1]

    def do(self, command: str, **arguments: Any) -> None:
        if not "/".join(filter(None, map(arguments.get, ("path", "field")))).startswith(FIELD):
            self._require_drawn()
        edit = BrainEdit(self.brain, self.cells)
        command_of({**edit.commands, "connect": edit.connect}, command)(**arguments)
        self._take(edit.model)
        self.selected = edit.selected

    def data(self) -> dict[str, Any]:
        boxes, wires = self.graph
        return {
            "kind": "brain",
            "is_drawn": self.is_drawn,
            "boxes": boxes,
            "wires": wires,
            "model": node_data(self.brain),
            "interventions": yaml_of(self.brain.intervention),
            "cells": self.cells,
            "xml": "",
            "python": {"text": self.text, "lines": [], "error": None},
            "populations": {one.name: one.size for one in self.brain.population},
            "topics": {},
        }

    def fits(self, source: str) -> dict[str, str | None]:
        if not self.is_drawn:
            return {}
        edit = BrainEdit(self.brain, self.cells)
        paths = [end for box in self.graph[0] for end in (box["id"], *(row["path"] for row in box["rows"]))]
        ends = [f"{INTO}{path}" for path in paths] if not source.startswith(INTO) else paths
        return refusals(edit, edit.connect, source, ends)

    def write(self, language: str, text: str) -> None:
        self._require_drawn()
        brain = read_script(text)
        if brain is None:
            reason, line = reason_against(text)
            raise ExperimentError(reason, path=self.path, line=line)
        brain = replace(brain, intervention=self.brain.intervention)
        if brain != self.brain:
            self._take(brain)

    def save(self) -> None:
        self._require_drawn()
        self._write(self.text)
        write_layout(self.path, self.state.moved)
        self._saved, self.origin, self.notes = self.text, self.path, []

    def _require_drawn(self) -> None:
        if not self.is_drawn:
            raise ExperimentError(f"{self.path.name} was {BY_HAND}; draw a new brain")

    def _take(self, brain: Brain) -> None:
        """Keep a brain, with the lines of its parts in its script."""
        again = read_script(script_of(brain)) or brain
        self._go(replace(self.state, model=replace(again, intervention=brain.intervention)))


def read_text(path: Path) -> str:
    """Return the text of a script.

    Raises:
        ExperimentError: it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ExperimentError(f"cannot be read: {error}", path=path) from None
