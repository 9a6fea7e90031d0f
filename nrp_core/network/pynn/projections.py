"""PyNN's projections over flat arrays of synapses."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from pyNN import common
from pyNN.connectors import Connector
from pyNN.models import BaseSynapseType
from pyNN.parameters import LazyArray, ParameterSpace
from pyNN.random import RandomDistribution
from pyNN.space import Space

from nrp_core._support.arrays import BoolArray, FloatArray, IndexArray
from nrp_core.clock import from_milliseconds, nanoseconds
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean
from nrp_core.network.changes import DOPAMINE, SYNAPSE_STATE
from nrp_core.network.drawing import Columns
from nrp_core.network.indices import ends_of, folded, indices_of
from nrp_core.network.limits import check_synapses, limits_of_synapses
from nrp_core.network.parameters import Limit
from nrp_core.network.pynn.arguments import (
    InvalidSynapseError,
    UnknownSynapseError,
    computing,
    raising,
    require_kind,
    require_names,
    require_shape,
)
from nrp_core.network.pynn.populations import parts_of, require_existing
from nrp_core.network.pynn.simulator import Simulator
from nrp_core.network.pynn.synapse_columns import SynapseColumns, drawn_row_by_row, evaluated
from nrp_core.network.synapses import ELECTRICAL, LAWS, STDP

_CELLS = (common.BasePopulation, common.Assembly)
_NONE = type(None)
_PARTS = (
    ("source", _CELLS, "a population, view or assembly"),
    ("target", _CELLS, "a population, view or assembly"),
    ("connector", Connector, "one such as sim.AllToAllConnector()"),
    ("synapse type", (BaseSynapseType, _NONE), "one such as sim.StaticSynapse()"),
    ("space", (Space, _NONE), "one such as sim.Space()"),
)
"""The arguments of a projection: name, classes and an example for messages."""
_ARGUMENTS = ("connector", "synapse_type", "source", "receptor_type", "space", "label")
_OF_POINTS = ("source_section.gap",)
"""Where PyNN has the halves of gap junctions, in NEURON; cells that are points have no other place."""
_OPERATIONS = {"sum": (np.add, 0.0), "min": (np.minimum, np.inf), "max": (np.maximum, -np.inf)}


@folded("pre_index", "post_index")
class Projection(common.Projection):
    """Synapses between two groups of cells.

    Attributes:
        pre_index, post_index: cells within the two groups, shape ``(n_synapses,)``.
        values: weight, delay and all other parameters, PyNN's units, shape ``(n_synapses,)``; those of large
            projections may be drawn again for each read.
        initial_state: state variables at time 0 by the names of the law, shape ``(n_synapses,)``.
        has_own_label: whether the script gave it a label.
        made_at: the file and line of the script, as far as known.
        given: the weight and delay from the script; None if it gave each synapse its own.
    """

    _simulator: Simulator
    pre_index: IndexArray
    post_index: IndexArray
    initial_state: dict[str, FloatArray]

    def __init__(
        self, presynaptic_population: Any, postsynaptic_population: Any, connector: Any = None,
        synapse_type: Any = None, source: str | None = None, receptor_type: str | None = None,
        space: Space | None = None, label: str | None = None, **unknown: Any,
    ) -> None:  # fmt: skip
        ends = (presynaptic_population, postsynaptic_population)
        require_names("a projection", unknown, _ARGUMENTS)
        self.has_own_label, self.made_at = bool(label), _line_of_the_script()
        label = label or "→".join(str(getattr(cells, "label", cells)) for cells in ends)
        for (what, kinds, valid), part in zip(_PARTS, (*ends, connector, synapse_type, space), strict=True):
            require_kind(f"projection '{label}'", what, part, kinds, valid)
        _complete(connector)
        if getattr(synapse_type, "kind", None) == ELECTRICAL:  # PyNN names the places of both halves
            source, receptor_type = (None if each in _OF_POINTS else each for each in (source, receptor_type))
        usual = receptors = postsynaptic_population.receptor_types
        if not receptors:
            is_given = any(
                hasattr(cells.celltype, "equations") for cells in parts_of(postsynaptic_population)
            )
            why = "equations have no receptor; give `receptors`" if is_given else "cells only emit spikes"
            raise NetworkError(f"a projection ends on '{postsynaptic_population.label}', whose {why}")
        own = getattr(synapse_type, "receptors", None)
        receptors = own or receptors
        if receptor_type not in receptors and (own or receptor_type not in (None, "default")):
            hint = did_you_mean(str(receptor_type), receptors)
            to = f" for {type(synapse_type).__name__}" if own else ""
            raise InvalidSynapseError(
                f"projection '{label}': the cells of '{postsynaptic_population.label}' have no receptor "
                f"'{receptor_type}'{to}{hint}"
            )
        if synapse_type is not None:  # PyNN guesses the receptor from a weight
            shape = (presynaptic_population.size, postsynaptic_population.size)
            require_shape(f"projection '{label}'", synapse_type.parameter_space, shape)
        super().__init__(
            presynaptic_population, postsynaptic_population, connector, synapse_type, source,
            usual[0] if own else receptor_type, space or Space(), label,
        )  # fmt: skip
        if own:
            self.receptor_type = str(receptor_type)
        if source is not None:
            self._simulator.state.remark(
                f"'source' of the projection '{label}' is {source!r} and has no effect: cells are points"
            )
        for cells in (self.pre, self.post):
            require_existing(cells.label, cells, self._simulator.state)
        self._simulator.state.before_change()
        self.values, self.initial_state = Columns(), {}
        self._columns = SynapseColumns(self.pre.size)
        with computing(f"{self._name}: its {type(connector).__name__} fails", InvalidSynapseError):
            connector.connect(self)
        pre, post, values = self._columns.joined()
        self.__dict__.update(pre_index=pre, post_index=post)
        for name in self.synapse_type.get_parameter_names():
            self.values[name] = values.pop(name, np.empty(0))
        listed = getattr(connector, "column_names", ())
        given = {"weight": self.synapse_type.weight, "delay": self.synapse_type.delay}
        self.given = {name: None if name in listed else value for name, value in given.items()}
        self.values.update(self._meant(self.values))
        self._check(self.values)
        self._simulator.state.projections.append(self)

    @property
    def connector(self) -> Any:
        """The connector that made the synapses."""
        return self._connector

    def _static_synapse_class(self) -> Any:
        return self._simulator.types["StaticSynapse"]()

    def __len__(self) -> int:
        return len(indices_of(self, "pre_index"))

    @property
    def connections(self) -> list[Connection]:
        """Every synapse as an object."""
        return list(self)

    def __getitem__(self, index: Any) -> Any:
        try:
            chosen = np.arange(len(self))[index]
        except IndexError:
            raise UnknownSynapseError(
                f"{self._name} has no synapse {index!r}; they are numbered 0..{len(self) - 1}"
            ) from None
        return Connection(self, int(chosen)) if np.ndim(chosen) == 0 else [self[i] for i in chosen]

    def ends(self, synapse: int) -> tuple[int, int]:
        """Return the indices of the two cells that a synapse connects."""
        return ends_of(self, synapse)

    # -- called by connectors

    def _convergent_connect(
        self, presynaptic_indices: Any, postsynaptic_index: int, location_selector: Any = None, **values: Any
    ) -> None:
        self.add_synapses(presynaptic_indices, postsynaptic_index, values, location_selector)

    def add_synapses(self, pre: Any, post: Any, values: Mapping[str, Any], location: Any = None) -> None:
        """Add synapses from cells ``pre`` to the cell, or the cells, ``post``; both are indices."""
        if location is not None:
            raise CapabilityError(f"{self._name}: cells are points; leave out the location_selector")
        self._columns.add(pre, post, values)

    def add_all(self, pre: Any, counts: Any, values: Mapping[str, Any]) -> None:
        """Add all synapses at once, in the order of their targets; see :meth:`SynapseColumns.add_all`."""
        self._columns.add_all(pre, counts, values)

    # -- reading and changing synapses

    def get(self, attribute_names: Any, *arguments: Any, **options: Any) -> Any:
        """Return parameters of all synapses, see PyNN.

        Synapses with STDP that learn from rewards also have the state ``eligibility`` and ``dopamine``, and
        synapses in equations their state variables.

        Raises:
            UnknownParameterError: the synapses have no such parameter.
        """
        names = [attribute_names] if isinstance(attribute_names, str) else attribute_names
        self._require(names, self._state_variables)
        with computing(f"{self._name}: {attribute_names} cannot be read", InvalidSynapseError):
            return super().get(attribute_names, *arguments, **options)

    @property
    def _state_variables(self) -> frozenset[str]:
        equations = getattr(self.synapse_type, "equations", None)
        if equations is None:
            return SYNAPSE_STATE if self.synapse_type.kind == STDP else frozenset()
        return frozenset([*equations.model.variables, *([DOPAMINE] if equations.model.eligibility else [])])

    def set(self, **attributes: Any) -> None:
        """Set parameters of all synapses.

        Args:
            attributes: a number, distribution, function of the distance, matrix, or one number a
                synapse (in the order of a matrix, row by row).
        """
        self._require(attributes)
        with computing(f"{self._name}: {', '.join(attributes)} cannot be computed", InvalidSynapseError):
            values = {name: self._evaluated(name, value) for name, value in attributes.items()}
        self._change(values)
        self.given.update(attributes)

    def _require(self, names: Iterable[str], more: Iterable[str] = ()) -> None:
        known = [*self.synapse_type.get_parameter_names(), *sorted(more)]
        require_names(f"{self._name}: {type(self.synapse_type).__name__}", names, known)

    def set_one(self, name: str, synapse: int, value: float) -> None:
        """Set a parameter of the synapse at an index."""
        self._require([name])
        values = self.column(name).copy()
        values[synapse] = value
        self._change({name: values})
        self.given[name] = None

    def _change(self, values: Mapping[str, FloatArray]) -> None:
        values = self._meant(values)
        self._check(values)
        if self in self._simulator.state.projections:
            self._simulator.state.before_synapses(self, values)
        self.values.update(values)

    def initialize(self, **initial_values: Any) -> None:
        """Set state variables of all synapses at time 0, each value in the forms of :meth:`set`.

        Raises:
            UnknownParameterError: the synapses have no such variable.
            CapabilityError: the network has run, and has not been reset.
        """
        law = LAWS.get(self.synapse_type.kind)
        state = {} if law is None or law.plastic else law.state
        complements = {} if law is None else law.complements
        require_names(f"{self._name}: the initial state", initial_values, [*state, *complements])
        self._simulator.state.before_change()
        for name, value in initial_values.items():
            with computing(f"{self._name}: {name} cannot be computed", InvalidSynapseError):
                base = value.base_value if isinstance(value, LazyArray) and value.is_homogeneous else value
                found = self._evaluated("weight", base)
            variable, whole = complements.get(name, (name, ""))
            if whole and not ((found >= 0) & (found <= self.values[whole])).all():
                raise InvalidSynapseError(f"{self._name}: initial values of {name} must be from 0 to {whole}")
            self.initial_state[variable] = self.values[whole] - found if whole else found
        if law is not None:
            law.require_shares(self._name, self.initial_state)
        self.initial_values.update(initial_values)

    def _evaluated(self, name: str, value: Any) -> FloatArray:
        if isinstance(value, (list, np.ndarray)) and np.ndim(value) == 1:
            if len(value) not in (1, len(self)):
                raise InvalidSynapseError(
                    f"{self._name}: {name} has {len(value)} values for {len(self)} synapses"
                )
            values = np.empty(len(self))
            values[np.lexsort((self.post_index, self.pre_index))] = value
            return values
        space = ParameterSpace({name: value}, self.synapse_type.get_schema(), self.shape)
        lazy = self._handle_distance_expressions(space)[name]
        drawn = isinstance(lazy.base_value, RandomDistribution) and not lazy.operations
        return (drawn_row_by_row if drawn else evaluated)(lazy, self.pre_index, self.post_index)

    def column(self, name: str) -> Any:
        """Return an index or a parameter of all synapses, shape ``(n_synapses,)``."""
        if name == "presynaptic_index":
            return self.pre_index
        if name == "weight":
            return self._simulator.state.weights_of(self)
        if name in self._state_variables:
            return self._simulator.state.synapse_state_of(self, name)
        return self.post_index if name == "postsynaptic_index" else self.values[name]

    def _get_attributes_as_list(self, names: Sequence[str]) -> list[tuple[float, ...]]:
        return list(zip(*(self.column(name).tolist() for name in names), strict=True))

    def _get_attributes_as_arrays(
        self, names: Sequence[str], multiple_synapses: str = "sum"
    ) -> list[FloatArray]:
        return [self._matrix(self.column(name), multiple_synapses) for name in names]

    def _matrix(self, column: FloatArray, multiple_synapses: str) -> FloatArray:
        """Return a column as a matrix, with NaN for pairs without a synapse."""
        matrix = np.full(self.shape, np.nan)
        pre, post = self.column("presynaptic_index"), self.column("postsynaptic_index")
        if multiple_synapses in _OPERATIONS:
            operation, start = _OPERATIONS[multiple_synapses]
            matrix[pre, post] = start
            operation.at(matrix, (pre, post), column)
        else:
            order = np.arange(len(pre))  # the last of several values for one element is kept
            order = order if multiple_synapses == "last" else order[::-1].copy()
            matrix[pre[order], post[order]] = column[order]
        return matrix

    @property
    def _name(self) -> str:
        return f"projection '{self.label}'"

    def routes(self) -> Iterator[tuple[str, int, BoolArray | None]]:
        """Yield each receptor with the sign to apply to its weights, and its synapses, None for all.

        A simulator may choose the receptor of each synapse by the sign of its weight.
        """
        yield str(self.receptor_type), 1, None

    def _meant(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
        """Return values as PyNN means them; a simulator may read them in another way."""
        return values

    def _check(self, values: Mapping[str, FloatArray]) -> None:
        conductance_based = self.post.conductance_based
        owners = [part._owner() for part in parts_of(self.post)]
        own = any(hasattr(owner.celltype, "equations") for owner in owners)  # which give signs their meaning
        signed = "weight" in values and (conductance_based or (self.connector.safe and not own))
        limits = {**limits_of_synapses(getattr(self.synapse_type, "equations", None)), **self._within()}
        with raising(InvalidSynapseError):
            check_synapses(
                self._name, self.ends, values, receptor=self.receptor_type,
                conductance_based=conductance_based, signed=signed, limits=limits,
            )  # fmt: skip

    def _within(self) -> Mapping[str, Limit]:
        """Return the limit of delays, if ``setup`` gives one; NEST refuses longer ones, too."""
        longest_ms = self._simulator.state.max_delay
        if np.isinf(longest_ms):
            return {}
        longest_ns = from_milliseconds(longest_ms)
        rule = f"from 0 ms to max_delay of setup, {longest_ms:g} ms"
        return {
            "delay": Limit(rule, lambda delays_ms: (delays_ms >= 0) & (nanoseconds(delays_ms) <= longest_ns))
        }


def _complete(connector: Any) -> None:
    """Give a connector of a user the attributes that it lacks if it does not call its base's constructor."""
    usual = {"safe": True, "callback": None, "location_selector": None, "parameter_names": ()}
    for name in [each for each in usual if not hasattr(connector, each)]:
        setattr(connector, name, usual[name])


def _line_of_the_script() -> tuple[str, int] | None:
    """Return the file and line whose call reached the platform."""
    frame = sys._getframe(1)
    while frame.f_globals.get("__name__", "").partition(".")[0] in ("nrp_core", "pyNN"):
        if frame.f_back is None:
            return None
        frame = frame.f_back
    return frame.f_code.co_filename, frame.f_lineno


class Connection(common.Connection):
    """One synapse; its parameters are attributes that can be read and set."""

    def __init__(self, projection: Projection, index: int) -> None:
        self.__dict__.update(_projection=projection, _index=index)

    def __getattr__(self, name: str) -> Any:
        if name in (ends := ("presynaptic_index", "postsynaptic_index")):
            return self._projection.ends(self._index)[ends.index(name)]
        try:
            return self._projection.column(name)[self._index].item()
        except KeyError:
            raise AttributeError(f"a synapse has no '{name}'") from None

    def __setattr__(self, name: str, value: float) -> None:
        self._projection.set_one(name, self._index, value)

    def as_tuple(self, *names: str) -> tuple[float, ...]:
        """Return several attributes."""
        return tuple(getattr(self, name) for name in names)
