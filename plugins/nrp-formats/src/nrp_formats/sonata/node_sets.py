"""Node sets: named groups of nodes, defined by common attributes or as unions of other sets.

https://github.com/AllenInstitute/sonata/blob/master/docs/SONATA_DEVELOPER_GUIDE.md#node-sets-file
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_formats.sonata.items import read_object
from nrp_formats.sonata.nodes import Nodes

Mask = npt.NDArray[np.bool_]

_IDS: Final = ("node_id", "node_type_id")
_OPERATORS: Final[Mapping[str, Callable[[Any, Any], Any]]] = {
    "$gt": operator.gt, "$lt": operator.lt, "$gte": operator.ge, "$lte": operator.le,
}  # fmt: skip


def read_node_sets(
    path: Path, nodes: Mapping[str, Nodes], ids: Mapping[str, IntArray]
) -> Mapping[str, IntArray]:
    """Return the global ids of the nodes in each set of a file, in the order of the nodes.

    Args:
        path: the file.
        nodes: all populations of nodes.
        ids: the global ids of their nodes.

    Raises:
        NetworkError: the file cannot be read, or a set names a missing set or attribute.
    """
    sets = read_object(path, "the file of node sets")
    try:
        masks = {name: _resolved(name, sets, nodes, ()) for name in sets}
    except NetworkError as error:
        error.path = path
        raise
    empty = np.empty(0, np.int64)
    return {
        name: np.concatenate([empty, *(ids[population][mask] for population, mask in found.items())])
        for name, found in masks.items()
    }


def nodes_matching(
    name: str, rule: Mapping[str, Any], nodes: Mapping[str, Nodes], ids: Mapping[str, IntArray]
) -> IntArray:
    """Return the global ids of the nodes with the attributes of a rule, as in a node set.

    Args:
        name: the owner of the rule, for messages.
        rule: the attributes.
        nodes: all populations of nodes.
        ids: the global ids of their nodes.

    Raises:
        NetworkError: the rule is wrong.
    """
    return np.concatenate([ids[label][_matching(name, rule, label, part)] for label, part in nodes.items()])


def without_nodes(path: Path, sets: Mapping[str, IntArray]) -> list[str]:
    """Return a sentence about the sets of a file that contain no node, if any."""
    empty = [f"'{name}'" for name, ids in sets.items() if not len(ids)]
    return [f"the node sets of '{path.name}' contain no node: {', '.join(empty)}"] if empty else []


def _resolved(
    name: str, sets: Mapping[str, Any], nodes: Mapping[str, Nodes], above: tuple[str, ...]
) -> dict[str, Mask]:
    """Return the nodes of each population that are in a set."""
    if name in above:
        raise NetworkError(f"node set '{name}' contains itself: {' > '.join([*above, name])}")
    if name not in sets:
        raise NetworkError(f"node set '{above[-1]}' names no set '{name}'{did_you_mean(name, sets)}")
    rule = sets[name]
    if isinstance(rule, Mapping):
        return {label: _matching(name, rule, label, part) for label, part in nodes.items()}
    if not isinstance(rule, list):
        raise NetworkError(f"node set '{name}' is neither a JSON object nor a list of names")
    parts = [_resolved(str(other), sets, nodes, (*above, name)) for other in rule]
    return {
        label: np.logical_or.reduce([np.zeros(len(part.items), bool), *(found[label] for found in parts)])
        for label, part in nodes.items()
    }


def _matching(name: str, rule: Mapping[str, Any], label: str, part: Nodes) -> Mask:
    mask = np.ones(len(part.items), bool)
    for key, wanted in rule.items():
        attribute = "node_id" if key == "node_ids" else key  # BMTK's name
        choices = wanted if isinstance(wanted, list) else [wanted]
        if not isinstance(wanted, Mapping):
            _require_kind(name, attribute, choices)
        if attribute == "population":
            mask &= label in choices
        elif isinstance(wanted, Mapping):
            mask &= _compared(name, attribute, wanted, part)
        else:
            mask &= _equal(attribute, choices, part)
    return mask


def _require_kind(name: str, attribute: str, choices: list[Any]) -> None:
    """Refuse values that no node can have.

    Raises:
        NetworkError: one was found.
    """
    valid: tuple[str, type | tuple[type, ...]] = ("a number or a text", (int, float, str))
    if attribute in _IDS:
        valid = ("a whole number", int)
    elif attribute == "population":
        valid = ("the name of a population", str)
    for choice in choices:
        if isinstance(choice, bool) or not isinstance(choice, valid[1]):
            raise NetworkError(f"node set '{name}': {attribute} is {choice!r}; it must be {valid[0]}")


def _compared(name: str, attribute: str, wanted: Mapping[str, Any], part: Nodes) -> Mask:
    mask = np.ones(len(part.items), bool)
    for sign, number in wanted.items():
        if sign not in _OPERATORS or not isinstance(number, (int, float)):
            hint = did_you_mean(sign, _OPERATORS)
            raise NetworkError(
                f"node set '{name}': {attribute} cannot be compared by '{sign}': {number}{hint}"
            )
        mask &= _OPERATORS[sign](_numbers(attribute, part), number)
    return mask


def _equal(attribute: str, choices: list[Any], part: Nodes) -> Mask:
    if all(isinstance(choice, (int, float)) for choice in choices):
        return np.isin(_numbers(attribute, part), choices)
    named = part.items.texts(attribute)
    return np.isin(part.items.type_ids, [number for number, text in named.items() if text in choices])


def _numbers(attribute: str, part: Nodes) -> npt.NDArray[Any]:
    if attribute == "node_id":
        return part.node_ids
    return part.items.type_ids if attribute == "node_type_id" else part.items.numbers(attribute)
