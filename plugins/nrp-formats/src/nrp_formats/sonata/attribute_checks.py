"""Checks of a circuit's files: wrong values, and features that networks lack."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from difflib import get_close_matches
from typing import Any, Final

import numpy as np

from nrp_core.brain import IntArray
from nrp_core.errors import NetworkError
from nrp_core.network.nest_models import NEST_CELLS
from nrp_formats.sonata.items import DYNAMICS, SonataItems

_OWN: Final = frozenset(
    {"x", "y", "z", "g_L", "V_m", "tau_minus", "pop_name", "model_type", "model_template"}
)
"""Attributes that are used beside those of models."""
_AXES: Final = ("x", "y", "z")
_COLUMNS: Final = (DYNAMICS, "model_type", "model_template", "pop_name")
"""Columns of tables of types that are used beside those of models."""
_EVERY: Final = frozenset(name for model in NEST_CELLS.values() for name in model.names if len(name) > 1)
"""The parameters of any cell; a letter may be anything."""
_ALIKE: Final = 0.75
_NOTES: Final = frozenset(
    {"comment", "comments", "description", "id", "note", "notes", "specimen_id", "version"}
)
"""What a file of parameters says about itself."""
_RUN: Final = {"tstop": "the experiment's duration", "dt": "the brain's timestep"}


def not_used(items: SonataItems, known: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each attribute without effect: one that is misspelt, or of other models.

    Attributes that no model has are further data of a file.

    Args:
        items: nodes or edges.
        known: the names of the attributes that are used.
    """
    given = items.names()
    missing = {name.lower(): name for name in (*known, *_COLUMNS) if name not in given}
    parameters = {name for one in items.used_types() for name in one.parameters if _is_meant(one[name])}
    for name in sorted(given - set(known) - _OWN):
        if near := get_close_matches(name.lower(), missing, 1, _ALIKE):
            reason = f"; did you mean '{missing[near[0]]}'?"
        elif name in _EVERY or (name in parameters and name.strip("_").lower() not in _NOTES):
            reason = ": their models have no such parameter"
        else:
            continue
        yield f"'{name}' of the {items.kind}s '{items.name}' is not used{reason}"


def _is_meant(value: object) -> bool:
    """Return whether a value is a number that is not 0, or a list with one."""
    values = value if isinstance(value, list) else [value]
    return all(isinstance(one, int | float) for one in values) and any(values)


def not_numbers(items: SonataItems, known: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each used attribute that is NaN in the file, where the default is used."""
    for _, places, own in items.groups:
        for name in sorted(own.keys() & set(known)):
            if number := int(np.isnan(own[name][places]).sum()):
                yield (
                    f"'{name}' of {number} {items.kind}s '{items.name}' is not a number; "
                    "the value of their type is used, or the default"
                )


def not_read(items: SonataItems, known: Collection[str]) -> Iterator[str]:
    """Yield a sentence for each used attribute that is not a number in the file, and each unknown group."""
    owner = f"of the {items.kind}s '{items.name}'"
    for name in sorted(items.unread):
        if name in known or name in _AXES:
            yield f"'{name}' {owner} is not used: it does not hold numbers"
        elif near := get_close_matches(name, (DYNAMICS, "0", "1"), 1, _ALIKE / 1.2):
            yield f"the group '{name}' {owner} is not read; did you mean '{near[0]}'?"
    for *_, own in items.groups:
        if _AXES[2] in own and (lost := [axis for axis in _AXES if axis not in own]):
            yield f"{owner.removeprefix('of ')} have no position: their places lack {' and '.join(lost)}"


def require_places(items: SonataItems, node_ids: IntArray) -> None:
    """Refuse nodes with one id, and positions that are not finite.

    Raises:
        NetworkError: one of these conditions holds.
    """
    known, count = np.unique(node_ids, return_counts=True)
    if (count > 1).any():
        raise NetworkError(
            f"nodes '{items.name}': {count.max()} nodes have the id {known[np.argmax(count)]} (node_id); "
            "ids must be distinct"
        )
    for chosen, places, own in items.groups:
        for axis in sorted(own.keys() & set("xyz")):
            wrong = ~np.isfinite(own[axis][places])
            if wrong.any():
                at = int(np.argmax(wrong))
                raise NetworkError(
                    f"nodes '{items.name}': {axis} of node {node_ids[chosen[at]]} is "
                    f"{own[axis][places][at]:g}; a position must be finite"
                )


CURRENT_FILES: Final = ("csv", "file", "nwb", "allen")
"""The input types of currents in files; the first two are tables, the others files of the Allen Institute."""


def is_read_clamp(entry: Mapping[str, Any]) -> bool:
    """Return whether an input is a current that is read: all but those in a table of electrodes."""
    if entry.get("module") == "IClamp" and entry.get("input_type") in CURRENT_FILES:
        return True
    return entry.get("input_type") == "current_clamp" and ("amp" in entry or "electrode_file" not in entry)


def unused_settings(config: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each part of a simulation's configuration that no network has."""
    for key, value in (config.get("conditions") or {}).items():
        if key == "v_init":
            yield f"'conditions.{key}' is {value!r} and has no effect: cells begin as their models say"
    for key, value in (config.get("run") or {}).items():
        if key in _RUN:
            yield f"'run.{key}' is {value!r} ms and has no effect: {_RUN[key]} counts"
    for name, entry in (config.get("inputs") or {}).items():
        kind = entry.get("input_type")
        if kind != "spikes" and not is_read_clamp(entry):
            what = "electrode_file" if kind == "current_clamp" else f"input_type {kind!r}"
            yield f"the input '{name}' has no effect: its {what} is not read"
    for name in config.get("reports") or {}:
        yield f"the report '{name}' has no effect: recordings of runs hold the brain's activity"
