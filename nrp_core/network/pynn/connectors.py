"""PyNN's connectors, with array versions of those that loop over synapses.

Most PyNN connectors build a projection column by column, which is fast with arrays. Those that loop over
synapses or fill a dense matrix are replaced here; they draw the same synapses from the same generator.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

import inspect
import reprlib
from collections.abc import Iterator
from copy import copy, deepcopy
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt
from pyNN import connectors
from pyNN.parameters import LazyArray

from nrp_core.errors import NetworkError, did_you_mean
from nrp_core.network.drawing import sorted_by
from nrp_core.network.indices import index_type
from nrp_core.network.memory import free_bytes, require_memory
from nrp_core.network.pynn.arguments import (
    InvalidSynapseError,
    WrongKindError,
    require_arguments,
    require_shape,
)
from nrp_core.network.pynn.populations import ids_of
from nrp_core.network.pynn.rng import name_streams, named, random_pairs
from nrp_core.network.pynn.synapse_columns import drawn_at_once

if TYPE_CHECKING:
    from nrp_core.network.pynn.simulator import Simulator

_COLUMNS: Final = 20
"""The number of sampled postsynaptic cells, where the probability differs between pairs."""
_BYTES_PER_VALUE: Final = 8
"""Memory for each parameter that differs between synapses; parts are freed as they are joined."""

_SMALL: Final = 1 << 16
"""Fewer bytes fit everywhere; asking for the free memory takes longer than connecting."""


def require_room(connector: Any, projection: Any) -> None:
    """Check that the synapses of a connector will fit into memory.

    Raises:
        NetworkError: they do not fit; the message has the counts.
    """
    n_pre, n_post = projection.pre.size, projection.post.size
    values = projection.synapse_type.parameter_space.items()
    own = sum(not value.is_homogeneous for _, value in values)
    # one index of each synapse, both in parts and joined; the other index ascends
    each = 2 * np.dtype(index_type(n_pre)).itemsize + own * _BYTES_PER_VALUE
    most = inf if _repeats(connector) else n_pre * n_post * each
    if most <= _SMALL or (free := free_bytes()) is None or most <= free:
        return
    expected = expected_synapses(connector, projection)
    name = type(connector).__name__
    what = f"{name} from {n_pre} to {n_post} cells makes about {expected:.3g} synapses, which"
    require_memory(f"projection '{projection.label}'", expected * each, what)


def expected_synapses(connector: Any, projection: Any) -> float:
    """Return the mean number of synapses that a connector makes, or 0 if it is unknown."""
    n_pre, n_post = projection.pre.size, projection.post.size
    given = getattr(connector, "n", None)
    n: float = given if isinstance(given, (int, float)) else 0.0
    match connector:
        case connectors.AllToAllConnector():
            return float(n_pre * n_post)
        case connectors.OneToOneConnector():
            return float(min(n_pre, n_post))
        case connectors.FixedProbabilityConnector():
            return float(connector.p_connect * n_pre * n_post)
        case connectors.FixedNumberPreConnector():
            return float(n * n_post)
        case connectors.FixedNumberPostConnector():
            return float(n * n_pre)
        case connectors.FixedTotalNumberConnector():
            return float(n)
        case connectors.DistanceDependentProbabilityConnector() | connectors.IndexBasedProbabilityConnector():
            return _by_columns(_probabilities(connector, projection), n_pre, n_post)
        case connectors.SmallWorldConnector():
            near = connector._generate_distance_map(projection) < connector.degree
            kept = np.inf if connector.n_connections is None else connector.n_connections * n_pre
            return min(_by_columns(near, n_pre, n_post), kept)
    return 0.0


def _probabilities(connector: Any, projection: Any) -> LazyArray:
    """Return the probability of each pair of cells."""
    if isinstance(connector, connectors.DistanceDependentProbabilityConnector):
        return connector.distance_function(connector._generate_distance_map(projection))
    expression = copy(connector.index_expression)
    expression.projection = projection
    return LazyArray(expression, projection.shape)


def _by_columns(probabilities: LazyArray, n_pre: int, n_post: int) -> float:
    """Return an estimate of the sum of a matrix of probabilities from some of its columns.

    Samples whole columns, since randomly sampled pairs would rarely include nearby cells.
    """
    sums = [np.clip(column, 0.0, 1.0).sum() for column in _columns(probabilities, n_pre, n_post)]
    return float(np.mean(sums)) * n_post if sums else 0.0


def _columns(probabilities: LazyArray, n_pre: int, n_post: int) -> Iterator[Any]:
    everyone, n = np.arange(n_pre), min(n_post, _COLUMNS)
    for j in ((np.arange(n) + 0.5) * n_post / max(n, 1)).astype(int):
        yield probabilities[everyone, int(j)]


def _repeats(connector: Any) -> bool:
    """Whether a connector may make several synapses between two cells."""
    return isinstance(connector, (connectors.FixedNumberConnector, connectors.FixedTotalNumberConnector))


Indices = npt.NDArray[np.integer[Any]]

_IMPOSSIBLE = (
    AssertionError, ArithmeticError, NameError, OSError, SyntaxError, TypeError, ValueError,
)  # fmt: skip
"""Exceptions that the constructor of a connector may raise."""
_ALONE = "a cell that may not connect to itself has no other to connect to"
_RULES = "probabilities and numbers of synapses are 0 or more, flags are True or False"
_RULES_OF = {
    "IndexBasedProbabilityConnector": "its expression is an object of a subclass of "
    "pyNN.core.IndexBasedExpression, whose __call__(self, i, j) returns the probabilities"
}


class Connector(connectors.Connector):
    """Adds named random streams, and masks that are not dense matrices, to every connector."""

    _simulator: Simulator

    def __init__(self, *args: Any, **options: Any) -> None:
        name = type(self).__name__
        require_arguments(name, super().__init__, options)
        try:
            super().__init__(*args, **options)
        except _IMPOSSIBLE as error:  # PyNN gives no more details
            shown = ", ".join([*map(repr, args), *(f"{key}={value!r}" for key, value in options.items())])
            distance = "; the distance is d" if isinstance(error, NameError) else ""
            rules = str(error) or _RULES_OF.get(name, _RULES)
            raise WrongKindError(f"{name}({shown}): an argument is impossible; {rules}{distance}") from None
        given = inspect.signature(super().__init__).bind(*args, **options).arguments
        if hasattr(self, "rng") and given.get("rng") is None:
            self.rng = self._simulator.types["NumpyRNG"]()

    def connect(self, projection: Any) -> None:
        """Add this connector's synapses to a projection.

        Raises:
            NetworkError: the synapses would not fit into memory.
        """
        require_room(self, projection)
        owner = f"projection/{projection.label}"
        if hasattr(self, "rng"):
            self.rng = named(self.rng, self._simulator, f"{owner}/connector")
        name_streams({"n": getattr(self, "n", None)}, self._simulator, owner)
        self._connect(projection)

    def _connect(self, projection: Any) -> None:
        super().connect(projection)

    def _connect_pairs(self, projection: Any, pre: Indices, post: Indices) -> None:
        """Connect cells pairwise; synapses of one target keep the given order."""
        pre, counts = sorted_by(post, pre, projection.post.size)
        space = self._parameters_from_synapse_type(projection)
        if (values := drawn_at_once(space, counts)) is not None and self.location_selector is None:
            projection.add_all(pre, counts, values)
            return
        bounds = np.append(0, np.cumsum(counts))

        def sources(_: Any = None) -> Iterator[Indices]:
            return (pre[start:stop] for start, stop in pairwise(bounds))

        self._standard_connect(projection, sources)

    def _standard_connect(self, projection: Any, columns: Any, distance_map: Any = None) -> None:
        def arrays(*mask: Any) -> Iterator[Any]:
            # PyNN uses True for all cells, and fails on a scalar for the column of a single cell
            return (column if column is True else np.atleast_1d(column) for column in columns(*mask))

        super()._standard_connect(projection, arrays, distance_map)

    def _parameters_from_synapse_type(self, projection: Any, distance_map: Any = None) -> Any:
        owner = f"projection '{projection.label}'"
        require_shape(owner, projection.synapse_type.parameter_space, projection.shape)
        space = super()._parameters_from_synapse_type(projection, distance_map)
        name_streams(space, self._simulator, f"projection/{projection.label}")
        return space

    def _get_connection_map_no_self_connections(self, projection: Any) -> LazyArray:
        pre, post = ids_of(projection.pre), ids_of(projection.post)
        return LazyArray(lambda i, j: pre[i] != post[j], shape=projection.shape)


class FixedProbabilityConnector(Connector, connectors.FixedProbabilityConnector):
    """Each pair of cells connects with the same probability."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        given = options.get("p_connect", args[0] if args else self.p_connect)
        if isinstance(given, bool) or self.p_connect > 1:
            raise NetworkError(
                f"FixedProbabilityConnector: p_connect is {given!r}; it must be a number between 0 and 1"
            )


class _FixedNumberConnector(Connector):
    """Draws the partners of each cell in turn."""

    def _partners(self, n: int, size: int, itself: int) -> Indices:
        """Return ``n`` of ``size`` cells, without the cell ``itself`` (-1: no exclusion)."""
        if self.with_replacement:
            drawn = self.rng.next(n, "uniform_int", {"low": 0, "high": size}, mask=None)
            _avoid(self.rng, drawn, itself, size)
            return np.asarray(drawn, dtype=np.int32)
        cells = np.arange(size, dtype=np.int32)
        cells = cells[cells != itself]
        if n and not cells.size:
            raise NetworkError(_ALONE)
        full_sets, rest = divmod(n, max(cells.size, 1))
        drawn = self.rng.permutation(cells)[:rest] if rest else cells[:0]
        return np.concatenate([*[cells] * full_sets, drawn])

    def _forbidden(self, cells: Any, among: Any) -> Indices:
        """Return, for each cell of one group, the cell of another that it may not connect to, or -1."""
        return np.full(cells.size, -1) if self.allow_self_connections else _places(cells, among)


class FixedNumberPreConnector(_FixedNumberConnector, connectors.FixedNumberPreConnector):
    """``n`` cells drawn at random connect to each postsynaptic cell."""

    def _connect(self, projection: Any) -> None:
        pre, post = projection.pre, projection.post

        def sources(_: Any = None) -> Iterator[Indices]:
            for n, itself in zip(self._get_num_pre(post.size), self._forbidden(post, pre), strict=True):
                yield self._partners(int(n), pre.size, itself)

        self._standard_connect(projection, sources)


class FixedNumberPostConnector(_FixedNumberConnector, connectors.FixedNumberPostConnector):
    """Each presynaptic cell connects to ``n`` cells drawn at random."""

    def _connect(self, projection: Any) -> None:
        pre, post = projection.pre, projection.post
        targets = [
            self._partners(int(self._get_num_post()), post.size, itself)
            for itself in self._forbidden(pre, post)
        ]
        sources = np.repeat(np.arange(pre.size, dtype=np.int32), [len(part) for part in targets])
        self._connect_pairs(projection, sources, np.concatenate(targets))


class FixedTotalNumberConnector(Connector, connectors.FixedTotalNumberConnector):
    """``n`` synapses between pairs of cells drawn at random."""

    def _connect(self, projection: Any) -> None:
        total = self.n if isinstance(self.n, int) else int(self.n.next())
        # PyNN draws the number for each of its processes; here there is one
        n = int(self.rng.next(1, "binomial", {"n": total, "p": 1.0})[0])
        if not self.with_replacement:
            self._connect_pairs(projection, *self._different_pairs(projection, n))
            return
        pre, post = random_pairs(self.rng, projection.pre.size, projection.post.size, n)
        if not self.allow_self_connections:
            _avoid(self.rng, post, _places(projection.pre, projection.post)[pre], projection.post.size)
        self._connect_pairs(projection, pre, post)

    def _different_pairs(self, projection: Any, n: int) -> tuple[Indices, Indices]:
        """Return the indices of ``n`` different pairs.

        Raises:
            InvalidSynapseError: fewer exist.
        """
        n_pre, n_post = projection.shape
        forbidden = np.full(n_pre, -1)
        if not self.allow_self_connections:
            forbidden = _places(projection.pre, projection.post)
        total = n_pre * n_post
        if n > (possible := total - np.count_nonzero(forbidden >= 0)):
            raise InvalidSynapseError(
                f"projection '{projection.label}': there are {possible} pairs of cells, and n is {n}, "
                "without replacement"
            )
        if 2 * n > total:
            found = np.asarray(self.rng.permutation(_allowed(np.arange(total), forbidden, n_post)))[:n]
        else:  # no array of all pairs, which may be many
            found = np.empty(0, np.int64)
            while len(found) < n:
                drawn = self.rng.next(n - len(found), "uniform_int", {"low": 0, "high": total}, mask=None)
                found = np.append(found, _allowed(np.asarray(drawn), forbidden, n_post))
                found = found[np.sort(np.unique(found, return_index=True)[1])]
        return found // n_post, found % n_post


class CloneConnector(Connector, connectors.CloneConnector):
    """The pairs of cells that another projection connects."""

    def _connect(self, projection: Any) -> None:
        original = self.reference_projection
        if projection.pre != original.pre or projection.post != original.post:
            raise InvalidSynapseError(
                f"projection '{projection.label}' cannot clone '{original.label}': it does not connect "
                "the same populations"
            )
        cells = np.int64(projection.pre.size)
        pairs = np.unique(original.post_index * cells + original.pre_index)
        self._connect_pairs(projection, pairs % cells, pairs // cells)


class SmallWorldConnector(Connector, connectors.SmallWorldConnector, connectors.MapConnector):
    """Synapses to all cells nearer than ``degree``, each rewired at random with probability ``rewiring``.

    Args:
        degree: distance within which cells connect.
        rewiring: probability with which a synapse gets another target, drawn from all cells.
        allow_self_connections: whether a cell may connect to itself.
        n_connections: the number of synapses that each presynaptic cell keeps, by default all.
        options: as in PyNN.
    """

    def __init__(
        self, degree: float, rewiring: float, allow_self_connections: bool = True,
        n_connections: int | None = None, **options: Any,
    ) -> None:  # fmt: skip
        super().__init__(degree, rewiring, allow_self_connections, n_connections, **options)
        self.degree = degree

    def _connect(self, projection: Any) -> None:
        distances = self._generate_distance_map(projection)
        columns = [np.flatnonzero(column < self.degree) for column in distances.by_column()]
        pre = np.concatenate(columns)
        post = np.repeat(np.arange(len(columns)), [len(column) for column in columns])
        rewired = np.flatnonzero(self.rng.next(len(pre)) < self.rewiring)
        everywhere = {"low": 0, "high": projection.post.size}
        post[rewired] = self.rng.next(len(rewired), "uniform_int", everywhere)
        if not self.allow_self_connections:
            _avoid(self.rng, post, _places(projection.pre, projection.post)[pre], projection.post.size)
        if self.n_connections is not None:
            kept = _some_of_each(self.rng, pre, self.n_connections)
            pre, post = pre[kept], post[kept]
        self._connect_pairs(projection, pre, post)


class TableConnector(Connector):
    """Base of connectors whose synapses are listed one by one."""

    def _connect_table(self, projection: Any) -> None:
        """Connect by the table ``conn_list``: pre, post, and ``column_names``."""
        table, names = self.conn_list, self.column_names
        if table.size == 0:
            return
        self._check_table(projection)
        inside = (table[:, 1] >= 0) & (table[:, 1] < projection.post.size)
        if not inside.all():
            self._simulator.state.remark(
                f"projection '{projection.label}': {np.count_nonzero(~inside)} rows of its list of synapses "
                f"are left out, as in PyNN: '{projection.post.label}' has no cell {table[~inside, 1][0]:g}, "
                f"only 0..{projection.post.size - 1}"
            )
            table = table[inside]
        order = np.argsort(table[:, 1], kind="stable")
        pre, post = table[order, :2].T.astype(np.int32)
        given = dict(zip(names, table[order, 2:].T, strict=True))
        values = self._parameters_from_synapse_type(projection)
        rest = {name: value for name, value in values.items() if name not in given}
        if all(value.is_homogeneous for value in rest.values()):
            same = {name: value.evaluate(simplify=True) for name, value in rest.items()}
            projection.add_synapses(pre, post, given | same, self.location_selector)
            return
        starts = np.flatnonzero(np.diff(post, prepend=-1))
        for start, stop in pairwise([*starts, len(post)]):
            some, target = slice(start, stop), int(post[start])
            columns = {name: column[some] for name, column in given.items()}
            # as in PyNN, every target uses the random numbers of the first
            columns |= {name: deepcopy(value)[pre[some], target] for name, value in rest.items()}
            projection.add_synapses(pre[some], target, columns, self.location_selector)

    def _check_table(self, projection: Any) -> None:
        owner = f"projection '{projection.label}'"
        table, names = self.conn_list, self.column_names
        if table.shape[1] != 2 + len(names):
            raise InvalidSynapseError(
                f"{owner}: rows of the list of synapses have {table.shape[1]} numbers, not 2 indices and "
                f"{len(names)} parameters ({', '.join(names)})"
            )
        known = projection.synapse_type.get_parameter_names()
        for name in set(names) - set(known):
            raise InvalidSynapseError(f"{owner}: its synapses have no '{name}'{did_you_mean(name, known)}")
        for end, column in zip(("pre", "post"), table[:, :2].T, strict=True):
            cells = getattr(projection, end)
            wrong = column != np.floor(column)
            if end == "pre":
                wrong |= (column < 0) | (column >= cells.size)
            if wrong.any():
                raise InvalidSynapseError(
                    f"{owner}: {end}synaptic index {column[np.argmax(wrong)]:g} in its list of synapses; "
                    f"'{cells.label}' has cells 0..{cells.size - 1}"
                )


class FromListConnector(TableConnector, connectors.FromListConnector):
    """Synapses from a list of tuples: pre, post, and parameters."""

    def __init__(self, conn_list: Any, column_names: Any = None, **options: Any) -> None:
        table = _table(conn_list)
        width = table.shape[1] if table.ndim == 2 else 0
        if column_names is None and width not in (0, 2, 4):
            raise NetworkError(
                f"FromListConnector: a row has 2 indices and parameters; for rows of {width} numbers "
                "column_names must name the parameters"
            )
        super().__init__(table, column_names, **options)

    def _connect(self, projection: Any) -> None:
        self._connect_table(projection)


class ArrayConnector(Connector, connectors.ArrayConnector):
    """The pairs of cells that a matrix selects; its numbers are truth values, 0 or 1."""

    array: Any

    def _connect(self, projection: Any) -> None:
        owner = f"projection '{projection.label}'"
        values = np.asarray(self.array)
        require_shape(owner, {"array": values}, projection.shape)
        others = values[(values != 0) & (values != 1)] if values.dtype != bool else ()
        if len(others):
            raise NetworkError(
                f"{owner}: the array of an ArrayConnector tells which cells are connected; {others[0]:g} is "
                "neither true nor false; weights belong to the synapse: StaticSynapse(weight=array)"
            )
        self.array = values.astype(bool)  # PyNN reads a column of numbers as indices of cells
        super()._connect(projection)


class FromFileConnector(TableConnector, connectors.FromFileConnector):
    """Synapses from a text file; a header ``# columns = [...]`` names its parameters."""

    def _connect(self, projection: Any) -> None:
        if self.distributed:
            self.file.rename(f"{self.file.name}.{self._simulator.state.mpi_rank}")
        columns = self.file.get_metadata().get("columns", ("weight", "delay"))
        self.column_names = tuple(name for name in columns if name not in ("i", "j"))
        self.conn_list = np.atleast_2d(self.file.read())
        self._connect_table(projection)


class CSAConnector(TableConnector, connectors.CSAConnector):
    """Synapses from a connection set; needs the package ``csa``."""

    def _connect(self, projection: Any) -> None:
        csa = connectors.csa
        everywhere = csa.cross((0, projection.pre.size - 1), (0, projection.post.size - 1))
        self.conn_list = np.array(list(everywhere * self.cset), dtype=float)
        if csa.arity(self.cset) == 2:
            self.column_names = ("weight", "delay")
            self._connect_table(projection)
        else:
            pre, post = self.conn_list.reshape(-1, 2).T.astype(np.int32)
            self._connect_pairs(projection, pre, post)


REPLACED = (
    FixedProbabilityConnector, FixedNumberPreConnector, FixedNumberPostConnector, FixedTotalNumberConnector,
    CloneConnector, SmallWorldConnector, ArrayConnector, FromListConnector, FromFileConnector, CSAConnector,
)  # fmt: skip


def connector_types() -> list[type]:
    """Return every connector class of the installed PyNN, not yet bound to a simulator."""
    replaced = {connector.__name__ for connector in REPLACED}
    own = [
        type(name, (Connector, base), {"__doc__": base.__doc__})
        for name, base in vars(connectors).items()
        if inspect.isclass(base) and issubclass(base, connectors.Connector) and name not in replaced
    ]
    return [*own, *REPLACED]


def _table(rows: Any) -> npt.NDArray[np.float64]:
    """Return a list of synapses as a matrix.

    Raises:
        NetworkError: a row has another length than the first, or holds a value that is not a number.
    """
    try:
        table = np.array(rows, dtype=float)
    except (TypeError, ValueError):
        wrong = next(k for k, row in enumerate(rows) if len(row) != len(rows[0]) or not _are_numbers(row))
        raise NetworkError(
            f"FromListConnector: row {wrong} of the list of synapses is {rows[wrong]!r}; all rows have "
            f"equally many numbers, the first has {len(rows[0])}"
        ) from None
    if table.size and table.ndim != 2:
        raise WrongKindError(
            f"FromListConnector: its list of synapses is {reprlib.repr(rows)}; each is (pre, post, ...)"
        )
    return table


def _are_numbers(row: Any) -> bool:
    return all(isinstance(number, (int, float, np.number)) for number in row)


def _places(cells: Any, among: Any) -> Indices:
    """Return the index in one group of each cell of another, or -1."""
    places = np.full(cells._simulator.state.n_cells, -1)
    places[ids_of(among)] = np.arange(among.size)
    return places[ids_of(cells)]


def _allowed(pairs: Indices, forbidden: Indices, n_post: int) -> Indices:
    """Return the pairs, source times ``n_post`` plus target, whose target is not forbidden to its source."""
    kept: Indices = pairs[pairs % n_post != forbidden[pairs // n_post]]
    return kept


def _avoid(rng: Any, drawn: Indices, forbidden: Any, high: int) -> None:
    """Redraw numbers below ``high``, in place, where they equal the forbidden one (-1: none).

    Raises:
        NetworkError: no other number exists.
    """
    if high == 1 and (drawn == forbidden).any():
        raise NetworkError(_ALONE)
    while len(wrong := np.flatnonzero(drawn == forbidden)):
        drawn[wrong] = rng.next(len(wrong), "uniform_int", {"low": 0, "high": high}, mask=None)


def _some_of_each(rng: Any, owners: Indices, n: int) -> Indices:
    """Return, in random order, indices that hold at most ``n`` of each value in ``owners``."""
    shuffled = np.asarray(rng.permutation(np.arange(len(owners))))
    grouped = shuffled[np.argsort(owners[shuffled], kind="stable")]
    starts = np.searchsorted(owners[grouped], owners[grouped])
    chosen: Indices = grouped[np.arange(len(grouped)) - starts < n]
    return chosen
