"""Try a drawing: check it with the experiment, and run it."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

from nrp_bibi.writer import bibi_text

from nrp_cockpit.designer.brain.checking import at_interventions, brain_findings, located_in_brain
from nrp_cockpit.designer.brain.document import BrainDocument
from nrp_cockpit.designer.brain.interventions import interventions_of, overrides_of
from nrp_cockpit.designer.checking import located, model_findings
from nrp_cockpit.designer.desk import Desk
from nrp_cockpit.designer.document import Document
from nrp_cockpit.session.findings import finding_data
from nrp_cockpit.session.opening import Opening
from nrp_core.errors import ExperimentError
from nrp_core.findings import InvalidExperimentError

_OF_MODEL = "populations", "parameters"
"""The settings of an experiment that belong to the model of its brain."""
Found = list[dict[str, Any]]


class Trying:
    """Checks and runs the drawings of a desk.

    Args:
        opening: opens runs for the session.
        desk: has the drawings.
    """

    def __init__(self, opening: Opening, desk: Desk) -> None:
        self._opening, self._session, self._desk = opening, opening.session, desk
        self._checking = threading.Lock()

    def check(self) -> Found:
        """Return the mistakes in the present drawing, and in the experiment with it."""
        shown, brain = self._desk.shown, self._desk.new_brain
        if isinstance(shown, BrainDocument):
            found = brain_findings(shown.brain, shown.path) if shown.is_drawn else []
            return found or (located_in_brain(shown.brain, shown.path, self._checked(brain)) if brain else [])
        document = self._desk.functions
        found = model_findings(document.model, document.path)
        if found or not document.model.transfer_function:
            return found
        return located(document.model, document.path, self._checked(brain, document))

    def run(self) -> dict[str, Any]:
        """Restart the session with the drawing; return the mistakes that prevent it."""
        document, brain, session = self._desk.functions, self._desk.new_brain, self._session
        if brain is not None and not brain.is_saved:
            raise ExperimentError(f"save {brain.path.name} first: a run reads its brain from the file")
        if brain is None and not document.model.transfer_function:
            raise ExperimentError("there is nothing to run yet: add a transfer function")
        files = _text_of(document) if document.model.transfer_function else {}
        there = self._there(document) if files else None
        if brain is not None:
            settings = self._settings(brain)
            running = session.functions.texts.items()
            texts = {**{name: text for name, text in running if there is None or name in there}, **files}
            applied = session.ask(lambda: self._opening.anew(settings, texts), "opening the brain")
        else:
            applied = session.ask(lambda: session.functions.apply(files, there), "applying the functions")
        if applied["applied"]:
            if brain is not None:
                self._desk.note_run()
            else:
                session.ask(session.reset, "resetting")
            session.ask(session.play)
        findings = located(document.model, document.path, applied["findings"])
        if brain is not None:
            findings = at_interventions(brain.brain, findings)
        return {"applied": applied["applied"], "findings": findings}

    # --

    def _settings(self, brain: BrainDocument) -> list[str]:
        """Return the settings that give the experiment another brain or other interventions."""
        return [*self._model_settings(brain), *self._intervened(brain)]

    def _intervened(self, brain: BrainDocument) -> list[str]:
        given = brain.brain.intervention
        there = interventions_of(self._desk.original.brain.interventions)
        return [] if given == there else overrides_of(given)

    def _model_settings(self, brain: BrainDocument) -> list[str]:
        files = self._desk.original.brain.files
        if brain.path in files.values() and not brain.is_drawn:
            return []
        model = json.dumps(str(brain.path))  # a text of YAML, whatever the path has
        group = next((f".{name}" for name, path in files.items() if name and path == brain.path), "")
        return [f"brain.model{group}={model}", *(f"brain.{key}{group}=null" for key in _OF_MODEL)]

    def _checked(self, brain: BrainDocument | None, document: Document | None = None) -> Found:
        """Return the findings about the experiment with these settings instead of its own."""
        functions = self._session.functions
        files = _text_of(document) if document else {}
        there = self._there(document) if document else None
        with self._checking:  # it takes a second: several pages wait for each other
            if brain is None:
                return list(functions.check_in(self._session.run.experiment, files, there)["findings"])
            try:
                intervened = self._intervened(brain)
                experiment = self._opening.read_with(intervened) if intervened else self._desk.original
            except InvalidExperimentError as error:
                return [finding_data(each) for each in error.findings]
            if not brain.is_drawn:
                return list(functions.check_in(experiment, files, there)["findings"])
            draft = functions.drafts.write(brain.path, brain.text)
            changed: dict[str, Any] = {key: {} for key in _OF_MODEL if self._model_settings(brain)}
            models = experiment.brain.files
            if "" not in models and brain.path in models.values():
                changed = {
                    "model": {name: draft if path == brain.path else path for name, path in models.items()}
                }
            section = experiment.brain.model_copy(update={"model": draft, **changed})
            drawn = experiment.model_copy(update={"brain": section})
            try:
                return list(functions.check_in(drawn, files, there)["findings"])
            finally:
                functions.drafts.remove([draft])

    def _there(self, document: Document) -> dict[str, Path]:
        """Return the files of the run with this drawing: of all drawings beside it only this one."""
        return self._session.functions.files_with(document.path, self._desk.replaced_by(document))


def _text_of(document: Document) -> dict[str, str]:
    return {str(document.path): bibi_text(document.model)}
