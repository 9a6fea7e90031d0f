"""Positions of boxes: in columns, or as placed by a user, which are saved beside the model."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from nrp_cockpit.designer.graph import Graph
from nrp_core.utilities import replace_file, writing

Positions = Mapping[str, tuple[float, float]]
"""Positions of boxes that a user moved, by :func:`key_of`."""

SUFFIX = ".layout.json"
TOPIC_X, FUNCTION_X, POPULATION_X = 0, 264, 648
_TOP, _HEAD, _ROW, _TALL_ROW = 24, 32, 32, 44
_APART = {"topic": 8, "function": 24, "python": 24, "other": 24, "population": 16}


def key_of(box: Mapping[str, Any]) -> str:
    """Return the name of a box in a layout; that of a function remains if others are added before it."""
    return str(box["id"]) if box["kind"] in ("topic", "population") else str(box["name"])


def placed(graph: Graph, moved: Positions) -> list[dict[str, Any]]:
    """Return the boxes with ``x`` and ``y``: as moved, or in columns."""
    y = _TOP
    at: dict[str, float] = {}
    functions = [box for box in graph.boxes if box["kind"] in ("function", "python", "other")]
    for box in functions:
        for place, offset in _offsets(box):
            at[place] = y + offset
        at[box["id"]] = y
        y += height_of(box) + _APART[box["kind"]]
    wanted = _wanted(graph, at)
    at |= _stacked([box for box in graph.boxes if box["kind"] == "topic"], wanted)
    at |= _stacked([box for box in graph.boxes if box["kind"] == "population"], wanted)
    columns = {"topic": TOPIC_X, "population": POPULATION_X}
    found = []
    for box in graph.boxes:
        x, y_ = moved.get(key_of(box), (columns.get(box["kind"], FUNCTION_X), at[box["id"]]))
        found.append({**box, "x": x, "y": y_})
    return found


def height_of(box: Mapping[str, Any]) -> int:
    """Return the height of a box in pixels, as in the style sheet of the page."""
    if box["kind"] == "topic":
        return 44
    if box["kind"] == "population":
        return _HEAD + 28 * len(box["rows"])
    rows = sum(map(_row_height, box["rows"]))
    return _HEAD + (rows + 28 if box["kind"] == "python" else rows or 28)


def _row_height(row: Mapping[str, Any]) -> int:
    return _TALL_ROW if row["text"] and row["kind"] != "local" else _ROW


def _offsets(box: Mapping[str, Any]) -> Iterable[tuple[str, float]]:
    y = _HEAD
    for row in box["rows"]:
        yield row["path"], y
        y += _row_height(row)


def _wanted(graph: Graph, at: Mapping[str, float]) -> dict[str, float]:
    """Return the y position of the first part that a box is connected to."""
    found: dict[str, float] = {}
    for wire in graph.wires:
        for one, other in (("source", "target"), ("target", "source")):
            box, end = wire[one], wire[f"{other}_end"]
            if end in at and box not in at:
                found[box] = min(found.get(box, at[end]), at[end])
    return found


def _stacked(boxes: list[dict[str, Any]], wanted: Mapping[str, float]) -> dict[str, float]:
    """Return y positions in one column: connected boxes near their partners, the others in the gaps."""
    key: Callable[[dict[str, Any]], Any] = lambda box: wanted.get(box["id"], float("inf"))  # noqa: E731
    taken: list[tuple[float, float]] = []
    at: dict[str, float] = {}
    y = float(_TOP)
    for box in sorted((one for one in boxes if one["id"] in wanted), key=key):
        at[box["id"]] = max(y, wanted[box["id"]] - 6)
        y = at[box["id"]] + height_of(box) + _APART[box["kind"]]
        taken.append((at[box["id"]], y))
    for box in (one for one in boxes if one["id"] not in wanted):
        at[box["id"]] = _gap(taken, height_of(box) + _APART[box["kind"]])
    return at


def _gap(taken: list[tuple[float, float]], height: float) -> float:
    """Return the first free place with enough height, and occupy it."""
    y = float(_TOP)
    for begin, end in sorted(taken):
        if y + height <= begin:
            break
        y = max(y, end)
    taken.append((y, y + height))
    return y


def layout_path(model: Path) -> Path:
    """Return the file of a model's layout."""
    return model.with_suffix(SUFFIX)


def read_layout(model: Path) -> tuple[dict[str, tuple[float, float]], str]:
    """Return the layout beside a model, empty without a file, and the mistakes in the file."""
    path = layout_path(model)
    try:
        return _positions(json.loads(path.read_text(encoding="utf-8"))), ""
    except FileNotFoundError:
        return {}, ""
    except json.JSONDecodeError as error:
        wrong = f"line {error.lineno} is not JSON: {error.msg}"
    except OSError as error:
        wrong = f"it cannot be read: {error.strerror}"
    except (ValueError, RecursionError) as error:
        wrong = str(error)
    return {}, f"'{path.name}' is not used, and saving replaces it: {wrong}"


def _positions(layout: Any) -> dict[str, tuple[float, float]]:
    """Return the positions in a layout.

    Raises:
        ValueError: it is none.
    """
    boxes = layout.get("boxes") if isinstance(layout, dict) else None
    if not isinstance(boxes, dict) or len(layout) > 1:
        raise ValueError('a layout is {"boxes": {"NAME": [x, y]}}')
    for name, place in boxes.items():
        if not (isinstance(place, list) and len(place) == 2 and all(map(_is_finite, place))):
            raise ValueError(f"the place of '{name}' is {json.dumps(place)}, not two numbers")
    return {name: (float(x), float(y)) for name, (x, y) in boxes.items()}


def _is_finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)


def write_layout(model: Path, moved: Positions) -> None:
    """Write a layout beside a model, or remove it if no box was moved.

    Raises:
        ExperimentError: the folder cannot be written.
    """
    path = layout_path(model)
    if moved:
        replace_file(path, json.dumps({"boxes": dict(moved)}, indent=2) + "\n")
        return
    with writing(path):
        path.unlink(missing_ok=True)
