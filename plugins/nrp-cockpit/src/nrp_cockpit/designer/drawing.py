"""A drawing in progress: its states, with undo, and its file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

from nrp_cockpit.designer.layout import Positions, read_layout
from nrp_core.errors import ExperimentError
from nrp_core.utilities import replace_file

MOST_STATES = 500


@dataclass(frozen=True, slots=True)
class State:
    """A model, and the positions to which its boxes were moved.

    Args:
        model: the model; its lines are those of its canonical text.
        moved: by :func:`~nrp_cockpit.designer.layout.key_of`.
        shown: names of topics that are shown although they are unused.
    """

    model: Any
    moved: Positions = field(default_factory=dict)
    shown: frozenset[str] = frozenset()


class Drawing(ABC):
    """A model and its history.

    Args:
        path: its file, which need not exist.
        model: the model in the file.

    Attributes:
        path: its file.
        origin: the file that it was read from, None: it is new.
        selected: the path of the part that the last command made.
        notes: remarks for the user before saving.
    """

    origin: Path | None = None
    notes: list[str]

    def __init__(self, path: Path, model: Any) -> None:
        self.path = path
        self._on_disk = _on_disk(path)
        self.selected: str | None = None
        moved, problem = read_layout(path)
        self.notes = [*self.notes, *filter(None, [problem])]
        self._states = [State(model, moved)]
        self._now = 0

    @property
    def state(self) -> State:
        """The present state."""
        return self._states[self._now]

    @property
    def can_undo(self) -> bool:
        """Whether an earlier state exists."""
        return self._now > 0

    @property
    def can_redo(self) -> bool:
        """Whether a later state exists."""
        return self._now < len(self._states) - 1

    @property
    @abstractmethod
    def is_saved(self) -> bool:
        """Whether the file holds this model."""

    @abstractmethod
    def do(self, command: str, **arguments: Any) -> None:
        """Change the model by a command.

        Raises:
            ExperimentError: the command does not exist, or it is refused; nothing has changed then.
        """

    @abstractmethod
    def write(self, language: str, text: str) -> None:
        """Take the model of a text.

        Raises:
            ExperimentError: the text is not a model; the error has the line.
        """

    @abstractmethod
    def data(self) -> dict[str, Any]:
        """Return the data that the page draws: boxes, wires, the model, and its texts."""

    @abstractmethod
    def fits(self, source: str) -> dict[str, str | None]:
        """Return for each end of a wire why it does not fit a source; None: it fits."""

    @abstractmethod
    def save(self) -> None:
        """Write the model, and the layout beside it.

        Raises:
            ExperimentError: it cannot be written.
        """

    def _write(self, text: str) -> None:
        """Write the file, unless it has changed since the designer read or wrote it.

        Raises:
            ExperimentError: the file was changed elsewhere, or it cannot be written.
        """
        if _on_disk(self.path) != self._on_disk:
            raise ExperimentError(
                "was changed outside the designer and is not overwritten; open it again", path=self.path
            )
        replace_file(self.path, text)
        self._on_disk = text.encode()

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
        """Move a box.

        Raises:
            ExperimentError: a number is not finite.
        """
        if not (isfinite(x) and isfinite(y)):
            raise ExperimentError(f"a box has a finite place, not ({x:g}, {y:g})")
        self._go(replace(self.state, moved={**self.state.moved, box: (round(x), round(y))}))

    def arrange(self) -> None:
        """Put all boxes back into columns."""
        self._go(replace(self.state, moved={}))

    def _go(self, state: State) -> None:
        self._states = [*self._states[: self._now + 1], state][-MOST_STATES:]
        self._now = len(self._states) - 1


def _on_disk(path: Path) -> bytes | None:
    """Return the content of a file; None if it does not exist or cannot be read."""
    try:
        return path.read_bytes()
    except OSError:
        return None


def command_of(commands: dict[str, Any], name: str) -> Any:
    """Return a command by its name.

    Raises:
        ExperimentError: none was found.
    """
    if name not in commands:
        raise ExperimentError(f"there is no command '{name}'; valid: {', '.join(commands)}")
    return commands[name]
