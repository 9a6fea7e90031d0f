"""A model of transfer functions in the designer."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from nrp_bibi.model.functions import Bibi, BIBITransferFunction, PythonTransferFunction
from nrp_bibi.reader import parse_bibi, read_bibi
from nrp_bibi.reverse import reverse, reverse_file
from nrp_bibi.writer import bibi_text

from nrp_cockpit.designer.changes import refusals
from nrp_cockpit.designer.checking import generated
from nrp_cockpit.designer.completion import words_for
from nrp_cockpit.designer.connecting import Connecting
from nrp_cockpit.designer.drawing import Drawing, command_of
from nrp_cockpit.designer.edit import Edit
from nrp_cockpit.designer.graph import Graph
from nrp_cockpit.designer.layout import placed, write_layout
from nrp_cockpit.designer.surroundings import Surroundings
from nrp_cockpit.designer.tree import FUNCTIONS, at, node_data, replaced
from nrp_core.errors import ExperimentError, did_you_mean

_COMMENTS = "saving removes the comments of this file"


class Document(Drawing):
    """A model of transfer functions and its history.

    Args:
        path: the model's file, which need not exist; a Python file becomes a model beside it.
        surroundings: the topics and populations around the model.

    Raises:
        TransferFunctionError: the file cannot be read.
    """

    def __init__(self, path: Path, surroundings: Surroundings) -> None:
        self.origin = path if path.exists() else None
        self.surroundings = surroundings
        model = Bibi()
        if self.origin:
            model = reverse_file(path) if path.suffix == ".py" else read_bibi(path)
        has_comments = self.origin is not None and "<!--" in path.read_text("utf-8", "replace")
        self.notes = [_COMMENTS] if has_comments and path.suffix != ".py" else []
        super().__init__(_beside(path) if path.suffix == ".py" else path, canonical(model))
        self._saved = self.model if self.origin == self.path else Bibi()

    @property
    def model(self) -> Bibi:
        """The present model."""
        model: Bibi = self.state.model
        return model

    @property
    def is_saved(self) -> bool:
        return self.model == self._saved and (self.origin is not None or self.model == Bibi())

    def do(self, command: str, **arguments: Any) -> None:
        edit = Edit(self.model, self.surroundings)
        commands: dict[str, Callable[..., None]] = {
            **edit.commands, "write": edit.write, "connect": Connecting(edit).connect,
        }  # fmt: skip
        command_of(commands, command)(**arguments)
        self._go(replace(self.state, model=canonical(edit.model)))
        self.selected = edit.selected

    def show(self, topic: str) -> None:
        """Show an unused topic.

        Raises:
            ExperimentError: the world has no such topic.
        """
        topics = self.surroundings.topics
        if topic not in topics:
            raise ExperimentError(f"the world has no topic '{topic}'{did_you_mean(topic, topics)}")
        self._go(replace(self.state, shown=self.state.shown | {topic}))

    def data(self) -> dict[str, Any]:
        graph, topics = self._graph(), self.surroundings.topics
        return {
            "kind": "functions",
            "is_drawn": True,
            "boxes": placed(graph, self.state.moved),
            "wires": graph.wires,
            "model": node_data(self.model),
            "xml": bibi_text(self.model),
            "python": generated(self.model, self.path),
            "populations": dict(self.surroundings.populations),
            "topics": {name: topic.type for name, topic in topics.items()},
        }

    def fits(self, source: str) -> dict[str, str | None]:
        written = ("python", "other")  # they are wired in their text
        boxes = [box for box in self._graph().boxes if box["kind"] not in written]
        ends = [end for box in boxes
                for end in (box["id"], *(row["path"] for row in box.get("rows", ())))]  # fmt: skip
        edit = Edit(self.model, self.surroundings)
        return refusals(edit, Connecting(edit).connect, source, ends)

    def words(self, path: str) -> list[dict[str, str]]:
        """Return the words that an expression editor suggests inside a function."""
        return list(words_for(self.model, path, self.surroundings))

    def _graph(self) -> Graph:
        return Graph(self.model, self.surroundings, self.state.shown)

    # -- texts

    def write(self, language: str, text: str) -> None:
        (self.read_python if language == "python" else self.read_xml)(text)

    def read_xml(self, text: str) -> None:
        """Replace the model by that of an XML text.

        Raises:
            ExperimentError: the text is not a model; the error has the line.
        """
        self._take(parse_bibi(text, self.path))

    def read_python(self, text: str) -> None:
        """Replace the functions by those of a Python text; unchanged ones stay the same.

        Raises:
            ExperimentError: the text is not Python; the error has the line.
        """
        before = {
            one.name: one for one in self.model.transfer_function if isinstance(one, BIBITransferFunction)
        }
        found = tuple(
            _same(before.get(getattr(one, "name", "")), one, self)
            for one in reverse(_without_origins(text), self.path).transfer_function
        )
        self._take(replace(self.model, transfer_function=found))

    def as_blocks(self, path: str) -> None:
        """Convert a Python function, in the model or in a file, to blocks, as far as possible.

        Raises:
            ExperimentError: no function in it can be expressed as blocks.
        """
        function = at(self.model, path)
        if not isinstance(function, PythonTransferFunction):
            raise ExperimentError("this function already consists of blocks")
        source = self.path.parent / function.src if function.src else None
        made = reverse_file(source) if source else reverse(function.code, self.path)
        if not any(isinstance(one, BIBITransferFunction) for one in made.transfer_function):
            raise ExperimentError("this Python function cannot be expressed as blocks; it is unchanged")
        place = int(path.rpartition("/")[2])
        rest = self.model.transfer_function
        functions = (*rest[:place], *made.transfer_function, *rest[place + 1 :])
        self._take(replaced(self.model, FUNCTIONS, functions))

    def save(self) -> None:
        self._write(bibi_text(self.model))
        write_layout(self.path, self.state.moved)
        self._saved, self.origin, self.notes = self.model, self.path, []

    def _take(self, model: Bibi) -> None:
        if model != self.model:
            self._go(replace(self.state, model=canonical(model)))


def canonical(model: Bibi) -> Bibi:
    """Return an equal model whose lines are those of its canonical XML."""
    return parse_bibi(bibi_text(model))


def _same(before: BIBITransferFunction | None, now: Any, document: Document) -> Any:
    """Return the old function if both generate the same Python, which holds less than the XML."""
    if before is None:
        return now
    model, path = document.model, document.path
    texts = [generated(replace(model, transfer_function=(one,)), path)["text"] for one in (before, now)]
    return before if len({_without_origins(text) for text in texts}) == 1 else now


def _without_origins(text: str) -> str:
    """Return generated Python without the comments that name the source of each function."""
    return re.sub(r"(?m)^# \w+: \S+\n", "", text)


def _beside(python: Path) -> Path:
    """Return a file for the model of a Python file that does not exist yet."""
    path = python.with_suffix(".bibi")
    return python.with_suffix(".design.bibi") if path.exists() else path
