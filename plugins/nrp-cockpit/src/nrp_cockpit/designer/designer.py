"""The designer of a session: its documents, and what the page asks of them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from nrp_bibi.writer import bibi_text

from nrp_cockpit.designer.checking import generated, located, model_findings
from nrp_cockpit.designer.completion import words_for
from nrp_cockpit.designer.connecting import Connecting
from nrp_cockpit.designer.document import Document
from nrp_cockpit.designer.edit import Edit
from nrp_cockpit.designer.graph import Graph
from nrp_cockpit.designer.layout import placed
from nrp_cockpit.designer.metamodel import metamodel_data
from nrp_cockpit.designer.surroundings import surroundings_of
from nrp_cockpit.designer.tree import node_data
from nrp_cockpit.session.live import LiveSession
from nrp_core.errors import ExperimentError

TOPIC = "/cockpit/designer"
NEW = "design.bibi"
_DESIGNED = (".bibi", ".xml", ".py")


class Designer:
    """Draws the transfer functions of a session.

    The state goes to all pages over the wire, so that they show the same; any thread may call the methods.

    Args:
        session: the session, whose brain and world the functions connect.
        file: the model to begin with; None: the first of the experiment that there is.

    Raises:
        ExperimentError: the file cannot be read.
    """

    def __init__(self, session: LiveSession, file: Path | None = None) -> None:
        self._session = session
        self._surroundings = surroundings_of(session.run)
        self._documents: dict[Path, Document] = {}
        self._lock, self._checking = threading.RLock(), threading.Lock()
        self._revision = 0
        self._document: Document | None = None
        if file is not None:
            self._show(file)
        session.hub.offer_json(TOPIC)

    # -- services

    def describe(self) -> dict[str, Any]:
        """Return the metamodel, and send the state to whoever hears it."""
        with self._changing():
            pass
        return metamodel_data()

    def open(self, file: str) -> None:
        """Show another file of the experiment, or a new one."""
        with self._changing():
            self._show(self._place_of(file))

    def do(self, command: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """Change the model; return the path of what was made."""
        with self._changing() as document:
            try:
                document.do(command, **arguments)
            except TypeError as error:
                raise ExperimentError(f"'{command}' does not take this: {error}") from None
            return {"selected": document.selected}

    def undo(self) -> None:
        """Return to the state before."""
        with self._changing() as document:
            document.undo()

    def redo(self) -> None:
        """Return to the state that was left by an undo."""
        with self._changing() as document:
            document.redo()

    def place(self, box: str, x: float, y: float) -> None:
        """Move a box."""
        with self._changing() as document:
            document.place(box, x, y)

    def arrange(self) -> None:
        """Put all boxes into columns."""
        with self._changing() as document:
            document.arrange()

    def show(self, topic: str) -> None:
        """Show a topic that nothing uses."""
        with self._changing() as document:
            document.show(topic)

    def blocks(self, path: str) -> None:
        """Make Python one of blocks."""
        with self._changing() as document:
            document.as_blocks(path)

    def write(self, language: str, text: str) -> dict[str, Any]:
        """Take a text of XML or Python; return its error with its line, if it has one."""
        with self._changing() as document:
            try:
                (document.read_python if language == "python" else document.read_xml)(text)
            except ExperimentError as error:
                return {"error": error.message, "line": error.line}
        return {"error": None, "line": None}

    def save(self) -> None:
        """Write the file."""
        with self._changing() as document:
            document.save()

    def run(self) -> dict[str, Any]:
        """Let the session run from its beginning with this model; return what keeps it from that."""
        document = self._shown()
        if not document.model.transfer_function:
            raise ExperimentError("there is nothing to run yet: add a transfer function")
        session, files = self._session, self._included(document)
        applied: dict[str, Any] = session.ask(
            lambda: session.functions.apply(files), "applying the functions"
        )
        if applied["applied"]:
            session.ask(session.reset, "resetting")
            session.ask(session.play)
        return {**applied, "findings": located(document.model, document.path, applied["findings"])}

    def check(self) -> dict[str, Any]:
        """Return what is wrong with the model, and with the experiment that has it."""
        with self._lock:
            document, revision = self._shown(), self._revision
            model, path = document.model, document.path
            found = model_findings(model, path)
            files = {} if found or not model.transfer_function else self._included(document)
        if files:
            with self._checking:  # it takes a second: several pages wait for each other
                found = located(model, path, self._session.functions.check(files)["findings"])
        return {"revision": revision, "findings": found}

    def fits(self, source: str) -> dict[str, Any]:
        """Return for each end of a connection why it does not fit a source; null: it fits."""
        with self._lock:
            document = self._shown()
            boxes = Graph(document.model, self._surroundings, document.state.shown).boxes
            ends = [end for box in boxes
                    for end in (box["id"], *(row["path"] for row in box.get("rows", ())))]  # fmt: skip
            connecting = Connecting(Edit(document.model, self._surroundings))
            return {"refusals": connecting.refusals(source, ends)}

    def words(self, path: str) -> dict[str, Any]:
        """Return what an editor of expressions proposes inside a function."""
        with self._lock:
            return {"words": list(words_for(self._shown().model, path, self._surroundings))}

    # --

    def _shown(self) -> Document:
        if self._document is None:
            self._show(self._first())
        assert self._document is not None
        return self._document

    def _show(self, path: Path) -> None:
        if path.suffix not in _DESIGNED:
            raise ExperimentError(f"a model ends in .bibi, and Python in .py, not '{path.name}'")
        if path not in self._documents:
            self._documents[path] = Document(path, self._surroundings)
        self._document = self._documents[path]

    def _first(self) -> Path:
        files = [Path(name) for name in self._session.functions.files]
        models = [path for path in files if path.suffix == ".bibi"] or files
        return models[0] if models else self._place_of(NEW)

    def _place_of(self, file: str) -> Path:
        """Return a file by its name, which is relative to the experiment."""
        experiment = self._session.run.experiment.source.place.path
        return (experiment.parent if experiment else Path.cwd()) / file

    def _included(self, document: Document) -> dict[str, str]:
        """Let the run know the file, in place of the one that it was made from, and return its text."""
        origin = document.origin if document.origin != document.path else None
        self._session.functions.include(document.path, instead_of=origin)
        return {str(document.path): bibi_text(document.model)}

    @contextmanager
    def _changing(self) -> Iterator[Document]:
        """Give the document, and send its state."""
        with self._lock:
            yield self._shown()
            self._revision += 1
            self._session.hub.tell(TOPIC, self._state(self._shown()))

    def _state(self, document: Document) -> dict[str, Any]:
        graph = Graph(document.model, self._surroundings, document.state.shown)
        topics = self._surroundings.topics
        return {
            "revision": self._revision,
            "file": str(document.path),
            "origin": None if document.origin is None else str(document.origin),
            "files": [*self._session.functions.files],
            "is_saved": document.is_saved,
            "can_undo": document.can_undo,
            "can_redo": document.can_redo,
            "notes": document.notes,
            "boxes": placed(graph, document.state.moved),
            "wires": graph.wires,
            "model": node_data(document.model),
            "xml": bibi_text(document.model),
            "python": generated(document.model, document.path),
            "populations": dict(self._surroundings.populations),
            "topics": {name: topic.type for name, topic in topics.items()},
        }


Method = Callable[..., Any]


def methods_of(designer: Designer) -> tuple[dict[str, Method], dict[str, Method]]:
    """Return what pages can ask for, by name: what steers, and what only looks."""
    steering = ("open", "do", "undo", "redo", "place", "arrange", "show", "blocks", "write", "save", "run")
    watching = ("describe", "check", "fits", "words")
    return (
        {name: getattr(designer, name) for name in steering},
        {name: getattr(designer, name) for name in watching},
    )
