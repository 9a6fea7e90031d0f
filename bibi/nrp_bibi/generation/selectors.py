"""Selectors of the model as Python."""

from __future__ import annotations

import ast

from nrp_bibi.model.metamodel import Node
from nrp_bibi.model.selectors import (
    Box,
    ChainSelector,
    Index,
    IndexTemplate,
    List,
    ListTemplate,
    MapSelector,
    MultiNeuronSelector,
    Nearest,
    Population,
    Range,
    RangeTemplate,
    Sphere,
)


def selection(selector: Node) -> str:
    """Return the neurons of a mapping as Python: ``nrp.brain.sensors[0, 2]``."""
    return ast.unparse(ast.parse(_text(selector), mode="eval"))


def _text(selector: Node) -> str:
    match selector:
        case MapSelector(pattern=pattern):
            return f"nrp.map_neurons({_items(selector)}, lambda i: {_text(pattern)})"
        case ChainSelector(neurons=neurons, connectors=connectors):
            return f"nrp.chain_neurons({', '.join(map(_text, (*neurons, *connectors)))})"
        case Population(population=population):
            return f"nrp.brain.{population}"
        case Box(population=population, low=low, high=high):
            return f"nrp.brain.{population}.within(nrp.Box({low}, {high}))"
        case Sphere(population=population, center=center, radius=radius):
            return f"nrp.brain.{population}.within(nrp.Sphere({center}, {radius}))"
        case Nearest(population=population, center=center, count=count):
            return f"nrp.brain.{population}.nearest({center}{'' if count is None else f', {count}'})"
        case _:
            return f"nrp.brain.{selector.population}[{_index(selector)}]"  # type: ignore[attr-defined]


def _index(selector: Node) -> str:
    match selector:
        case Index(index=index) | IndexTemplate(index=index):
            return str(index)
        case Range(from_=from_, to=to, step=step) | RangeTemplate(from_=from_, to=to, step=step):
            return f"{from_}:{to}" if step is None else f"{from_}:{to}:{step}"
        case List(element=elements) | ListTemplate(element=elements):
            listed = ", ".join(map(str, elements))
            return listed if len(elements) > 1 else f"[{listed}]"
        case _:
            raise TypeError(f"no index for {selector!r}")


def _items(selector: MapSelector) -> str:
    """Return the Python iterable of the values of ``i``."""
    match selector.source:
        case None:
            return f"range({selector.count})"
        case Range(from_=from_, to=to, step=step):
            return f"range({from_}, {to})" if step is None else f"range({from_}, {to}, {step})"
        case List(element=elements):
            return f"[{', '.join(map(str, elements))}]"
        case source:
            return _size(source)


def _size(source: MultiNeuronSelector) -> str:
    count = getattr(source, "count", None)
    return f"nrp.brain.{source.population}.size" if count is None else f"range({count})"
