"""Populations and projections with the arguments, settings and methods that only sPyNNaker has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any, Final

import numpy as np
from pyNN.core import IndexBasedExpression
from pyNN.parameters import ParameterSpace
from pyNN.parameters import Sequence as Train

from nrp_core.brain import RECEPTORS, FloatArray, Synapses
from nrp_core.clock import from_milliseconds
from nrp_core.errors import CapabilityError, NetworkError, did_you_mean
from nrp_core.network.pynn import populations, projections
from nrp_core.network.pynn.arguments import InvalidValueError, require_kind
from nrp_core.network.pynn.populations import SPIKE_TIMES
from nrp_spynnaker.dialect import neo_convertor
from nrp_spynnaker.dialect.cells import ascending
from nrp_spynnaker.dialect.connectors import ConvolutionConnector
from nrp_spynnaker.dialect.spynnaker7 import SPIKES, Pynn07Cells
from nrp_spynnaker.dialect.unsupported import POPULATIONS, refuse_attribute
from nrp_spynnaker.pynn07 import by_name

SUMMED: Final = "max_expected_summed_weight"
_SUMMED_WEIGHTS: Final = ("max_summed_weight_exc", "max_summed_weight_inh")
_HINTS: Final = {
    "neurons_per_core": "neurons_per_core",
    "n_synapse_cores": "synapse_cores",
    "spikes_per_second": "spikes_per_second",
    "ring_buffer_sigma": "ring_buffer_sigma",
    "n_steps_per_timestep": "n_steps_per_timestep",
}
_AHEAD_MS: Final = 1000.0
"""For how long spikes of sources without an end are drawn in advance."""
_PACKETS: Final = "packets-per-timestep"
_MOST_ON_CORE: Final = 256
"""Neurons that a core takes."""
_WITHOUT_EFFECT: Final = {
    "incoming_spike_buffer_size": "no spike is lost here",
    "drop_late_spikes": "no spike is late here",
    "n_colour_bits": "no packet is late here",
    "allow_delay_extensions": "delays of any length are extended",
    "seed": "random numbers follow the seed of setup",
    "max_rate": "a rate may have any value",
    "n_data_specs": "nothing is loaded onto a machine",
    "port": "only a SpikeInjector receives spikes",
    "virtual_key": "only a SpikeInjector receives spikes",
    "reserve_reverse_ip_tag": "nothing is loaded onto a machine",
    "splitter": "",
    "splitter_object": "",
}
"""The settings that change nothing, and why; none for those that are treated elsewhere."""


class Splitter:
    """How sPyNNaker divides a population among cores.

    Args:
        n_synapse_vertices: the number of synapse-only cores for each core of neurons, if it has any.
    """

    def __init__(self, n_synapse_vertices: Any = None, *_: Any, **__: Any) -> None:
        self.hints: dict[str, float] = {}
        if isinstance(n_synapse_vertices, (int, np.integer)):
            self.hints = {"synapse_cores": float(n_synapse_vertices)}


def cells_per_core(owner: str, given: Any) -> float:
    """Return the number of cells on a core, given as a number or, for a grid of cells, one for each axis.

    Parts of a cell are ignored, as in sPyNNaker.

    Raises:
        InvalidValueError: it is not a whole number of 1 or more.
    """
    numbers = given if isinstance(given, (tuple, list)) else [given]
    if not numbers or not all(isinstance(n, (int, float, np.number)) and 1 <= n < np.inf for n in numbers):
        raise InvalidValueError(
            f"{owner}: neurons_per_core is {given!r}; it must be a whole number of 1 or more, or one for "
            "each axis of a grid"
        )
    return float(np.prod([int(n) for n in numbers]))


def hints_of(owner: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Return the hints in ``additional_parameters``.

    Raises:
        NetworkError: the setting does not exist, or its value is impossible.
    """
    hints: dict[str, float] = {}
    for name, value in given.items():
        if name in _WITHOUT_EFFECT:
            hints |= getattr(value, "hints", {})
        elif value is None:
            continue
        elif name == SUMMED:
            hints |= zip(_SUMMED_WEIGHTS, _numbers(owner, value), strict=True)
        elif name == "neurons_per_core":
            hints[name] = cells_per_core(owner, value)
        elif name in _HINTS:
            hints[_HINTS[name]] = _numbers(owner, [value], name)[0]
            if name == "n_steps_per_timestep" and (value < 1 or value != int(value)):
                raise InvalidValueError(f"{owner}: {name} is {value!r}; it must be a whole number from 1 on")
        else:
            valid = [*_HINTS, SUMMED, *_WITHOUT_EFFECT]
            raise NetworkError(f"{owner} has no additional parameter '{name}'{did_you_mean(name, valid)}")
    return hints


def remarks_on(owner: str, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each setting that has no effect."""
    for name, value in given.items():
        if value is not None and _WITHOUT_EFFECT.get(name):
            yield f"{owner}: its additional parameter {name} has no effect: {_WITHOUT_EFFECT[name]}"


def _numbers(owner: str, values: Any, name: str = SUMMED) -> list[float]:
    each = list(values) if isinstance(values, (Sequence, np.ndarray)) else []
    if (name == SUMMED and len(each) != 2) or not all(isinstance(v, (int, float, np.number)) for v in each):
        expected = "two numbers, for excitation and inhibition" if name == SUMMED else "a number"
        raise InvalidValueError(f"{owner}: {name} is {values!r}; it must be {expected}")
    if any(not np.isfinite(v) or v < 0 for v in each):
        raise InvalidValueError(f"{owner}: {name} is {values!r}; it must be 0 or more, and finite")
    return [float(v) for v in each]


# mypy: disable-error-code="misc"


_NAMES: Final = ("weight", "delay")


class _Listed(IndexBasedExpression):
    """The value at a place for each pair of cells.

    Args:
        values: the values.
        row: how many places lie between those of two successive sources.
        column: how many lie between those of two successive targets.
    """

    def __init__(self, values: Any, row: int, column: int) -> None:
        self._values, self._row, self._column = values, row, column

    def __call__(self, i: Any, j: Any) -> Any:
        return self._values[i * self._row + j * self._column]


def one_by_one(synapse_type: Any, connector: Any, ends: Sequence[Any]) -> Any:
    """Return a synapse type whose lists of values are for single synapses, where the connector has an order.

    Args:
        synapse_type: the type that a script gives; None for none.
        connector: from each cell to one, or from each to all, source after source; others are left alone.
        ends: the cells on both sides.
    """
    name = type(connector).__name__
    space = getattr(synapse_type, "parameter_space", None)
    is_ordered = name in ("OneToOneConnector", "AllToAllConnector")
    if space is None or not is_ordered or not all(hasattr(end, "size") for end in ends):
        return synapse_type  # mistakes at an end are reported with the others
    pre, post = (cells.size for cells in ends)
    count, row, column = (pre, 1, 0) if name == "OneToOneConnector" else (pre * post, post, 1)
    bases = {key: np.asarray(space[key].base_value) for key in _NAMES if key in space.keys()}  # noqa: SIM118
    listed = {
        key: _Listed(base.astype(float), row, column)
        for key, base in bases.items()
        if base.shape == (count,) and base.dtype != object
    }
    if not listed:
        return synapse_type
    made = copy(synapse_type)
    made.parameter_space = ParameterSpace({**dict(space.items()), **listed}, space.schema)
    return made


def in_rows(synapse_type: Any, connector: Any, ends: Sequence[Any]) -> tuple[Any, Any, int]:
    """Return a synapse type and a connector as sPyNNaker reads a list of synapses.

    A list of weights or delays has one for each row; rows of cells that do not exist are ignored.

    Args:
        synapse_type: the type that a script gives; None for none.
        connector: any; only a list is changed.
        ends: the cells on both sides.

    Returns:
        the synapse type, the connector, and the number of ignored rows.
    """
    table = np.asarray(getattr(connector, "conn_list", ()))
    is_list = type(connector).__name__ == "FromListConnector" and table.ndim == 2
    if not is_list or not all(hasattr(end, "size") for end in ends):
        return synapse_type, connector, 0
    space: Any = getattr(synapse_type, "parameter_space", None)
    names, columns, single = list(connector.column_names), [table], dict[str, float]()
    for key in _NAMES if space is not None else ():
        base = np.asarray(space[key].base_value) if key in space.keys() else np.empty(())  # noqa: SIM118
        if base.shape == (len(table),) and base.dtype != object and key not in names:
            columns.append(base.astype(float)[:, None])
            names.append(key)
            single[key] = float(base[0])
    exists = (table[:, 0] < ends[0].size) & (table[:, 1] < ends[1].size)
    lost = int((~exists).sum())
    if not (single or lost) or lost == len(table):
        return synapse_type, connector, 0
    if single:
        synapse_type = copy(synapse_type)
        synapse_type.parameter_space = ParameterSpace({**dict(space.items()), **single}, space.schema)
    return synapse_type, type(connector)(np.hstack(columns)[exists], column_names=names), lost


# mypy: disable-error-code="misc"


_ROUNDING: Final = 1e-3
"""How far the size of a population may be from a whole number."""


class _Cells(Pynn07Cells):
    """Parameters and positions as sPyNNaker returns them."""

    @property
    def _size(self) -> int:
        """The number of cells, which scripts also read by this name."""
        cells: Any = self
        return int(cells.size)

    @property
    def positions(self) -> FloatArray:
        """The positions of the cells, um, shape ``(n, 3)``."""
        cells: Any = self
        found: FloatArray = cells._owner().places[cells._indices()]
        return found

    @property
    def position_generator(self) -> Any:
        """A function that returns the position of the cell at an index."""
        return lambda index: self.positions[index]

    def nearest(self, position: Any) -> Any:
        """Return the cell that is closest to a position."""
        cells: Any = self
        return cells[int(((self.positions - np.asarray(position)) ** 2).sum(axis=1).argmin())]

    def save_positions(self, file: Any) -> None:
        """Write the index and the position of each cell to a file."""
        rows = np.column_stack([np.arange(len(self.positions)), self.positions])
        np.savetxt(file, rows, fmt=["%d", "%g", "%g", "%g"])

    def _get_cell_position(self, cell: Any) -> FloatArray:
        cells: Any = self
        found: FloatArray = self.positions[cells.id_to_index(cell)]
        return found

    def get(self, parameter_names: Any, gather: bool = True, simplify: bool = True) -> Any:
        """Return a value for each cell, by name if there are several names."""
        read: Any = super().get
        if isinstance(parameter_names, str):
            return read(parameter_names, simplify=False)
        return dict(zip(parameter_names, read(list(parameter_names), simplify=False), strict=True))


class Population(_Cells, populations.Population):
    """A group of cells, with the settings of sPyNNaker.

    Args:
        constraints: ignored, as they place cells on a machine.
        additional_parameters: settings of the population on the machine.
        settings: the same, as keyword arguments.
    """

    def __init__(
        self, size: Any, cellclass: Any, cellparams: Mapping[str, Any] | None = None, structure: Any = None,
        initial_values: Mapping[str, Any] | None = None, label: str | None = None, constraints: Any = None,
        additional_parameters: Mapping[str, Any] | None = None, **settings: Any,
    ) -> None:  # fmt: skip
        if isinstance(structure, str):  # version 7 took the label there, too
            structure, label = None, label or structure
        if isinstance(cellclass, type):
            cellclass, cellparams = cellclass(**(cellparams or {})), None
        if isinstance(size, (float, np.floating)) and abs(float(size) - np.round(size)) < _ROUNDING:
            size = round(size)
        require_kind(
            f"population '{label}'", "additional_parameters", additional_parameters, (Mapping, type(None)),
            "a dictionary",
        )  # fmt: skip
        begins = {**getattr(cellclass, "given_state", {}), **(initial_values or {})}
        super().__init__(size, cellclass, cellparams, structure, begins, label)
        if hasattr(cellclass, "variable"):
            self._draw_rates(cellclass.variable)
        own = getattr(cellclass, "settings", {})
        owner, given = f"population '{self.label}'", {**own, **(additional_parameters or {}), **settings}
        defaults = self._simulator.state.hints_by_cell.get(type(cellclass), {})
        self.hints = {**defaults, **hints_of(owner, given)}
        self._limit_cells_per_core()
        if constraints:
            self._place(*constraints if isinstance(constraints, list) else [constraints])
        if hasattr(cellclass, "hub"):
            cellclass.hub.inject_into(self, given.pop("port", None), given.pop("virtual_key", None))
            if cellclass.program is not None:
                cellclass.hub.notify(*cellclass.program)
        for text in remarks_on(owner, given):
            self._simulator.state.remark(text)

    def _draw_rates(self, rates: Any) -> None:
        state = self._simulator.state
        stream = state.stream(f"population/{self.label}/rates")
        if rates.has_end:
            self.set(spike_times=rates.trains(self.size, stream, state.dt))
            return
        if not hasattr(state, "before_run"):
            raise CapabilityError(
                f"population '{self.label}': its durations are missing; spikes are drawn before the run, and "
                "need an end"
            )
        trains = [np.empty(0)] * self.size

        def extend(until_ms: float) -> None:
            nonlocal trains
            if from_milliseconds(until_ms) > from_milliseconds(rates.drawn_ms):
                more = rates.trains(self.size, stream, state.dt, until_ms + _AHEAD_MS)
                trains = [np.append(old, new.value) for old, new in zip(trains, more, strict=True)]
                self.set(spike_times=[Train(times) for times in trains])

        rates.trains(self.size, stream, state.dt, 0.0)  # the lists are checked here
        state.before_run.append(extend)

    def record(self, variables: Any = SPIKES, *arguments: Any, **options: Any) -> None:
        """Record variables of all cells; ``all`` are those that its cells have."""
        if variables == _PACKETS or (isinstance(variables, (list, tuple)) and _PACKETS in variables):
            raise CapabilityError(
                f"population '{self.label}': '{_PACKETS}' counts the packets that each core of a real "
                "machine has handled in each step, which depends on their time of arrival; "
                "record('spikes') of the sources gives the spikes that the population receives"
            )
        super().record(self.celltype.recordable if variables == "all" else variables, *arguments, **options)

    @by_name
    def set(self, **parameters: Any) -> None:
        """Set parameters of all cells; state variables too, before the network runs."""
        state = {name: parameters.pop(name) for name in self.initial_values.keys() & parameters.keys()}
        if state and self._simulator.state.t > 0:
            raise CapabilityError(
                f"population '{self.label}': {', '.join(sorted(state))} is part of the state of its cells, "
                "which cannot be set while the network runs; initialize() sets it at the beginning of a run"
            )
        if state:
            self.initialize(**state)
        if SPIKE_TIMES in parameters:
            parameters[SPIKE_TIMES] = ascending(parameters[SPIKE_TIMES])
        super().set(**parameters)

    initialize = by_name(populations.Population.initialize)

    def store_initial_values(self, variable: str, values: Any, where: Any) -> None:
        """Store initial values of cells, in a run those after the next reset."""
        state, store = self._simulator.state, super().store_initial_values
        if getattr(state, "brain", None) is None or state.t == 0:
            store(variable, values, where)
            return
        state.warn([f"initialize({variable}) of '{self.label}' has an effect after reset(), as in sPyNNaker"])
        state.after_reset.append(lambda: store(variable, values, where))

    def cell_view(self, place: int) -> PopulationView:
        """Return the cell at an index as a view, which one cell is in sPyNNaker."""
        view: PopulationView = self[place : place + 1]
        return view

    def rset(self, parametername: str, rand_distr: Any) -> None:
        """Set a parameter of all cells."""
        self.set(**{parametername: rand_distr})

    def tset(self, parametername: str = "", value_array: Any = None, **parameters: Any) -> None:
        """Set a parameter of each cell; or parameters by name, as in sPyNNaker8."""
        more = {parametername: np.ravel(value_array)} if parametername else {}
        self.set(**parameters, **more)

    def randomInit(self, rand_distr: Any) -> None:  # noqa: N802
        """Set the initial voltages."""
        self.initialize(v=rand_distr)

    def set_max_atoms_per_core(self, max_atoms_per_core: Any) -> None:
        """Set the largest number of cells on a core of the machine."""
        count = cells_per_core(f"population '{self.label}'", max_atoms_per_core)
        self.hints = {**self.hints, "neurons_per_core": count}
        self._limit_cells_per_core()

    def _limit_cells_per_core(self) -> None:
        """Reduce the number of neurons on a core to the core's capacity, as sPyNNaker does."""
        count = self.hints.get("neurons_per_core", 0.0)
        if count > _MOST_ON_CORE and self.celltype.receptor_types:
            self.hints = {**self.hints, "neurons_per_core": float(_MOST_ON_CORE)}
            self._simulator.state.remark(
                f"population '{self.label}': neurons_per_core is {count:g}, but a core takes at most "
                f"{_MOST_ON_CORE} neurons; it has {_MOST_ON_CORE}"
            )

    def _place(self, constraint: Any = None, *_: Any, **__: Any) -> None:
        if getattr(constraint, "size", None) is not None:
            self.set_max_atoms_per_core(constraint.size)
            return
        self._simulator.state.remark(
            f"population '{self.label}' is placed by the mapper; the place in the script has no effect"
        )

    add_placement_constraint = set_constraint = set_mapping_constraint = _place

    def spinnaker_get_data(
        self, variable: Any, as_matrix: bool = False, view_indexes: Any = None
    ) -> FloatArray:
        """Return recorded data as rows of cell, time (ms) and value.

        Args:
            variable: one name, or a list of one.
            as_matrix: return the values only, shape ``(n_samples, n_cells)``; not for spikes.
            view_indexes: the cells to return, by default all.
        """
        names = [variable] if isinstance(variable, str) else list(variable)
        if len(names) != 1:
            raise NetworkError(
                f"population '{self.label}': spinnaker_get_data takes one variable, not {names}"
            )
        data = self.get_data(names)
        if as_matrix and names != ["spikes"]:
            values = np.asarray(data.segments[-1].filter(name=names[0])[0].magnitude)
            return values if view_indexes is None else values[:, list(view_indexes)]
        rows = neo_convertor.convert_data(data, names[0], run=len(data.segments) - 1)
        return rows if view_indexes is None else rows[np.isin(rows[:, 0], list(view_indexes))]

    @classmethod
    def create(cls, cellclass: Any, cellparams: Mapping[str, Any] | None = None, n: int = 1) -> Population:
        """Return a population of ``n`` cells."""
        return cls(n, cellclass, cellparams)

    def index_to_id(self, index: Any) -> Any:
        """Return the ID of the cell at an index, or of those at several."""
        cells = [self[int(each)] for each in np.atleast_1d(index)]
        return cells if np.iterable(index) else cells[0]

    def __getattr__(self, name: str) -> Any:
        refuse_attribute(type(self), name, POPULATIONS)

    def set_initial_value(self, variable: str, value: Any, selector: Any = None) -> None:
        """Set the initial value of a state variable, of all cells or of those at an index."""
        (self if selector is None else self[selector]).initialize(**{variable: value})

    def get_initial_value(self, variable: str, selector: Any = None) -> FloatArray:
        """Return the initial values of a state variable."""
        values = self.initial_arrays[variable]
        return values if selector is None else values[selector]

    def get_initial_values(self, selector: Any = None) -> dict[str, FloatArray]:
        """Return the initial values of all state variables by name, of all cells or of those at an index."""
        return {name: self.get_initial_value(name, selector) for name in self.initial_arrays}


class PopulationView(_Cells, populations.PopulationView):
    """Some cells of a population, with the methods of sPyNNaker."""

    @property
    def initial_values(self) -> dict[str, FloatArray]:
        """The initial values of these cells by state variable."""
        chosen = self._indices()
        return {name: values[chosen] for name, values in self._owner().initial_arrays.items()}

    def spinnaker_get_data(self, variable: Any, as_matrix: bool = False) -> FloatArray:
        """Return recorded data of these cells, see :meth:`Population.spinnaker_get_data`."""
        found: FloatArray = self._owner().spinnaker_get_data(variable, as_matrix, self._indices())
        return found

    def __getattr__(self, name: str) -> Any:
        refuse_attribute(type(self), name, POPULATIONS)


def convolution(static: Any) -> type:
    """Return the type of synapses whose weights are those of a connector's kernel.

    Args:
        static: the class of PyNN's ``StaticSynapse``.
    """

    def begin(self: Any, delay: float | None = None) -> None:
        static.__init__(self, delay=delay)

    return type(
        "Convolution", (static,), {"__init__": begin, "__doc__": "Synapses with weights of a kernel."}
    )


_ENDS: Final = {"source": "presynaptic_index", "target": "postsynaptic_index"}
"""The names that ``Projection.get`` of sPyNNaker has for the indices of the cells."""


class Projection(projections.Projection):
    """Synapses whose receptor decides whether they inhibit, not the sign of their weights, as in sPyNNaker.

    The receptor is ``excitatory`` unless it is given.

    Attributes:
        negative: the synapses of the negative weights of a convolution, which have another receptor.
    """

    negative: Projection | None = None

    def __init__(
        self, pre_synaptic_population: Any, post_synaptic_population: Any, connector: Any = None,
        synapse_type: Any = None, source: Any = None, receptor_type: str | None = None, space: Any = None,
        label: str | None = None, download_synapses: bool = False, partition_id: Any = None, **unknown: Any,
    ) -> None:  # fmt: skip
        ends = (pre_synaptic_population, post_synaptic_population)
        if hasattr(synapse_type, "rewiring") and not all(isinstance(end, Population) for end in ends):
            raise CapabilityError(
                f"{type(synapse_type).__name__}: its synapses form between all cells of two populations, not "
                "of views or assemblies"
            )
        signed = isinstance(connector, ConvolutionConnector)
        if signed:
            receptor_type = connector.positive_receptor_type if receptor_type is None else receptor_type
        receptor_type = receptor_type or "excitatory"
        synapse_type = one_by_one(synapse_type, connector, ends)
        synapse_type, connector, lost = in_rows(synapse_type, connector, ends)
        super().__init__(*ends, connector, synapse_type, source, receptor_type, space, label, **unknown)
        if lost:
            self._simulator.state.remark(
                f"{lost} synapses in the list of the projection '{self.label}' are left out, since their "
                "cells do not exist"
            )
        if signed and (other := connector.negative()) is not None:
            self.negative = type(self)(
                *ends, other, synapse_type, source, connector.negative_receptor_type, space,
                f"{self.label} (negative)",
            )  # fmt: skip

    def column(self, name: str) -> Any:
        """Return an index or a parameter of all current synapses, shape ``(n_synapses,)``.

        Weights are sizes, as a machine has no others; those of a kernel have its signs. ``source`` and
        ``target`` are indices, too.
        """
        name, found = _ENDS.get(name, name), self._current()
        if self.negative is not None:
            own, other = super().column(name), self.negative.column(name)
            return np.concatenate([own, -abs(other) if name == "weight" else other])
        if found is None:
            values = super().column(name)
            return abs(values) if name == "weight" else values
        own = {
            "presynaptic_index": found.pre_index, "postsynaptic_index": found.post_index,
            "weight": found.weight, "delay": found.delay_ms,
        }  # fmt: skip
        if name in own:
            return own[name]
        return np.full(len(found.weight), self.synapse_type.rewiring.parameters[name])

    def __len__(self) -> int:
        found, more = self._current(), 0 if self.negative is None else len(self.negative)
        return super().__len__() + more if found is None else len(found.weight)

    def get(
        self, attribute_names: Any, format: str, gather: Any = True, with_address: bool = True,  # noqa: A002
        multiple_synapses: str = "last",
    ) -> Any:  # fmt: skip
        """Return parameters of all synapses, as sPyNNaker does: a list in the order of sources, then targets.

        A single parameter is an array, also if its name is in a list. All other formats are matrices.
        """
        format = "list" if format == "list" else "array"  # noqa: A001
        names = [attribute_names] if isinstance(attribute_names, str) else list(attribute_names)
        if format == "list" and with_address:  # which are the source and the target
            names = [name for name in names if name not in _ENDS]
        if not names and format == "list" and with_address:  # the pairs alone
            ends = super().get("weight", format, gather, True, multiple_synapses)
            return sorted((pre, post) for pre, post, _ in ends)
        found = super().get(names, format, gather, with_address, multiple_synapses)
        if format == "array":
            return found[0] if len(names) == 1 else tuple(found)
        order = np.lexsort([self.column("postsynaptic_index"), self.column("presynaptic_index")])
        if len(names) == 1 and not with_address:
            return np.ravel(found)[order]
        return [found[place] for place in order]

    @property
    def _state_variables(self) -> frozenset[str]:
        return super()._state_variables | _ENDS.keys()

    def set_download_synapses(self, download_synapses: bool) -> None:
        """Have no effect: synapses are always at hand."""

    def _change(self, values: Mapping[str, FloatArray]) -> None:
        if self.negative is not None:
            raise CapabilityError(
                f"{self._name}: the synapses of a convolution with negative weights are fixed"
            )
        super()._change(values)

    def _current(self) -> Synapses | None:
        """Return the synapses that there are now if they form and vanish while the network runs."""
        if getattr(self.synapse_type, "rewiring", None) is None:
            return None
        return self._simulator.state.synapses_of(self)

    def _with_delays(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
        """Return values whose delays are one time step at least, as those of sPyNNaker."""
        delays, least = values.get("delay"), self._simulator.state.dt
        if delays is None or not (short := delays < least).any():
            return values
        self._simulator.state.remark(
            f"{self._name}: {np.count_nonzero(short)} delays are below a time step of {least:g} ms, and "
            "become one"
        )
        return {**values, "delay": np.maximum(delays, least)}

    def _meant(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
        values, weight = self._with_delays(values), values.get("weight")
        if self.receptor_type not in RECEPTORS or weight is None:
            return values
        below = weight < 0
        if below.any() and (weight > 0).any():
            return values  # which is refused
        inhibits = self.receptor_type == "inhibitory"
        if below.any() and not inhibits:
            self._simulator.state.remark(
                f"{self._name}: its weights are negative, and sPyNNaker takes their size, so they excite; is "
                "receptor_type='inhibitory' meant?"
            )
        size = abs(weight)
        return {**values, "weight": -size if inhibits and not self.post.conductance_based else size}
