"""Populations of a brain as scripts write them: ``{"from": 0, "to": 5, "step": 1}``, ``[0, 2]``, ``3``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from nrp_legacy.elements import attribute, children, number
from nrp_legacy.maker import LegacyMaker

from nrp_core._support.xml import Element
from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.experiment import Experiment

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
