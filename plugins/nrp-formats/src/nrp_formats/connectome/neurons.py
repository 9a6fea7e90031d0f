"""Tables of neurons: ids, names, types, sides, transmitters, positions."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import compress
from pathlib import Path
from typing import Final

import numpy as np

from nrp_core.brain import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_formats.connectome.signs import LEFT_OUT, Signs
from nrp_formats.connectome.tables import (
    chosen_column,
    column_ids,
    column_names,
    column_numbers,
    column_texts,
    read_rows,
)

IDS: Final = ("id", "root_id", "bodyId", "body", "Unnamed: 0", "", "neuron", "name")
"""Names of the column of ids: plain, FlyWire's, MaleCNS's, that of a table with an index, and of names."""
_TEXTS: Final = {
    "name": ("name", "instance", "label"),
    "type": ("type", "primary_type", "cell_type"),
    "side": ("side", "somaSide", "soma_side"),
    "transmitter": (
        "nt_type",
        "consensus_nt",
        "predicted_nt",
        "top_nt",
        "neurotransmitter",
        "transmitter",
        "nt",
    ),
    "class": ("super_class", "superclass", "class"),
}
_LABELS: Final = ("name", "type", "class", "transmitter")
_POSITION: Final = ("x", "y", "z")
_MIDDLE: Final = ("m", "c", "centre", "central", "centered", "centred", "median", "midline", "middle")
_SIDES: Final = {"l": "left", "r": "right", "center": "center", **dict.fromkeys(_MIDDLE, "center")}


@dataclass(frozen=True)
class Neurons:
    """Neurons of a connectome.

    Args:
        ids: shape ``(n,)``, unique.
        texts: ``name``, ``type``, ``side``, ``transmitter``, ``class`` of each; unknown ones are empty.
        positions: in the unit of the table, shape ``(n, 3)``, or None.
        remarks: sentences about ids and positions that are missing.
    """

    ids: IntArray
    texts: dict[str, list[str]]
    positions: FloatArray | None = None
    remarks: tuple[str, ...] = ()

    def completed(self, path: Path) -> Neurons:
        """Return the same neurons with the data of another table that this one lacks.

        Raises:
            NetworkError: the table has none of these neurons; or as for :func:`read_neurons`.
        """
        other = read_neurons(path)
        row_of = {ident: row for row, ident in enumerate(other.ids.tolist())}
        rows = [row_of.get(ident, -1) for ident in self.ids.tolist()]
        absent = rows.count(-1)
        if absent == len(rows):
            raise NetworkError(
                f"none of the {len(rows)} neurons of the first table is in this one", path=path
            )
        texts = dict(self.texts)
        for what, theirs in other.texts.items():
            ours = texts.get(what, [""] * len(rows))
            texts[what] = [
                own or (theirs[row] if row >= 0 else "") for own, row in zip(ours, rows, strict=True)
            ]
        positions, remarks = self.positions, [*self.remarks, *other.remarks]
        if positions is None and other.positions is not None:
            positions = np.where(np.array(rows)[:, None] >= 0, other.positions[rows], 0.0)
            remarks += [_without_positions(absent, len(rows))] if absent else []
        return Neurons(self.ids, texts, positions, tuple(remarks))

    def signs(self, signs: Signs) -> IntArray:
        """Return 1 or -1 by the transmitter of each neuron; 0 where it is unknown."""
        known = self.texts.get("transmitter")
        if known is None:
            return np.zeros(len(self.ids), int)
        found = np.array([signs.of_transmitter(text) for text in known], int)
        return np.where(found == LEFT_OUT, 0, found)  # the names of the cell decide

    def labels(self, index: int) -> list[str]:
        """Return the name, type, class and transmitter of a neuron as far as they are known."""
        found = (self.texts[what][index] for what in _LABELS if what in self.texts)
        return [text for text in found if text]

    def label(self, index: int) -> str:
        """Return the type of a neuron; otherwise its class, transmitter or name."""
        for what in ("type", "class", "transmitter", "name"):
            if text := self.texts.get(what, {index: ""})[index]:
                return text
        return "without a type"


def read_neurons(path: Path) -> Neurons:
    """Read a table of neurons.

    Raises:
        NetworkError: it has no ids, or one twice; or as for
            :func:`~nrp_formats.connectome.tables.read_rows`.
    """
    names = column_names(path)
    id_column = chosen_column(path, "the id of a neuron", IDS, names)
    used = {what: next((one for one in known if one in names), None) for what, known in _TEXTS.items()}
    columns = {what: column for what, column in used.items() if column is not None}
    place = [name for name in _POSITION if name in names]
    places = place if len(place) == len(_POSITION) else []
    ids: list[IntArray] = []
    named: dict[int, str] = {}
    texts: dict[str, list[str]] = {what: [] for what in columns}
    positions: list[FloatArray] = []
    empty = 0
    for rows in read_rows(path, [*dict.fromkeys([id_column, *columns.values(), *places])]):
        found, filled, ours = column_ids(path, id_column, rows[id_column])
        empty += int((~filled).sum())
        ids.append(found[filled])
        named |= ours
        for what, column in columns.items():
            texts[what] += compress(column_texts(rows[column]), filled.tolist())
        if places:
            where = np.stack([column_numbers(path, name, rows[name]) for name in places], axis=1)
            positions.append(where[filled])
    every = np.concatenate([np.empty(0, np.int64), *ids])
    order = np.sort(every)
    twice = order[1:][order[1:] == order[:-1]]
    if twice.size:
        who = named.get(int(twice[0]), twice[0])
        raise NetworkError(f"the neuron {who} is in the column '{id_column}' twice", path=path)
    if named:
        texts.setdefault("name", [named.get(number, str(number)) for number in every.tolist()])
    remarks = [f"{empty} rows of {path.name} without an id were left out"] if empty else []
    place_um = np.concatenate(positions) if positions else None
    if place_um is not None:
        missing = np.isnan(place_um).any(axis=1)
        place_um[missing] = 0.0
        if missing.any():
            remarks.append(_without_positions(int(missing.sum()), len(every)))
    if "side" in texts:
        texts["side"] = [_SIDES.get(side.lower(), side) for side in texts["side"]]
    return Neurons(every, texts, place_um, tuple(remarks))


def _without_positions(missing: int, n: int) -> str:
    return f"{missing} of {n} neurons have no position; theirs is 0, 0, 0"
