"""Draw a model: populations and devices on the left, topics on the right, functions between."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from nrp_bibi.diagram.blocks import row_of_blocks
from nrp_bibi.diagram.python import rows_of_python
from nrp_bibi.diagram.rows import Device, Row, Topic
from nrp_bibi.diagram.shapes import GAP, Arrow, Card, Drawing, height_of, stacked
from nrp_bibi.generation.transformation import transformed
from nrp_bibi.model.functions import Bibi, BIBITransferFunction, PythonTransferFunction
from nrp_bibi.templates import environment
from nrp_bibi.writer import escaped

_POPULATIONS, _DEVICES, _FUNCTIONS, _TOPICS = (24, 110), (174, 226), (470, 586), (1126, 236)
"""Left edge and width of each column."""
_TOP, _BETWEEN, _WIDTH = 64, 40, 1386
_DEVICE_WIDTH = 28  # characters of text in a card


def diagram(model: Bibi, path: Path) -> str:
    """Return a model as an SVG document.

    Args:
        model: the model.
        path: the model's file; files of Python transfer functions are searched for beside it.

    Raises:
        TransferFunctionError: the model is not valid, or names a file that does not exist.
    """
    drawing = Drawing()
    y: float = _TOP
    for row in _rows(model, path):
        y += _draw(row, y, drawing) + _BETWEEN
    template = environment().get_template("diagram.svg.j2")
    columns = {"brain": _POPULATIONS[0], "function": _FUNCTIONS[0], "robot": _TOPICS[0]}
    return template.render(drawing=drawing, width=_WIDTH, height=y, columns=columns, escaped=escaped)


def _rows(model: Bibi, path: Path) -> list[Row]:
    functions = model.transfer_function
    of_functions = zip(functions, transformed(model, path)[1:], strict=True)
    python = rows_of_python(
        [(function, part) for function, part in of_functions if isinstance(function, PythonTransferFunction)]
    )
    return [
        row_of_blocks(function) if isinstance(function, BIBITransferFunction) else next(python)
        for function in functions
    ]


def _draw(row: Row, top: float, drawing: Drawing) -> float:
    """Add a transfer function with its devices and topics; return the height of the row."""
    devices = sorted(row.devices, key=lambda device: device.population)  # devices of one population together
    left = [_device_card(device) for device in devices]
    right = [_topic_card(topic) for topic in row.topics]
    middle = [Card("function", row.title, row.lines, *_FUNCTIONS)]
    height = max(map(height_of, (left, middle, right)))
    left, middle, right = (stacked(cards, top, height) for cards in (left, middle, right))
    own = middle[0]
    drawing.cards += [*left, *middle, *right]
    drawing.arrows += [
        _between(card, own, reverse=device.is_written) for card, device in zip(left, devices, strict=True)
    ]
    drawing.arrows += [
        _between(own, card, reverse=not topic.is_written)
        for card, topic in zip(right, row.topics, strict=True)
    ]
    _draw_populations(devices, left, drawing)
    return height


def _draw_populations(devices: Sequence[Device], cards: Sequence[Card], drawing: Drawing) -> None:
    for name, run in groupby(zip(devices, cards, strict=True), lambda pair: pair[0].population):
        if not name:  # known only at run time
            continue
        reached = [card for _, card in run]
        first, last = reached[0], reached[-1]
        own = Card("population", name, (), *_POPULATIONS)
        (own,) = stacked([own], first.y, last.y + last.height - first.y)
        drawing.cards.append(own)
        edge = own.x + own.width
        drawing.arrows += [
            Arrow((edge, own.middle), (card.x, card.middle), is_plain=True) for card in reached
        ]


def _between(left: Card, right: Card, *, reverse: bool) -> Arrow:
    start, end = (left.x + left.width, left.middle), (right.x, _within(right, left.middle))
    if right.style != "function":
        start, end = (start[0], _within(left, right.middle)), (right.x, right.middle)
    return Arrow(end, start) if reverse else Arrow(start, end)


def _within(card: Card, y: float) -> float:
    """Return the height at a card's side that is nearest to ``y``."""
    return min(max(y, card.y + GAP), card.y + card.height - GAP)


def _device_card(device: Device) -> Card:
    lines = [device.kind, *textwrap.wrap(device.neurons, _DEVICE_WIDTH)]
    return Card("device", device.name, lines, *_DEVICES)


def _topic_card(topic: Topic) -> Card:
    return Card("topic", topic.name, [topic.type] if topic.type else [], *_TOPICS)
