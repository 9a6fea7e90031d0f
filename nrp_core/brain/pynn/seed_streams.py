"""Seeds that several populations draw from one stream, because a script gave them one mechanism."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from nrp_core.brain.network.rewiring import Rewiring


def rewirings_of(projections: Iterable[Any], labels: Mapping[Any, str]) -> dict[int, Rewiring]:
    """Return how synapses of each type that form and vanish do so, by the identity of the type.

    A target follows the last mechanism that was given to it, as in sPyNNaker 7.4.1.

    Args:
        projections: the projections of a script, in order.
        labels: its populations and their labels, in order.
    """
    rewired = [one for one in projections if hasattr(one.synapse_type, "rewiring")]
    last = {one.post: one.synapse_type for one in rewired}
    targets: dict[int, list[str]] = {}
    for population, label in labels.items():
        if population in last:
            targets.setdefault(id(last[population]), []).append(label)
    found = {id(one.synapse_type): one.synapse_type.rewiring for one in rewired}
    several = {key: labels[0] for key, labels in targets.items() if len(labels) > 1}
    seeded = {key: label for key, label in several.items() if found[key].seed is not None}
    return found | {key: replace(found[key], stream=label) for key, label in seeded.items()}
