"""The brain of a simulation and its populations: read and exchanged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from nrp_legacy.code import Source
from nrp_legacy.documents import attribute, children, number
from nrp_legacy.maker import LegacyMaker, ShimmedMaker

from hbp_nrp_virtual_coach.functions import Functions
from hbp_nrp_virtual_coach.runner import STARTED, Runner
from hbp_nrp_virtual_coach.settings import log
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Experiment, Run
from nrp_core.findings import Code
from nrp_core.xml import Element

Selection: TypeAlias = dict[str, Any] | list[int] | int | str | None
_BOUNDS = ("from", "to", "step")
_TAG, _ALL = "populations", "Population"


def populations_of(experiment: Experiment) -> dict[str, Selection]:
    """Return the populations that an experiment names, with their neurons in the circuit."""
    maker = experiment.maker
    if isinstance(maker, LegacyMaker):
        return {name: _selection(element) for name, element in maker.bibi.populations.items()}
    return dict(experiment.brain.populations)


def with_brain(
    experiment: Experiment, model: Path | None, populations: Mapping[str, Selection] | None
) -> Experiment:
    """Return an experiment with another brain, other populations, or both.

    Raises:
        ExperimentError: a population is not a selection of neurons.
    """
    changes: dict[str, Any] = {} if model is None else {"model": model}
    maker = experiment.maker
    if populations is not None and isinstance(maker, LegacyMaker):
        elements = {name: _element(name, one, maker.bibi.element.path) for name, one in populations.items()}
        maker.bibi = replace(maker.bibi, populations=elements)
    elif populations is not None:
        changes["populations"] = dict(populations)
    brain = experiment.brain.model_copy(update=changes)
    return experiment.model_copy(update={"brain": brain})


def first_file(experiment: Experiment) -> Path:
    """Return the file of the brain, of several models that of the first."""
    return next(iter(experiment.brain.files.values()))


def _selection(element: Element) -> Selection:
    listed, index = children(element, "element"), number(element, "index")
    if listed:
        return [int(one.text) for one in listed]
    if index is not None:
        return int(index)
    bounds = {name: number(element, name) for name in _BOUNDS}
    return {name: int(value) for name, value in bounds.items() if value is not None} or attribute(
        element, "type"
    )


def _element(name: str, chosen: Selection, path: Path) -> Element:
    element = Element(_TAG, {"population": name}, path, 0)
    if isinstance(chosen, dict) and set(chosen) <= set(_BOUNDS):
        given = {key: str(int(value)) for key, value in chosen.items() if value is not None}
        return replace(element, attributes={**element.attributes, "type": "Range", **given})
    if isinstance(chosen, list):
        listed = [Element("element", {}, path, 0, text=str(int(index))) for index in chosen]
        return replace(element, attributes={**element.attributes, "type": "List"}, children=listed)
    if isinstance(chosen, int):
        return replace(element, attributes={**element.attributes, "index": str(chosen)})
    if chosen in (None, _ALL):
        return replace(element, attributes={**element.attributes, "type": _ALL})
    raise ExperimentError(
        f"population '{name}' must be a dict with from, to, step, a list, or an index, not {chosen!r}",
        subject=name,
    )


class BrainEdits(Functions):
    """The part of a simulation that deals with its brain."""

    _model: Path | None = None
    _populations: Mapping[str, Selection] | None = None

    def get_brain(self) -> str:
        """Return the source of the brain.

        Raises:
            ExperimentError: it is not a script.
        """
        path = self._runner.call(lambda run: first_file(run.experiment))
        if path.suffix != ".py":
            raise ExperimentError("the brain is not a script", path=path)
        return Source.of_file(path).text

    def edit_brain(self, brain_script: str) -> None:
        """Build another brain; the simulation begins again at time 0 with the transfer functions that it has.

        Raises:
            NrpError: the brain cannot be built; the simulation restarts with its previous brain.
        """
        self._rebuild(self._draft("brain.py", brain_script), self._populations)

    def get_populations(self) -> dict[str, Selection]:
        """Return the neurons of each population, as places in the brain's circuit."""
        return self._runner.call(lambda run: populations_of(run.experiment))

    def edit_populations(self, populations: Mapping[str, Selection]) -> None:
        """Name other neurons; the simulation begins again at time 0.

        Raises:
            NrpError: the neurons do not exist; the simulation begins again with the names that it had.
        """
        if not isinstance(populations, Mapping):
            raise ExperimentError(f"populations are a dict of names and neurons, not {populations!r:.60}")
        self._rebuild(self._model, populations)

    def save_brain(self) -> None:
        """Write a changed brain into the files of the experiment.

        Raises:
            ExperimentError: these are not yours.
            LifecycleError: the simulation is stopped.
        """
        if self._model is not None:
            self._save(first_file(self._read()), self.get_brain())

    def _rebuild(self, model: Path | None, populations: Mapping[str, Selection] | None) -> None:
        was_running, began = self.get_state() == STARTED, self._runner.call(lambda run: run.loop.now_ns)
        machines = self._runner.call(_machines)
        before = self._runner.call(lambda run: run.brain.network.digest)
        if began:
            log.warning("another brain: the simulation begins again at time 0")
        self._runner.stop(silently=True)
        try:
            self._open(model, populations, machines)
        except Exception:
            self._open(self._model, self._populations, machines)
            raise
        self._model, self._populations = model, populations
        if self._runner.call(lambda run: run.brain.network.digest) == before:
            log.warning("the brain is as it was: the same cells, synapses and names of neurons")
        if was_running:
            self.start()

    def _open(
        self, model: Path | None, populations: Mapping[str, Selection] | None, machines: list[Path]
    ) -> None:
        """Continue with another brain, and with the present functions and machines."""

        def read() -> Experiment:
            experiment = with_brain(self._read(), model, populations)
            if isinstance(experiment.maker, ShimmedMaker):
                experiment.maker.machines[:] = machines
            return experiment

        self._runner = Runner(read, self._tell, self._finish, self._launched)
        left_out = [one for one in self._runner.call(lambda run: run.found) if one.code in _NO_BRAIN]
        if left_out:
            self._runner.stop(silently=True)
            raise ExperimentError(left_out[0].message)
        self._runner.call(self._reapply)


_NO_BRAIN = (Code.NRP269, Code.NRP211)
"""Findings that there is not such a brain, or are not such neurons."""


def _machines(run: Run) -> list[Path]:
    maker = run.experiment.maker
    return list(maker.machines) if isinstance(maker, ShimmedMaker) else []
