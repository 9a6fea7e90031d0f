"""The commands that change a drawn brain.

An end of a wire is the path of a population, where spikes leave it, or ``into:`` and this path, where they
reach it; both with the selected cells: ``into:population/0[0:2]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from typing import Any, Final

from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features

from nrp_cockpit.designer.brain.interventions import NAMED_CELLS, Scale
from nrp_cockpit.designer.brain.model import (
    CELL_CLASSES,
    OF_POPULATION,
    SYNAPSE_CLASSES,
    AllToAllConnector,
    Brain,
    CellModel,
    Connector,
    Population,
    Projection,
    SynapseModel,
    weight_unit,
)
from nrp_cockpit.designer.changes import Changes
from nrp_cockpit.designer.tree import at, replaced, walk
from nrp_core.errors import ExperimentError

INTO: Final = "into:"
NO_SYNAPSES: Final = "'{}' only emits spikes: it cannot receive synapses"
_USUAL: Final[dict[type[Node], type[Node]]] = {
    CellModel: CELL_CLASSES["IF_cond_exp"],
    SynapseModel: SYNAPSE_CLASSES["StaticSynapse"],
    Connector: AllToAllConnector,
}
_FIRST: Final[dict[str, Any]] = {"size": 1, "p_connect": 0.1, "n": 1, "weight": 0.01, "by": 0.5, "rate": 100}
_WEIGHTS: Final = {"uS": 0.01, "nA": 1.0, "mV": 1.0}
"""The weights of new projections, by the unit of their target."""


class BrainEdit(Changes):
    """Changes of a drawn brain, and of the interventions in any brain.

    Args:
        model: the current model.
        names: the names of the cells that interventions can mean.
    """

    model: Brain

    def __init__(self, model: Brain, names: Sequence[str]) -> None:
        super().__init__(model)
        self._names = names

    def set(self, path: str, field: str, text: str | None) -> None:
        """Set a value; the name of a population or projection must be free."""
        siblings = getattr(self.model, path.partition("/")[0], ()) if field == "name" else ()
        if text in [one.name for one in siblings if one is not at(self.model, path)]:
            raise ExperimentError(f"the name '{text}' is already in use")
        super().set(path, field, text)

    def remove(self, path: str) -> None:
        """Remove a part, and with a population its projections."""
        part = at(self.model, path)
        super().remove(path)
        if isinstance(part, Population):
            kept = [one for one in self.model.projection if part.name not in (one.source, one.target)]
            self.model = replace(self.model, projection=tuple(kept))

    def connect(self, source: str, target: str) -> None:
        """Add a projection between two ends, in either order.

        Raises:
            ExperimentError: they cannot be connected; the message gives the reason.
        """
        if source.startswith(INTO):
            source, target = target, source
        if source.startswith(INTO):
            raise ExperimentError(
                "spikes arrive on the left of a population; begin a projection on its right"
            )
        pre, pre_cells = self._end(source)
        post, post_cells = self._end(target.removeprefix(INTO))
        made = self._make(
            "", Projection, name=self._free_name("projection", f"{pre.name} to {post.name}"),
            source=pre.name, source_cells=pre_cells, target=post.name, target_cells=post_cells,
        )  # fmt: skip
        unit = weight_unit(self.model, made)
        if not unit:
            raise ExperimentError(NO_SYNAPSES.format(post.name))
        self.put("", "projection", replace(made, synapse=replace(made.synapse, weight=_WEIGHTS[unit])))

    # --

    def _end(self, end: str) -> tuple[Population, str | None]:
        path, _, cells = end.partition("[")
        found = at(self.model, path)
        if not isinstance(found, Population):
            raise ExperimentError(f"'{end}' is not an end of a wire")
        return found, cells.rstrip("]") or None

    def _make(self, path: str, kind: type[Node], **given: Any) -> Any:
        kind = _USUAL.get(kind, next(iter(concrete(kind).values())))
        if kind is Scale and not given:
            given = {"targets": self._first_cells()}
        needed = (feature for feature in features(kind) if feature.least and feature.field not in given)
        return kind(**given, **{feature.field: self._first(path, feature) for feature in needed})

    def _first(self, path: str, feature: Feature) -> Any:
        if not isinstance(feature.of, Value):
            return self._make(path, feature.of)
        if feature.of.name == "PopulationName":
            if not self.model.population:
                raise ExperimentError("a projection needs populations: draw one first")
            return self.model.population[0].name
        if feature.of is NAMED_CELLS:
            return self._first_cells()
        return self._free_name(path, "population") if feature.field == "name" else _FIRST[feature.field]

    def _first_cells(self) -> str:
        if not self._names:
            raise ExperimentError("an intervention needs cells, and the brain has none yet")
        return self._names[0]

    def _free_name(self, path: str, wanted: str) -> str:
        names = {str(getattr(one, "name", "")) for _, one in walk(self.model)}
        apart = " " if " " in wanted else "_"
        numbered = (f"{wanted}{apart}{number}" for number in count(2))
        return wanted if wanted not in names else next(name for name in numbered if name not in names)

    def _renamed(self, path: str, before: str, after: str) -> None:
        if not path.startswith("population/"):
            return
        for where, part in list(walk(self.model)):
            for feature in features(type(part)):
                if feature.of in (OF_POPULATION, NAMED_CELLS) and getattr(part, feature.field) == before:
                    self.model = replaced(self.model, f"{where}/{feature.field}", after)

    def _left(self, owner: str) -> str | None:
        return ""
