"""A model that is being drawn: its states, with a way back, and its file."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from nrp_bibi.model.functions import Bibi, BIBITransferFunction, PythonTransferFunction
from nrp_bibi.reader import parse_bibi, read_bibi
from nrp_bibi.reverse import reverse, reverse_file
from nrp_bibi.writer import bibi_text, write_bibi

from nrp_cockpit.designer.checking import generated
from nrp_cockpit.designer.connecting import Connecting
from nrp_cockpit.designer.edit import Edit
from nrp_cockpit.designer.layout import Positions, read_layout, write_layout
from nrp_cockpit.designer.surroundings import Surroundings
from nrp_cockpit.designer.tree import FUNCTIONS, at, replaced
from nrp_core.errors import ExperimentError

_COMMENTS = "comments of the file are not kept when it is saved"
MOST_STATES = 500


@dataclass(frozen=True, slots=True)
class State:
    """A model, and where its boxes were moved to.

    Args:
        model: the model; its lines are those of its canonical XML.
        moved: by :func:`~nrp_cockpit.designer.layout.key_of`.
        shown: names of topics that are shown though nothing uses them.
    """

    model: Bibi
    moved: Positions = field(default_factory=dict)
    shown: frozenset[str] = frozenset()


class Document:
    """A model and its history.

    Args:
        path: the model's file, which need not exist; a Python file becomes a model beside it.
        surroundings: what the model is drawn between.

    Attributes:
        path: where it is saved.
        origin: the file that it was read from, None: it is new.
        selected: the path of what the last command made.
        notes: what saving will not keep.

    Raises:
        TransferFunctionError: the file cannot be read.
    """

    def __init__(self, path: Path, surroundings: Surroundings) -> None:
        self.origin = path if path.exists() else None
        self.path = _beside(path) if path.suffix == ".py" else path
        self.surroundings = surroundings
        self.selected: str | None = None
        model = Bibi()
        if self.origin:
            model = reverse_file(path) if path.suffix == ".py" else read_bibi(path)
        has_comments = self.origin is not None and "<!--" in path.read_text("utf-8", "replace")
        self.notes = [_COMMENTS] if has_comments and path.suffix != ".py" else []
        self._states = [State(canonical(model), read_layout(self.path))]
        self._now = 0
        self._saved = self._states[0].model if self.origin == self.path else Bibi()

    @property
    def state(self) -> State:
        """The state as it is now."""
        return self._states[self._now]

    @property
    def model(self) -> Bibi:
        """The model as it is now."""
        return self.state.model

    @property
    def is_saved(self) -> bool:
        """Whether the file holds this model."""
        return self.model == self._saved and (self.origin is not None or self.model == Bibi())

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier state."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is a later state."""
        return self._now < len(self._states) - 1

    def do(self, command: str, **arguments: Any) -> None:
        """Change the model by a command; see :class:`~nrp_cockpit.designer.edit.Edit`.

        Raises:
            ExperimentError: there is no such command, or it is refused; nothing has changed then.
        """
        edit = Edit(self.model, self.surroundings)
        commands: dict[str, Callable[..., None]] = {
            "set": edit.set, "become": edit.become, "add": edit.add, "write": edit.write,
            "remove": edit.remove, "move": edit.move, "copy": edit.copy,
            "connect": Connecting(edit).connect,
        }  # fmt: skip
        if command not in commands:
            raise ExperimentError(f"there is no command '{command}'; valid: {', '.join(commands)}")
        commands[command](**arguments)
        self._go(replace(self.state, model=canonical(edit.model)))
        self.selected = edit.selected

    def undo(self) -> None:
        """Return to the state before the last command."""
        if not self.can_undo:
            raise ExperimentError("there is nothing to undo")
        self._now -= 1

    def redo(self) -> None:
        """Return to the state that was left by an undo."""
        if not self.can_redo:
            raise ExperimentError("there is nothing to redo")
        self._now += 1

    def place(self, box: str, x: float, y: float) -> None:
        """Move a box."""
        self._go(replace(self.state, moved={**self.state.moved, box: (round(x), round(y))}))

    def arrange(self) -> None:
        """Put all boxes back into columns."""
        self._go(replace(self.state, moved={}))

    def show(self, topic: str) -> None:
        """Show a topic that nothing uses yet."""
        self._go(replace(self.state, shown=self.state.shown | {topic}))

    # -- texts

    def read_xml(self, text: str) -> None:
        """Take the model of a text of XML.

        Raises:
            ExperimentError: it is not a model; the error has the line.
        """
        self._take(parse_bibi(text, self.path))

    def read_python(self, text: str) -> None:
        """Take the functions of a text of Python; those that did not change stay as they are.

        Raises:
            ExperimentError: it is not Python; the error has the line.
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
        """Make a Python function, in place or in a file, one of blocks, as far as blocks can say it.

        Raises:
            ExperimentError: blocks can say nothing of it.
        """
        function = at(self.model, path)
        if not isinstance(function, PythonTransferFunction):
            raise ExperimentError("this is made of blocks already")
        source = self.path.parent / function.src if function.src else None
        made = reverse_file(source) if source else reverse(function.code, self.path)
        if not any(isinstance(one, BIBITransferFunction) for one in made.transfer_function):
            raise ExperimentError("blocks cannot say what this Python does; it stays as it is")
        place = int(path.rpartition("/")[2])
        rest = self.model.transfer_function
        functions = (*rest[:place], *made.transfer_function, *rest[place + 1 :])
        self._take(replaced(self.model, FUNCTIONS, functions))

    def save(self) -> None:
        """Write the model, and the layout beside it.

        Raises:
            ExperimentError: it cannot be written.
        """
        try:
            write_bibi(self.model, self.path)
        except OSError as error:
            raise ExperimentError(f"cannot be written: {error.strerror}", path=self.path) from error
        write_layout(self.path, self.state.moved)
        self._saved, self.origin, self.notes = self.model, self.path, []

    def _take(self, model: Bibi) -> None:
        if model != self.model:
            self._go(replace(self.state, model=canonical(model)))

    def _go(self, state: State) -> None:
        self._states = [*self._states[: self._now + 1], state][-MOST_STATES:]
        self._now = len(self._states) - 1


def canonical(model: Bibi) -> Bibi:
    """Return an equal model whose lines are those of its canonical XML."""
    return parse_bibi(bibi_text(model))


def _same(before: BIBITransferFunction | None, now: Any, document: Document) -> Any:
    """Return the function that was there if it says the same: Python does not tell all that XML does."""
    if before is None:
        return now
    model, path = document.model, document.path
    texts = [generated(replace(model, transfer_function=(one,)), path)["text"] for one in (before, now)]
    return before if len({_without_origins(text) for text in texts}) == 1 else now


def _without_origins(text: str) -> str:
    """Return generated Python without the comments that say where each function comes from."""
    return re.sub(r"(?m)^# \w+: \S+\n", "", text)


def _beside(python: Path) -> Path:
    """Return a file for the model of a Python file that does not exist yet."""
    path = python.with_suffix(".bibi")
    return python.with_suffix(".design.bibi") if path.exists() else path
