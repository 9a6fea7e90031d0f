"""The model of a drawn brain, in PyNN's terms; cells and synapses come from the platform's tables."""

from __future__ import annotations

import keyword
import re
from collections.abc import Mapping
from dataclasses import dataclass, make_dataclass, replace
from enum import Enum
from functools import cache
from typing import Any, Final

import numpy as np
from nrp_bibi.model.metamodel import Node, Value, attribute, child, children, choice
from nrp_bibi.model.values import NAME, NUMBER, POSITIVE, TRUTH, WORD

from nrp_cockpit.designer.brain.interventions import Intervention
from nrp_core.network.cells import CELLS, CellType
from nrp_core.network.parameters import FINITE, FRACTION, NOT_NEGATIVE, Limit, Parameter
from nrp_core.network.parameters import NUMBER as ANY
from nrp_core.network.parameters import POSITIVE as ABOVE_ZERO
from nrp_core.network.synapses import EVERY_SYNAPSE, LAWS, SynapseLaw

INITIAL: Final = "initial_"
"""The prefix of a state variable's initial value."""
SIMULATOR: Final = "sim"
"""The name of the simulator in a script."""


class Receptor(Enum):
    """The receptors of synapses."""

    EXCITATORY = "excitatory"
    INHIBITORY = "inhibitory"


def _variable(text: str) -> str:
    name = str(NAME.parse(text))
    if keyword.iskeyword(name) or name == SIMULATOR:
        raise ValueError
    return name


def _cells(text: str) -> str:
    """Return a range of cells in its canonical form: ``3`` is ``3:4``."""
    found = re.fullmatch(r"(\d+)(?::(\d+))?", re.sub(r"\s|[\[\]]", "", text))
    first, last = (int(found[1]), int(found[2] or int(found[1]) + 1)) if found else (0, 0)
    if first >= last:
        raise ValueError
    return f"{first}:{last}"


VARIABLE = replace(
    NAME, parse=_variable, expects=f"{NAME.expects} and is neither a Python keyword nor '{SIMULATOR}'"
)
OF_POPULATION = Value("PopulationName", VARIABLE.parse, str, VARIABLE.expects, VARIABLE.facets)
CELLS_RANGE = Value(
    "Cells", _cells, str, "a range of cells, such as 0:2, or one cell, such as 3", (("base", "xs:token"),)
)
RECEPTOR = choice("Receptor", Receptor)


@cache
def _number(limit: Limit) -> Value:
    """Return the value type of the numbers within a limit."""

    def parse(text: str) -> float:
        value = float(NUMBER.parse(text))
        if not limit.allows(np.array([value])).all():
            raise ValueError
        return value

    expects = NUMBER.expects if limit in (FINITE, ANY) else f"a number, {limit.rule}"
    return replace(NUMBER, parse=parse, expects=expects)


def _declared(parameters: Mapping[str, Parameter]) -> dict[str, Any]:
    return {
        name: attribute(_number(one.limit), one.default, name=name, unit=one.unit)
        for name, one in parameters.items()
    }


def _class(base: type[Node], name: str, summary: str, declared: Mapping[str, Any]) -> type[Node]:
    fields = [(field, Any, declaration) for field, declaration in declared.items()]
    namespace = {"__doc__": summary.replace("``", "")}
    return make_dataclass(name, fields, bases=(base,), frozen=True, kw_only=True, namespace=namespace)


# -- cells


@dataclass(frozen=True, slots=True, kw_only=True)
class CellModel(Node, abstract=True):
    """The model of the cells of a population."""


def _cell_class(cell: CellType) -> type[Node]:
    declared = _declared(cell.parameters)
    for name, one in cell.state.items():
        declared[INITIAL + name] = attribute(
            _number(one.limit), None, name=f"{name} at the start", unit=one.unit
        )
    if cell.name == "SpikeSourceArray":
        declared["spike_times"] = children(_number(NOT_NEGATIVE), name="spike_times")
    return _class(CellModel, cell.name, cell.summary, declared)


CELL_CLASSES: Final = {name: _cell_class(cell) for name, cell in CELLS.items()}


# -- synapses


@dataclass(frozen=True, slots=True, kw_only=True)
class SynapseModel(Node, abstract=True):
    """How synapses transmit spikes."""

    weight: float = attribute(_number(EVERY_SYNAPSE["weight"].limit), unit=EVERY_SYNAPSE["weight"].unit)
    delay: float | None = attribute(_number(ABOVE_ZERO), None, unit=EVERY_SYNAPSE["delay"].unit)


def _law_class(law: SynapseLaw) -> type[Node]:
    in_parts = {
        name for classes in law.parts.values() for part in classes.values() for name in part.parameters
    }
    own = {name: one for name, one in law.parameters.items() if name not in in_parts}
    parts = {argument: child(_part_class(argument, law)) for argument in law.parts}
    return _class(SynapseModel, law.pynn, law.summary, {**_declared(own), **parts})


def _part_class(argument: str, law: SynapseLaw) -> type[Node]:
    """Return the class of one part of a plasticity rule, with a subclass for each choice."""
    title = "".join(map(str.capitalize, argument.split("_")))
    base = type(
        title, (Node,), {"__doc__": f"The {argument.replace('_', ' ')} of plasticity.", "abstract": True}
    )
    for name, part in law.parts[argument].items():
        parameters = {each: law.parameters[each] for each in part.parameters}
        _PARTS.append(_class(base, name, part.summary, _declared(parameters)))
    return base


_PARTS: Final[list[type[Node]]] = []
"""Keeps the classes alive: a class refers to its subclasses only weakly."""
SYNAPSE_CLASSES: Final = {law.pynn: _law_class(law) for law in LAWS.values()}


# -- connectors


@dataclass(frozen=True, slots=True, kw_only=True)
class Connector(Node, abstract=True):
    """Which cells are connected."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllToAllConnector(Connector):
    """Connects every cell to every cell."""

    allow_self_connections: bool = attribute(TRUTH, True, name="selfConnections")


@dataclass(frozen=True, slots=True, kw_only=True)
class OneToOneConnector(Connector):
    """Connects the first cell to the first, the second to the second, and so on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedProbabilityConnector(Connector):
    """Connects each pair of cells with the same probability."""

    p_connect: float = attribute(_number(FRACTION), name="probability")
    allow_self_connections: bool = attribute(TRUTH, True, name="selfConnections")


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedNumberPreConnector(Connector):
    """Connects each target to the same number of random sources."""

    n: int = attribute(POSITIVE)
    allow_self_connections: bool = attribute(TRUTH, True, name="selfConnections")


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedNumberPostConnector(Connector):
    """Connects each source to the same number of random targets."""

    n: int = attribute(POSITIVE)
    allow_self_connections: bool = attribute(TRUTH, True, name="selfConnections")


# -- the brain


@dataclass(frozen=True, slots=True, kw_only=True)
class Population(Node):
    """Cells of one model."""

    name: str = attribute(VARIABLE)
    size: int = attribute(POSITIVE, name="cells")
    cells: CellModel = child(CellModel, name="model")


@dataclass(frozen=True, slots=True, kw_only=True)
class Projection(Node):
    """Synapses from one population, or some of its cells, to another."""

    name: str = attribute(WORD)
    source: str = attribute(OF_POPULATION)
    source_cells: str | None = attribute(CELLS_RANGE, None, name="sourceCells")
    target: str = attribute(OF_POPULATION)
    target_cells: str | None = attribute(CELLS_RANGE, None, name="targetCells")
    receptor: Receptor = attribute(RECEPTOR, Receptor.EXCITATORY)
    connector: Connector = child(Connector)
    synapse: SynapseModel = child(SynapseModel)


@dataclass(frozen=True, slots=True, kw_only=True)
class Brain(Node):
    """A whole brain.

    Args:
        timestep: of its simulation, ms.
        intervention: the interventions of the experiment, which are no part of the script.
    """

    timestep: float = attribute(_number(ABOVE_ZERO), 0.1, unit="ms")
    population: tuple[Population, ...] = children(Population)
    projection: tuple[Projection, ...] = children(Projection)
    intervention: tuple[Intervention, ...] = children(Intervention)


def weight_unit(brain: Brain, projection: Projection) -> str:
    """Return the unit of a projection's weights, set by its target; empty: the target takes no synapses."""
    target = next((one for one in brain.population if one.name == projection.target), None)
    return "" if target is None else CELLS[type(target.cells).__name__].weight_unit
