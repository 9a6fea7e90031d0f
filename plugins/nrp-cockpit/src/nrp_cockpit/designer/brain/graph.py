"""A brain as boxes and wires: a drawn one, or the network of a script written by hand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from nrp_cockpit.designer.brain.edit import INTO
from nrp_cockpit.designer.brain.model import Brain, Projection, Receptor, weight_unit
from nrp_cockpit.designer.layout import Positions, key_of
from nrp_core.network.cells import CELLS
from nrp_core.network.data import RECEPTORS, Network

Box = dict[str, Any]
Wire = dict[str, Any]

_COLUMN, _TOP, _LEFT, _HEAD, _ROW, _APART = 288, 24, 0, 44, 28, 40
KIND: Final = "neurons"


def drawn_graph(brain: Brain) -> tuple[list[Box], list[Wire]]:
    """Return the boxes and wires of a drawn brain."""
    place = {one.name: f"population/{at}" for at, one in enumerate(brain.population)}
    wires = [
        _drawn_wire(brain, one, f"projection/{at}", place)
        for at, one in enumerate(brain.projection)
        if {one.source, one.target} <= place.keys()
    ]
    ends = [end for wire in wires for end in (wire["source_end"], wire["target_end"])]
    boxes = [
        _box(place[one.name], one.name, one.size, type(one.cells).__name__, _rows(place[one.name], ends))
        for one in brain.population
    ]
    return boxes, wires


def network_graph(network: Network) -> tuple[list[Box], list[Wire]]:
    """Return the boxes and wires of a network that was not drawn."""
    boxes = [
        _box(f"network:{label}", label, one.size, one.cell_type, ())
        for label, one in network.populations.items()
    ]
    wires = []
    for at, one in enumerate(network.projections):
        kind = "excites" if one.is_excitatory else "inhibits"
        label = f"{one.size} synapse{'' if one.size == 1 else 's'}"
        if one.receptor not in RECEPTORS:
            label += f" ({one.receptor})"
        wires.append(_wire(f"network:{at}", kind, f"network:{one.pre}", "", f"network:{one.post}", "", label))
    return boxes, wires


def _drawn_wire(brain: Brain, projection: Projection, path: str, place: Mapping[str, str]) -> Wire:
    cells = [f"[{one}]" if one else "" for one in (projection.source_cells, projection.target_cells)]
    kind = "excites" if projection.receptor is Receptor.EXCITATORY else "inhibits"
    label = f"{projection.synapse.weight:g} {weight_unit(brain, projection)}".strip()
    source, target = place[projection.source], place[projection.target]
    return {**_wire(path, kind, source, cells[0], target, cells[1], label), "part": path}


def _wire(
    name: str, kind: str, source: str, source_cells: str, target: str, target_cells: str, label: str
) -> Wire:
    return {
        "id": name, "kind": kind, "label": label, "part": "",
        "source": source, "source_end": f"{source}{source_cells}",
        "target": target, "target_end": f"{INTO}{target}{target_cells}",
    }  # fmt: skip


def _box(name: str, label: str, size: int, cell: str, rows: Sequence[dict[str, Any]]) -> Box:
    return {
        "id": name, "kind": KIND, "name": label, "size": size, "type": cell, "rows": list(rows),
        "is_heard": bool(CELLS[cell].weight_unit) if cell in CELLS else True,
    }  # fmt: skip


def _rows(box: str, ends: Iterable[str]) -> list[dict[str, Any]]:
    """Return the groups of cells that projections begin or end at."""
    of_box = [end.removeprefix(INTO) for end in ends if end.removeprefix(INTO).startswith(f"{box}[")]
    return [{"path": path, "text": path.removeprefix(box)} for path in sorted(set(of_box), key=_first_cell)]


def _first_cell(path: str) -> tuple[int, ...]:
    return tuple(map(int, path.partition("[")[2].rstrip("]").split(":")))


# -- positions


def placed_brain(boxes: Sequence[Box], wires: Sequence[Wire], moved: Positions) -> list[Box]:
    """Return the boxes with ``x`` and ``y``: their moved positions, or columns along the wires."""
    columns = _columns(boxes, wires)
    heights: dict[int, int] = {}
    found = []
    for box in boxes:
        column = columns[box["id"]]
        y = heights.setdefault(column, _TOP)
        heights[column] = y + _HEAD + _ROW * len(box["rows"]) + _APART
        x, y_ = moved.get(key_of(box), (_LEFT + _COLUMN * column, y))
        found.append({**box, "x": x, "y": y_})
    return found


def _columns(boxes: Sequence[Box], wires: Sequence[Wire]) -> dict[str, int]:
    """Return a column for each box, to the right of those that project to it, except in cycles."""
    into: dict[str, set[str]] = {box["id"]: set() for box in boxes}
    for wire in wires:
        into[wire["target"]].add(wire["source"])
    found: dict[str, int] = {}

    def column(name: str, on_the_way: frozenset[str]) -> int:
        if name not in found:
            before = into[name] - on_the_way - {name}
            found[name] = max((column(one, on_the_way | {name}) + 1 for one in sorted(before)), default=0)
        return found[name]

    for box in boxes:
        column(box["id"], frozenset())
    return found
