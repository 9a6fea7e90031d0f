"""Projections of PyNN whose connectors, written by users, connect the cells with ``nest.Connect``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from nrp_core.errors import CapabilityError

_LAWS = (("TsodyksMarkramSynapse", "tsodyks_synapse"), ("STDPMechanism", "stdp_synapse"))


class ProjectionModel(str):  # noqa: SLOT000 - few of them are made
    """``projection.nest_synapse_model``: the name of NEST's model, which knows its projection.

    Args:
        name: the name in NEST.
        projection: the projection.
        listed: returns the connector of pairs of indices.
    """

    _projection: Any
    _listed: Callable[[list[tuple[int, int]]], Any]

    def __new__(
        cls, name: str, projection: Any, listed: Callable[[list[tuple[int, int]]], Any]
    ) -> ProjectionModel:
        made = super().__new__(cls, name)
        made._projection, made._listed = projection, listed
        return made

    def connect(self, pre: Iterable[Any], post: Iterable[Any], rule: Any) -> None:
        """Add synapses to the projection, with the weights, delays and law of its synapse type.

        Args:
            pre: cells of the first population.
            post: cells of the second population.
            rule: as ``nest.Connect`` takes it.

        Raises:
            CapabilityError: the rule is another one than one-to-one and all-to-all.
        """
        of = self._projection
        sources = [int(of.pre.id_to_index(cell)) for cell in pre]
        targets = [int(of.post.id_to_index(cell)) for cell in post]
        name = rule.get("rule") if isinstance(rule, Mapping) else rule
        if name == "one_to_one" and len(sources) == len(targets):
            pairs = list(zip(sources, targets, strict=True))
        elif name in (None, "all_to_all"):
            pairs = [(i, j) for j in targets for i in sources]
        else:
            raise CapabilityError(
                f"nest.Connect of {len(sources)} and {len(targets)} cells of a projection takes the rules "
                f"one_to_one (as many cells on both sides) and all_to_all, not '{name}'"
            )
        self._listed(pairs).connect(of)


def synapse_model_of(projection: Any, sim: Any) -> ProjectionModel:
    """Return ``nest_synapse_model`` of a projection."""
    kind = projection.synapse_type
    name = next((theirs for own, theirs in _LAWS if isinstance(kind, getattr(sim, own))), "static_synapse")
    return ProjectionModel(name, projection, sim.FromListConnector)
