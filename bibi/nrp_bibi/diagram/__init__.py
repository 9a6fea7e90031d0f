"""A model as a picture: populations and devices on the left, topics on the right, functions between."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from itertools import groupby

from nrp_bibi.diagram.shapes import GAP, Arrow, Card, Picture, height_of, stacked
from nrp_bibi.generate.expressions import as_python
from nrp_bibi.generate.selectors import selection
from nrp_bibi.generate.walk import channels, parts
from nrp_bibi.model.channels import AnyDevice, TopicChannel
from nrp_bibi.model.functions import Bibi, BIBITransferFunction, PythonTransferFunction, TransferFunction
from nrp_bibi.model.selectors import NeuronSelector, NeuronSelectorTemplate
from nrp_bibi.python.layout import laid_out
from nrp_bibi.python.printer import flat
from nrp_bibi.templates import environment
from nrp_bibi.writer import escaped

_POPULATIONS, _DEVICES, _FUNCTIONS, _TOPICS = (24, 110), (174, 226), (470, 586), (1126, 236)
"""Left edge and width of each column."""
_TOP, _BETWEEN, _WIDTH = 64, 40, 1386
_CODE_WIDTH, _DEVICE_WIDTH = 76, 28  # characters of text in a card
_CODE_LINES = 12  # of a function in Python


def diagram(model: Bibi) -> str:
    """Return a model as an SVG document."""
    picture = Picture()
    y: float = _TOP
    for function in model.transfer_function:
        y += _draw(function, y, picture) + _BETWEEN
    template = environment().get_template("diagram.svg.j2")
    columns = {"brain": _POPULATIONS[0], "function": _FUNCTIONS[0], "robot": _TOPICS[0]}
    return template.render(picture=picture, width=_WIDTH, height=y, columns=columns, escaped=escaped)


def _draw(function: TransferFunction, top: float, picture: Picture) -> float:
    """Add a transfer function; return its height."""
    devices, topics = _channels(function)
    left = [_device_card(device) for device in devices]
    right = [_topic_card(topic) for topic in topics]
    middle = [_function_card(function)]
    height = max(map(height_of, (left, middle, right)))
    left, middle, right = (stacked(cards, top, height) for cards in (left, middle, right))
    own = middle[0]
    picture.cards += [*left, *middle, *right]
    picture.arrows += [
        _between(card, own, reverse=device.body is not None)
        for card, device in zip(left, devices, strict=True)
    ]
    picture.arrows += [
        _between(own, card, reverse=topic.body is None) for card, topic in zip(right, topics, strict=True)
    ]
    _draw_populations(devices, left, picture)
    return height


def _channels(function: TransferFunction) -> tuple[list[AnyDevice], list[TopicChannel]]:
    """Return devices, sorted so that those of one population stand together, and topics."""
    if not isinstance(function, BIBITransferFunction):
        return [], []
    returned = getattr(function, "return_value", None)
    every = [*channels(function), *([returned] if isinstance(returned, TopicChannel) else [])]
    devices = [channel for channel in every if isinstance(channel, AnyDevice)]
    return sorted(devices, key=_population), [one for one in every if isinstance(one, TopicChannel)]


def _draw_populations(devices: list[AnyDevice], cards: list[Card], picture: Picture) -> None:
    for name, run in groupby(zip(devices, cards, strict=True), lambda pair: _population(pair[0])):
        reached = [card for _, card in run]
        first, last = reached[0], reached[-1]
        own = Card("population", name, (), *_POPULATIONS)
        (own,) = stacked([own], first.y, last.y + last.height - first.y)
        picture.cards.append(own)
        edge = own.x + own.width
        picture.arrows += [
            Arrow((edge, own.middle), (card.x, card.middle), is_plain=True) for card in reached
        ]


def _population(device: AnyDevice) -> str:
    named = (
        part for part in parts(device.neurons) if isinstance(part, (NeuronSelector, NeuronSelectorTemplate))
    )
    return ", ".join(dict.fromkeys(part.population for part in named if part.population))


def _between(left: Card, right: Card, *, reverse: bool) -> Arrow:
    start, end = (left.x + left.width, left.middle), (right.x, _within(right, left.middle))
    if right.style != "function":
        start, end = (start[0], _within(left, right.middle)), (right.x, right.middle)
    return Arrow(end, start) if reverse else Arrow(start, end)


def _within(card: Card, y: float) -> float:
    """Return the height at a card's side that is nearest to ``y``."""
    return min(max(y, card.y + GAP), card.y + card.height - GAP)


def _device_card(device: AnyDevice) -> Card:
    neurons = selection(device.neurons).replace("nrp.brain.", "").replace("nrp.", "")
    lines = [device.type.dsl_name, *textwrap.wrap(neurons, _DEVICE_WIDTH)]
    return Card("device", device.name, lines, *_DEVICES)


def _topic_card(topic: TopicChannel) -> Card:
    return Card("topic", topic.topic, [topic.type.replace(".msg.", "/")], *_TOPICS)


def _function_card(function: TransferFunction) -> Card:
    if isinstance(function, PythonTransferFunction):
        title = f"Python: {function.src}" if function.src else "Python"
        lines = function.code.split("\n") if function.code else []
        shown = lines if len(lines) <= _CODE_LINES else [*lines[: _CODE_LINES - 1], "..."]
        return Card("function", title, shown, *_FUNCTIONS)
    assert isinstance(function, BIBITransferFunction)
    lines = [line for text in _statements(function) for line in laid_out(text, _CODE_WIDTH).split("\n")]
    return Card("function", f"{function.name}  ({type(function).__name__})", lines, *_FUNCTIONS)


def _statements(function: BIBITransferFunction) -> Iterator[str]:
    """Yield what a transfer function does, a line each, in the order in which it does so."""
    for local in function.local:
        yield f"{local.name} = {flat(as_python(local.body))}"
    for channel in sorted(channels(function), key=lambda one: isinstance(one, TopicChannel)):
        if channel.body is not None:
            is_device = isinstance(channel, AnyDevice)
            written = f"{channel.name}.{channel.type.default_property}" if is_device else channel.name
            yield f"{written} = {flat(as_python(channel.body))}"
    returned = getattr(function, "return_value", None)
    if isinstance(returned, TopicChannel) and returned.body is not None:
        yield f"return {flat(as_python(returned.body))}"
