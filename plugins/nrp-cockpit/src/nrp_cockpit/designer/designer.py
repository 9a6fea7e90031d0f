"""The designer of a session, with the services for its page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from nrp_cockpit.designer.brain.model import Brain
from nrp_cockpit.designer.desk import Desk
from nrp_cockpit.designer.drawing import Drawing
from nrp_cockpit.designer.metamodel import classes_data, metamodel_data
from nrp_cockpit.designer.trying import Trying
from nrp_cockpit.session.opening import Opening
from nrp_core.errors import ExperimentError

TOPIC = "/cockpit/designer"


class Designer:
    """Draws the transfer functions and the brain of a session.

    All pages get the same state over the wire; any thread may call the methods.

    Args:
        opening: opens runs for the session.
        file: the file to open first; None: the first existing model of the experiment.

    Raises:
        ExperimentError: the file cannot be read.
    """

    def __init__(self, opening: Opening, file: Path | None = None) -> None:
        self._session = opening.session
        self._desk = Desk(self._session)
        self._trying = Trying(opening, self._desk)
        self._lock = threading.RLock()
        self._revision = 0
        if file is not None:
            self._desk.open(file)
        self._session.hub.offer_json(TOPIC)

    # -- services

    def describe(self) -> dict[str, Any]:
        """Return the classes of both kinds of models, and send the state to its subscribers."""
        with self._changing():
            pass
        return {"functions": metamodel_data(), "brain": {"classes": classes_data(Brain), "devices": {}}}

    def open(self, file: str) -> None:
        """Show another file of the experiment, or a new one."""
        with self._changing():
            self._desk.open(self._desk.place_of(file))

    def turn(self, to: str) -> None:
        """Show the drawing of the functions or of the brain, or a new drawing of a brain."""
        turns = {"functions": self._desk.show_functions, "brain": self._desk.show_brain,
                 "new brain": self._desk.draw_brain}  # fmt: skip
        if to not in turns:
            raise ExperimentError(f"'{to}' cannot be drawn; valid: {', '.join(turns)}")
        with self._changing():
            turns[to]()

    def do(self, command: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """Change the model; return the path of the new part."""
        with self._changing() as drawing:
            try:
                drawing.do(command, **arguments)
            except TypeError as error:
                raise ExperimentError(f"wrong arguments for '{command}': {error}") from None
            return {"selected": drawing.selected}

    def undo(self) -> None:
        """Return to the state before."""
        with self._changing() as drawing:
            drawing.undo()

    def redo(self) -> None:
        """Return to the state before the last undo."""
        with self._changing() as drawing:
            drawing.redo()

    def place(self, box: str, x: float, y: float) -> None:
        """Move a box."""
        with self._changing() as drawing:
            drawing.place(box, x, y)

    def arrange(self) -> None:
        """Put all boxes into columns."""
        with self._changing() as drawing:
            drawing.arrange()

    def show(self, topic: str) -> None:
        """Show an unused topic."""
        with self._changing():
            self._desk.functions.show(topic)

    def blocks(self, path: str) -> None:
        """Convert a Python function to blocks."""
        with self._changing():
            self._desk.functions.as_blocks(path)

    def write(self, language: Literal["xml", "python"], text: str) -> dict[str, Any]:
        """Replace the model by XML or Python text; return the error and its line, if any."""
        with self._changing() as drawing:
            try:
                drawing.write(language, text)
            except ExperimentError as error:
                return {"error": error.message, "line": error.line}
        return {"error": None, "line": None}

    def save(self) -> None:
        """Write the file."""
        with self._changing() as drawing:
            drawing.save()

    def run(self) -> dict[str, Any]:
        """Restart the run with the drawn model; return the findings that prevent it."""
        found = self._trying.run()
        with self._changing():
            return found

    def check(self) -> dict[str, Any]:
        """Return the findings about the model shown and about its experiment."""
        revision = self._revision
        return {"revision": revision, "findings": self._trying.check()}

    def fits(self, source: str) -> dict[str, Any]:
        """Return for each end why a source cannot be connected to it; null: it can."""
        with self._lock:
            return {"refusals": self._desk.shown.fits(source)}

    def words(self, path: str) -> dict[str, Any]:
        """Return the words that an expression editor suggests inside a function."""
        with self._lock:
            return {"words": self._desk.functions.words(path)}

    # --

    @contextmanager
    def _changing(self) -> Iterator[Drawing]:
        """Give the drawing shown, and send the state afterwards."""
        with self._lock:
            yield self._desk.shown
            self._revision += 1
            self._session.hub.send_json(TOPIC, self._state(self._desk.shown))

    def _state(self, drawing: Drawing) -> dict[str, Any]:
        return {
            "revision": self._revision,
            "file": str(drawing.path),
            "origin": None if drawing.origin is None else str(drawing.origin),
            "files": self._desk.files,
            "is_saved": drawing.is_saved,
            "can_undo": drawing.can_undo,
            "can_redo": drawing.can_redo,
            "notes": drawing.notes,
            **drawing.data(),
        }


Method = Callable[..., Any]


def methods_of(designer: Designer) -> tuple[dict[str, Method], dict[str, Method]]:
    """Return the services for pages by name: those that change the model, and those that only read."""
    steering = (
        "open",
        "turn",
        "do",
        "undo",
        "redo",
        "place",
        "arrange",
        "show",
        "blocks",
        "write",
        "save",
        "run",
    )
    watching = ("describe", "check", "fits", "words")
    return (
        {name: getattr(designer, name) for name in steering},
        {name: getattr(designer, name) for name in watching},
    )
