"""PyNN's populations, views and assemblies over arrays; an ID is the neuron's global id."""

# mypy: disable-error-code="misc"

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt
from neo.io.baseio import BaseIO
from pyNN import common, errors, standardmodels
from pyNN.parameters import ArrayParameter, LazyArray, ParameterSpace, simplify

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.limits import check_cells, check_spike_times, check_values, limits_of_cells
from nrp_core.network.memory import require_memory
from nrp_core.network.pynn.arguments import (
    InvalidValueError,
    UnknownCellError,
    UnknownParameterError,
    UnknownVariableError,
    WrongKindError,
    computing,
    in_units,
    raising,
    require_kind,
    require_names,
    require_population,
    require_shape,
    require_values,
)
from nrp_core.network.pynn.models import columns_of, own_name, values_of
from nrp_core.network.pynn.rng import are_at_one_place, name_streams, named
from nrp_core.network.pynn.simulator import Simulator, State


class ID(int, common.IDMixin):
    """A cell of PyNN."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name != "parent" and not hasattr(type(self), name):
            self.parent._require([name])
        super().__setattr__(name, value)

    def __getattr__(self, name: str) -> Any:
        """Return a parameter; an attribute of populations is refused: one cell was given in place of some."""
        if name in ("parent", "set") or name.startswith("_"):
            return super().__getattr__(name)
        if name in vars(self.parent) or hasattr(type(self.parent), name):
            place = self.parent.id_to_index(self)
            if hasattr(self.parent, "cell_view"):  # a dialect in which a cell is a view
                return getattr(self.parent.cell_view(place), name)
            label = self.parent.label
            raise UnknownParameterError(
                f"this is one cell of '{label}', which has no '{name}'; a slice is a view of it: "
                f"[{place}:{place + 1}]"
            )
        return super().__getattr__(name)


SPIKE_TIMES = "spike_times"
BYTES_PER_CELL = 350
"""Measured size of PyNN's object for a cell."""
BYTES_PER_VALUE = 8

WRITTEN = (".nix", ".h5", ".nwb", ".pkl", ".pickle", ".mat")
"""The suffixes of files to which PyNN writes data."""


@cache
def _meant(name: str, parameters: tuple[str, ...]) -> str | None:
    """Return the parameter that an attribute is most alike, if any."""
    return next(iter(difflib.get_close_matches(name, parameters, n=1, cutoff=0.8)), None)


class _Cells(common.BasePopulation):
    """Base of populations and views: access to the arrays of a population."""

    _simulator: Simulator
    size: int

    @property
    def _assembly_class(self) -> type:
        bound: type = self._simulator.types["Assembly"]
        return bound

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a private attribute; :meth:`set` sets parameters, and PyNN would ignore others."""
        kind = vars(self).get("celltype") or getattr(vars(self).get("parent"), "celltype", None)
        meant = None if kind is None else _meant(name, tuple(kind.default_parameters))
        if meant is not None and not hasattr(type(self), name):
            raise UnknownParameterError(
                f"'{self.label}' has no attribute '{name}'; a parameter is set by .set({meant}=...)"
            )
        super().__setattr__(name, value)

    def _owner(self) -> Population:
        """Return the population that owns the arrays."""
        raise NotImplementedError

    def _indices(self) -> IntArray | slice:
        """Return the indices of these cells in the population."""
        raise NotImplementedError

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice) and isinstance(index.stop, int) and index.stop > self.size:
            self._simulator.state.remark(
                f"the slice {index.start or 0}:{index.stop} of '{self.label}' ends at {self.size}, "
                "its last cell"
            )
        try:
            return super().__getitem__(index)
        except (IndexError, TypeError):
            raise unknown_cells(self, index) from None

    def _get_view(self, selector: Any, label: str | None = None) -> PopulationView:
        view: PopulationView = self._simulator.types["PopulationView"](self, selector, label)
        return view

    def write_data(self, io: Any, *arguments: Any, **options: Any) -> None:
        """Write recorded data to a file, see PyNN.

        Raises:
            NetworkError: no file is of that kind.
        """
        _require_written(f"population '{self._owner().label}'", io)
        super().write_data(io, *arguments, **options)

    def sample(self, n: int, rng: Any = None) -> PopulationView:
        """Return a view of ``n`` cells drawn at random; of all cells if the population has fewer."""
        if n > self.size:
            self._owner()._simulator.state.remark(
                f"a sample of {n} cells of '{self.label}' has {self.size}: there are no more"
            )
        view: PopulationView = super().sample(n, rng or self._simulator.types["NumpyRNG"]())
        return view

    def _get_parameters(self, *names: str) -> ParameterSpace:
        arrays = self._owner().parameter_arrays
        self._require(names)
        values = {
            name: simplify(values_of(name, self._owner().celltype, arrays)[self._indices()]) for name in names
        }
        return ParameterSpace(values, self._owner().celltype.get_schema(), shape=(self.size,))

    def set(self, **parameters: Any) -> None:
        """Set parameters of all cells: a number, one for each, a distribution or a function of the index."""
        self._require(parameters)
        parameters = in_units(f"population '{self._owner().label}'", parameters, self._owner().celltype.units)
        require_values(f"population '{self._owner().label}'", parameters)
        space = ParameterSpace(parameters, self._owner().celltype.get_schema())
        require_shape(f"population '{self._owner().label}'", space, (self.size,))
        super().set(**parameters)

    def initialize(self, **initial_values: Any) -> None:
        """Set initial values of state variables, as :meth:`set` does parameters."""
        owner = f"population '{self._owner().label}'"
        initial_values = in_units(owner, initial_values, self._owner().celltype.units)
        require_values(owner, initial_values)
        require_shape(owner, initial_values, (self.size,))
        for variable, value in initial_values.items():
            values = LazyArray(value, shape=(self.size,), dtype=float)
            self._set_initial_value_array(variable, values)

    def inject(self, current_source: Any) -> None:
        """Inject a current into all cells."""
        owner, kind = f"population '{self._owner().label}'", standardmodels.StandardCurrentSource
        require_kind(owner, "current source", current_source, kind, "one such as sim.DCSource()")
        super().inject(current_source)

    def record(self, variables: Any, *arguments: Any, **options: Any) -> None:
        """Record variables of all cells, see PyNN.

        Raises:
            UnknownVariableError: the cells have no such variable.
        """
        names = [variables] if isinstance(variables, str) or variables is None else variables
        owner = f"population '{self._owner().label}'"
        require_kind(owner, "list of variables", names, Iterable, "names such as 'spikes' and 'v'")
        require_existing(self._owner().label, self, self._owner()._simulator.state)
        file = arguments[0] if arguments else options.get("to_file")
        if file is not None and file is not True:  # True is from PyNN's record_v(), which writes none
            _require_written(owner, file)  # or the data would be lost at the end
        try:
            super().record(variables, *arguments, **options)
        except errors.RecordingError as error:
            known = error.cell_type.recordable
            hint = did_you_mean(error.variable.name, known)
            cell = type(error.cell_type).__name__
            raise UnknownVariableError(
                f"population '{self._owner().label}': {cell} has no '{error.variable.name}' to record{hint}"
            ) from None

    def _require(self, names: Iterable[str]) -> None:
        owner = self._owner()
        whose = f"population '{owner.label}': {type(owner.celltype).__name__}"
        require_names(whose, names, owner.celltype.default_parameters)

    def _set_parameters(self, parameter_space: ParameterSpace) -> None:
        self._owner().store_parameters(parameter_space, self._indices())

    def _set_initial_value_array(self, variable: str, initial_values: LazyArray) -> None:
        self._owner().store_initial_values(variable, initial_values, self._indices())


class Population(_Cells, common.Population):
    """A group of cells of one type.

    Attributes:
        parameter_arrays: every parameter, PyNN's units, shape ``(size,)``.
        initial_arrays: every state variable at time 0, PyNN's units, shape ``(size,)``.
        has_space: whether the script set or used the positions of the cells.
        hints: how a machine is to hold the population, see :class:`~nrp_core.network.data.Population`.
    """

    hints: Mapping[str, float] = MappingProxyType({})

    def __init__(
        self, size: Any, cellclass: Any, cellparams: Mapping[str, Any] | None = None, structure: Any = None,
        initial_values: Mapping[str, Any] | None = None, label: str | None = None,
    ) -> None:  # fmt: skip
        self._simulator.state.before_change()
        self._placed = structure is not None or isinstance(size, tuple)
        self.initial_arrays: dict[str, FloatArray] = {}
        cellclass = _of_simulator(cellclass, self._simulator.types)
        if isinstance(cellclass, type) and cellparams is None:
            if hasattr(cellclass, "equations"):  # made by the script, not one of PyNN's names
                cellclass = cellclass()
            else:
                cellparams = {}
        label = label or f"population{len(self._simulator.state.populations)}"
        require_population(label, size, cellclass, structure, initial_values)
        size = tuple(map(int, size)) if isinstance(size, tuple) else int(size)
        if cellparams and not isinstance(cellclass, type):
            name = type(cellclass).__name__
            raise WrongKindError(
                f"population '{label}': give its parameters to {name}(...), not as cellparams"
            )
        cellparams = cellparams if isinstance(cellclass, type) else None
        super().__init__(size, cellclass, cellparams, structure, dict(initial_values or {}), label)
        if self.size > 1 and are_at_one_place(structure):
            self._simulator.state.remark(
                f"all cells of '{label}' are at one place, because the steps of its structure are 0 um"
            )
        self._simulator.state.populations.append(self)

    def nearest(self, position: Any) -> Any:
        """Return the cell that is closest to a position, three numbers in um."""
        if np.shape(position) != (3,):
            raise WrongKindError(
                f"population '{self.label}': nearest takes three numbers, um, not {position!r:.60}"
            )
        return super().nearest(position)

    @property
    def _recorder_class(self) -> type:
        bound: type = self._simulator.types["Recorder"]
        return bound

    @property
    def has_space(self) -> bool:
        return self._placed or self._positions is not None

    def _owner(self) -> Population:
        return self

    def _indices(self) -> slice:
        return slice(None)

    def _create_cells(self) -> None:
        values = BYTES_PER_VALUE * len(self.celltype.default_parameters)
        needed = self.size * (BYTES_PER_CELL + values)
        require_memory(
            f"population '{self.label}'", needed, f"its {self.size} cells, which PyNN keeps one by one,"
        )
        first = self._simulator.state.n_cells
        self.all_cells = np.array([ID(first + i) for i in range(self.size)], dtype=object)
        for cell in self.all_cells:
            cell.parent = self
        self._mask_local = np.ones(self.size, bool)
        parameters = self.celltype.native_parameters
        require_shape(f"population '{self.label}'", parameters, (self.size,))
        parameters.shape = (self.size,)
        self.parameter_arrays: dict[str, npt.NDArray[Any]] = {}
        self.store_parameters(parameters, slice(None))

    def store_parameters(self, space: ParameterSpace, where: IntArray | slice) -> None:
        """Evaluate parameters and store them for the cells at ``where``.

        Raises:
            NetworkError: a value is invalid.
        """
        name_streams(space, self._simulator, f"population/{self.label}")
        owner = f"population '{self.label}'"
        own = ", ".join(name for name, value in space.items() if not value.is_homogeneous) or "parameters"
        changed = {}
        with computing(f"{owner}: {own} cannot be computed"):
            # without a mask, lazy arrays of length one would become scalars
            space.evaluate(mask=np.ones(space.shape, bool), simplify=False)
            for name, values in columns_of(owner, self.celltype, space.as_dict()):
                dtype = object if name == SPIKE_TIMES else float
                changed[name] = self.parameter_arrays.get(name, np.empty(self.size, dtype)).copy()
                changed[name][where] = values
        equations = getattr(self.celltype, "equations", None)
        with raising(InvalidValueError):
            if SPIKE_TIMES not in changed:
                check_values(owner, changed, limits=limits_of_cells(equations))
            else:
                check_spike_times(owner, [_times(owner, train) for train in changed[SPIKE_TIMES]])
            if equations is not None:
                equations.require_values(owner, {**self.parameter_arrays, **changed}, {})
            elif self not in self._simulator.state.populations:
                check_cells(owner, changed)
        if self in self._simulator.state.populations:
            cells = np.arange(self.size)[where]
            new = {name: array[where] for name, array in changed.items()}
            self._simulator.state.before_parameters(self, cells, new)
        self.parameter_arrays.update(changed)

    def store_initial_values(self, variable: str, values: LazyArray, where: IntArray | slice) -> None:
        """Evaluate the initial values of a state variable and store them for the cells at ``where``.

        Raises:
            NetworkError: the cells have no such variable, or a value is not a number.
        """
        self._simulator.state.before_change()
        known = self.celltype.default_initial_values
        if variable not in known:
            cell = type(self.celltype).__name__
            hint = did_you_mean(variable, known)
            raise NetworkError(f"population '{self.label}': {cell} has no state variable '{variable}'{hint}")
        name_streams({variable: values}, self._simulator, f"population/{self.label}/initial")
        own = own_name(variable)
        kept = self.initial_arrays.get(own, np.empty(self.size)).copy()
        with computing(f"population '{self.label}': initial {variable} cannot be computed"):
            kept[where] = values.evaluate(simplify=True)
        with raising(InvalidValueError):
            check_values(
                f"population '{self.label}'", {variable: kept},
                limits=limits_of_cells(getattr(self.celltype, "equations", None)),
            )  # fmt: skip
        self.initial_arrays[own] = kept
        self.initial_values[variable] = LazyArray(simplify(kept), shape=(self.size,))

    def _get_cell_initial_value(self, id: ID, variable: str) -> float:  # noqa: A002
        return float(self.initial_arrays[own_name(variable)][self.id_to_index(id)])

    def _set_cell_initial_value(self, id: ID, variable: str, value: float) -> None:  # noqa: A002
        self._simulator.state.before_change()
        self.initial_arrays[own_name(variable)][self.id_to_index(id)] = value

    def _get_positions(self) -> FloatArray:
        structure = self._structure
        if self._positions is None and hasattr(structure, "rng"):
            name = f"population/{self.label}/positions"
            structure.rng = named(structure.rng, self._simulator, name)
        with computing(f"population '{self.label}': positions cannot be computed"):
            positions: FloatArray = super()._get_positions()
        return positions

    def _set_positions(self, positions: Any) -> None:
        given = np.asarray(positions, dtype=float)
        if given.shape != (3, self.size) or not np.isfinite(given).all():
            raise InvalidValueError(
                f"population '{self.label}': positions are finite numbers (um) of shape (3, {self.size}), "
                f"not of shape {given.shape}" + ("" if np.isfinite(given).all() else " with infinity or NaN")
            )
        super()._set_positions(given)

    positions = property(_get_positions, _set_positions)

    @property
    def places(self) -> FloatArray:
        """The positions of the cells, um, shape ``(n, 3)``."""
        return self._get_positions().T


class PopulationView(_Cells, common.PopulationView):
    """Some cells of a population."""

    def __init__(self, parent: Any, selector: Any, label: str | None = None) -> None:
        selector = list(selector) if isinstance(selector, (range, tuple)) else selector
        if not np.size(_places(parent, selector)):
            raise NetworkError(
                f"a view of '{parent.label}' by {selector} has no cells; there are 0..{parent.size - 1}"
            )
        super().__init__(parent, selector, label)

    def _owner(self) -> Population:
        owner: Population = self.grandparent
        return owner

    def _indices(self) -> IntArray:
        indices: IntArray = self.all_cells.astype(np.int64) - int(self._owner().first_id)
        return indices


class Assembly(common.Assembly):
    """Populations and views as one."""

    _simulator: Simulator

    def __init__(self, *populations: Any, label: str | None = None) -> None:
        label = label or " + ".join(str(getattr(part, "label", part)) for part in populations)
        require_kind("Assembly", "label", label, str, "a text")
        self.label = label  # PyNN sets it after it has taken the parts
        super().__init__(*populations, label=label)

    def _insert(self, element: Any) -> None:
        before = len(self.populations)
        require_kind(
            f"assembly '{self.label}'", "part", element, common.BasePopulation, "a population or a view"
        )
        super()._insert(element)
        if len(self.populations) == before:  # PyNN only logs this
            self._simulator.state.remark(
                f"'{getattr(element, 'label', element)}' is not added to the assembly '{self.label}', which "
                "has some of its cells already"
            )

    def __getitem__(self, index: Any) -> Any:
        places = _places(self, list(index) if isinstance(index, tuple) else index)
        return super().__getitem__(int(places) if np.ndim(places) == 0 else places)

    @property
    def local_size(self) -> int:
        """Number of cells; PyNN's connectors need it to report progress."""
        return int(self.size)

    @property
    def receptor_types(self) -> list[str]:
        """The receptors that all parts have, in the order of the first; PyNN's order is not deterministic."""
        shared = set.intersection(*(set(part.celltype.receptor_types) for part in self.populations))
        return [name for name in self.populations[0].celltype.receptor_types if name in shared]

    def sample(self, n: int, rng: Any = None) -> Assembly:
        """Return an assembly of ``n`` cells drawn at random."""
        sampled: Assembly = super().sample(n, rng or self._simulator.types["NumpyRNG"]())
        return sampled


def unknown_cells(cells: Any, index: Any) -> UnknownCellError:
    """Return the error for an index outside a population, view or assembly."""
    return UnknownCellError(
        f"'{cells.label}' has no cells at {reprlib.repr(index)}; they are numbered 0..{cells.size - 1}"
    )


def _places(cells: Any, selector: Any) -> Any:
    """Return the indices of the cells that a selector selects."""
    try:
        return np.arange(cells.size)[selector]
    except (IndexError, TypeError):
        raise unknown_cells(cells, selector) from None


def _of_simulator(model: Any, types: Mapping[str, Any]) -> Any:
    """Return the cell type of the simulator for PyNN's own of that name, a class or an object of it."""
    kind = model if isinstance(model, type) else type(model)
    own = types.get(kind.__name__)
    if kind.__module__ != standardmodels.cells.__name__ or own is None:
        return model
    return own if model is kind else own(**{k: each.base_value for k, each in model.parameter_space.items()})


def _require_written(owner: str, file: Any) -> None:
    require_kind(owner, "file", file, (str, BaseIO), "a name such as 'data.pkl'")
    if isinstance(file, str) and Path(file).suffix not in WRITTEN:
        hint = did_you_mean(Path(file).suffix, WRITTEN)
        raise InvalidValueError(f"{owner}: data are not written to '{file}'{hint}")


def _times(owner: str, train: Any) -> FloatArray:
    if not isinstance(train, ArrayParameter):  # PyNN does not convert lists of lists to a Sequence
        raise NetworkError(f"{owner}: {SPIKE_TIMES} given as a function must be a Sequence for each index")
    times = np.asarray(train.value, float)
    if times.ndim != 1:
        raise NetworkError(f"{owner}: {SPIKE_TIMES} is {train.value!r}; it must be a list of times, ms")
    return times


def require_existing(name: str, cells: Any, state: State) -> None:
    """Check that a population, view or assembly is part of the network.

    Raises:
        NetworkError: it was built before the last ``setup``.
    """
    if not all(part._owner() in state.populations for part in parts_of(cells)):
        raise NetworkError(f"'{name}' was built before the last setup(), which forgets everything")


def parts_of(cells: Any) -> list[Any]:
    """Return the populations and views in a population, view or assembly."""
    return list(cells.populations) if isinstance(cells, common.Assembly) else [cells]


def ids_of(cells: Any) -> IntArray:
    """Return the global ids of a population, view or assembly, in its order."""
    parts = (np.asarray(part.all_cells, dtype=np.int64) for part in parts_of(cells))
    return np.concatenate([np.empty(0, np.int64), *parts])
