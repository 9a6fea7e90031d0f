"""The drawings that are open: one of transfer functions, and one of the brain."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import count
from pathlib import Path

from nrp_bibi.model.functions import Bibi
from nrp_bibi.reader import parse_bibi
from nrp_bibi.reverse import reverse

from nrp_cockpit.designer.brain.document import BrainDocument, read_text
from nrp_cockpit.designer.brain.interventions import interventions_of
from nrp_cockpit.designer.brain.script import read_script
from nrp_cockpit.designer.document import Document
from nrp_cockpit.designer.drawing import Drawing
from nrp_cockpit.designer.surroundings import Surroundings, surroundings_of
from nrp_cockpit.session.live import LiveSession
from nrp_core.errors import ExperimentError

NEW, NEW_BRAIN = "design.bibi", "drawn_brain.py"
_DESIGNED = (".bibi", ".xml", ".py")


class Desk:
    """Holds the drawings of a session; each keeps its history while another is shown.

    Args:
        session: the session, whose brain and world the functions connect.

    Attributes:
        shown: the drawing that the page shows.
        original: the experiment before a brain was drawn for it.
    """

    def __init__(self, session: LiveSession) -> None:
        self._session = session
        self.original = session.run.experiment
        self._drawings: dict[Path, Drawing] = {}
        self._functions: Document | None = None
        self._brain: BrainDocument | None = None
        self._shown: BrainDocument | None = None
        self.note_run()

    def note_run(self) -> None:
        """Note that the session has another run."""
        self._surroundings = surroundings_of(self._session.run)
        self._built = next(iter(self._session.run.experiment.brain.files.values()))
        self._built_from = _script_at(self._built)
        self._built_with = interventions_of(self._session.run.experiment.brain.interventions)

    @property
    def shown(self) -> Drawing:
        """The drawing that the page shows; at first that of the functions."""
        return self._shown or self.functions

    @property
    def functions(self) -> Document:
        """The drawing of transfer functions, between the present brain and world."""
        if self._functions is None:
            files = [Path(name) for name in self._session.functions.files]
            models = [path for path in files if path.suffix == ".bibi"] or files
            self._functions = self._document(models[0] if models else self.place_of(NEW))
        self._functions.surroundings = replace(self._around(), others=self._others(self._functions))
        return self._functions

    @property
    def files(self) -> list[str]:
        """The files that can be shown in place of this one: with functions, or brains."""
        if isinstance(self.shown, Document):
            opened = [str(path) for path, one in self._drawings.items() if isinstance(one, Document)]
            return list(dict.fromkeys((*self._session.functions.files, *opened)))
        drawn = [path for path, one in self._drawings.items() if isinstance(one, BrainDocument)]
        return [str(path) for path in dict.fromkeys((*self.original.brain.files.values(), *drawn))]

    @property
    def new_brain(self) -> BrainDocument | None:
        """The brain that was chosen, drawn or that of the experiment, if the run has another one.

        One with other interventions is another one.
        """
        brain = self._brain
        if brain is None:
            return None
        chosen = brain.path, brain.text, brain.brain.intervention
        if chosen == (self._built, self._built_from, self._built_with):
            return None
        is_original = brain.path in self.original.brain.files.values()
        return brain if is_original or (brain.is_drawn and brain.brain.population) else None

    def replaced_by(self, document: Document) -> set[Path]:
        """Return the files that do not count where a drawing is checked or run.

        It is the file that it was made from, and the other drawings that are not of the experiment.
        """
        own = self.original.transfer_functions
        others = (one for one in self._drawings.values() if isinstance(one, Document) and one is not document)
        replaced = {one.path for one in others if one.path not in own and one.origin not in own}
        if document.origin is not None and document.origin != document.path:
            replaced.add(document.origin)
        return replaced

    def open(self, path: Path) -> None:
        """Show a file.

        Raises:
            ExperimentError: it is neither a model nor Python, or cannot be read.
        """
        if path in (self._built, *self.original.brain.files.values()) or (
            path.suffix == ".py" and read_script(_script_at(path)) is not None
        ):
            self._show_brain(path)
            return
        self._functions, self._shown = self._document(path), None

    def show_functions(self) -> None:
        """Show the drawing of the transfer functions."""
        self._shown = None

    def show_brain(self) -> None:
        """Show the brain: its existing drawing, or that of the run."""
        self._show_brain(self._brain.path if self._brain else self._built)

    def draw_brain(self) -> None:
        """Show a new drawing of a brain, or continue with an unfinished one."""
        names = (NEW_BRAIN if i == 1 else NEW_BRAIN.replace(".", f"_{i}.") for i in count(1))
        paths = (self.place_of(name) for name in names)
        self._show_brain(next(
            path for path in paths if not path.exists() or read_script(_script_at(path)) is not None
        ))  # fmt: skip

    def place_of(self, file: str) -> Path:
        """Return a file by its name, which is relative to the experiment.

        Raises:
            ExperimentError: it is a folder, or a pipe or a device, which could be read for ever.
        """
        experiment = self._session.run.experiment.source.place.path
        place = (experiment.parent if experiment else Path.cwd()) / file
        if place.exists() and not place.is_file():
            raise ExperimentError("not a file", path=place)
        return place

    # --

    def _show_brain(self, path: Path) -> None:
        if path not in self._drawings:
            run = self._session.run
            is_whole = path == self._built and len(run.experiment.brain.files) == 1
            network = run.brain.network if is_whole else None
            self._drawings[path] = BrainDocument(
                path, network, interventions_of(self.original.brain.interventions)
            )
        found = self._drawings[path]
        assert isinstance(found, BrainDocument)
        self._shown = self._brain = found

    def _document(self, path: Path) -> Document:
        if path.suffix not in _DESIGNED:
            raise ExperimentError(f"a model ends in .bibi, and Python in .py, not '{path.name}'")
        if path not in self._drawings:
            self._drawings[path] = Document(path, self._around())
        found = self._drawings[path]
        assert isinstance(found, Document)
        return found

    def _others(self, document: Document) -> dict[str, Bibi]:
        """Return the models of the files that run beside a drawing: as drawn, or else as they run."""
        texts = self._session.functions.texts
        drawn = {str(one.origin): one.model for one in self._drawings.values() if isinstance(one, Document)}
        own = {str(document.path), str(document.origin)}
        return {
            name: drawn[name] if name in drawn else _model_of(name, text)
            for name, text in texts.items()
            if name not in own
        }

    def _around(self) -> Surroundings:
        """Return the brain and world between which functions are drawn; a drawn brain need not run."""
        brain = self.new_brain
        if brain is None or not brain.is_drawn:
            return self._surroundings
        return replace(self._surroundings, populations={one.name: one.size for one in brain.brain.population})


@lru_cache(maxsize=32)
def _model_of(name: str, text: str) -> Bibi:
    """Return the model of the text of a file; an empty model if the text is not one."""
    path = Path(name)
    try:
        return reverse(text, path) if path.suffix == ".py" else parse_bibi(text, path)
    except ExperimentError:
        return Bibi()


def _script_at(path: Path) -> str:
    """Return the text of a script; empty if it cannot be read."""
    try:
        return read_text(path) if path.suffix == ".py" else ""
    except ExperimentError:
        return ""
