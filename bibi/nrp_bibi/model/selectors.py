"""The neurons of a device."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_bibi.model.metamodel import Node, attribute, child, children
from nrp_bibi.model.values import NAME, NATURAL, POINT, POSITIVE, RATE, TEMPLATE, WORD


@dataclass(frozen=True, slots=True, kw_only=True)
class NeuronSelector(Node, abstract=True):
    """Neurons of one population."""

    population: str | None = attribute(WORD, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Index(NeuronSelector):
    """One neuron."""

    index: int = attribute(NATURAL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Box(NeuronSelector):
    """Neurons in a box along the axes, um; two numbers leave the third axis free."""

    low: tuple[float, ...] = attribute(POINT)
    high: tuple[float, ...] = attribute(POINT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere(NeuronSelector):
    """Neurons in a ball, um; a center of two numbers makes it a cylinder."""

    center: tuple[float, ...] = attribute(POINT)
    radius: float = attribute(RATE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Nearest(NeuronSelector):
    """The neurons nearest to a point, um, the nearest first; one by default."""

    center: tuple[float, ...] = attribute(POINT)
    count: int | None = attribute(POSITIVE, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class MultiNeuronSelector(NeuronSelector, abstract=True):
    """Any number of neurons."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Range(MultiNeuronSelector):
    """Neurons from one index up to, but not including, another."""

    from_: int = attribute(NATURAL)
    to: int = attribute(NATURAL)
    step: int | None = attribute(POSITIVE, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class List(MultiNeuronSelector):
    """Neurons by their indices."""

    element: tuple[int, ...] = children(NATURAL, least=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Population(MultiNeuronSelector):
    """All neurons."""

    count: int | None = attribute(NATURAL, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class NeuronSelectorTemplate(Node, abstract=True):
    """Neurons for each value of ``i``."""

    population: str = attribute(NAME)


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexTemplate(NeuronSelectorTemplate):
    """One neuron for each ``i``."""

    index: str = attribute(TEMPLATE)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeTemplate(NeuronSelectorTemplate):
    """A range for each ``i``."""

    from_: str = attribute(TEMPLATE)
    to: str = attribute(TEMPLATE)
    step: str | None = attribute(TEMPLATE, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class ListTemplate(NeuronSelectorTemplate):
    """A list for each ``i``."""

    element: tuple[str, ...] = children(TEMPLATE, least=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class NeuronGroupSelector(Node, abstract=True):
    """Several selections, each with a device of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSelector(NeuronGroupSelector):
    """A selection for each of ``count`` numbers, or for each number of ``source``."""

    count: int | None = attribute(NATURAL, None)
    source: MultiNeuronSelector | None = child(MultiNeuronSelector, None)
    pattern: NeuronSelectorTemplate = child(NeuronSelectorTemplate)


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainSelector(NeuronGroupSelector):
    """Selections, then groups of selections, one after another."""

    neurons: tuple[NeuronSelector, ...] = children(NeuronSelector)
    connectors: tuple[NeuronGroupSelector, ...] = children(NeuronGroupSelector)
