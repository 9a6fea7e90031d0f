"""The connectors that only sPyNNaker has, among them kernels of weights over a grid of cells."""

from __future__ import annotations

from copy import copy
from typing import Any, Final

import numpy as np
from pyNN import connectors, space
from pyNN.core import IndexBasedExpression
from pyNN.random import RandomDistribution

from nrp_core.brain import FloatArray, IntArray
from nrp_core.errors import CapabilityError
from nrp_core.network.pynn.arguments import InvalidSynapseError, InvalidValueError, WrongKindError
from nrp_core.network.pynn.connectors import Connector
from nrp_core.network.pynn.synapse_columns import evaluated

# mypy: disable-error-code="misc"


_MOST_IN_A_ROW: Final = 255


class _KernelBase(Connector, connectors.MapConnector):
    """Base of connectors whose synapses have the weights of a kernel."""

    parameter_names = ("kernel_size",)
    kernel_size: int

    def _connect_weights(
        self, projection: Any, pre: IntArray, post: IntArray, values: dict[str, FloatArray]
    ) -> None:
        """Connect cells pairwise; values that the kernel does not have are those of the synapse type."""
        order = np.argsort(post, kind="stable")
        own = {name: each[order] for name, each in values.items()}
        ends = pre[order].astype(np.int32), post[order].astype(np.int32)
        rest = self._parameters_from_synapse_type(projection)
        more = {name: evaluated(each, *ends) for name, each in rest.items() if name not in own}
        projection.add_synapses(*ends, own | more)


class ConvolutionConnector(_KernelBase):
    """Each cell to those whose kernel it lies under; negative weights inhibit.

    Args:
        kernel_weights: a matrix, or a number, list or distribution with ``kernel_shape``.
        kernel_shape: its shape; one number is a square.
        strides: the distance of the kernels.
        padding: rows and columns of zeros around the source.
        pool_shape: source cells are averaged over areas of this shape.
        pool_stride: the distance of these areas, by default their shape.
        positive_receptor_type, negative_receptor_type: receptors of positive and negative weights.
        filter_edges: without effect, as it concerns routes alone.
        options: as in PyNN.
    """

    def __init__(
        self, kernel_weights: Any, kernel_shape: Any = None, strides: Any = None, padding: Any = None,
        pool_shape: Any = None, pool_stride: Any = None, positive_receptor_type: str = "excitatory",
        negative_receptor_type: str = "inhibitory", safe: bool = True, verbose: bool = False,
        callback: Any = None, filter_edges: bool = True, **options: Any,
    ) -> None:  # fmt: skip
        super().__init__(safe=safe, callback=callback, **options)
        self.kernel = _kernel("ConvolutionConnector", kernel_weights, kernel_shape)
        if not all(n % 2 for n in self.kernel.shape):
            raise CapabilityError(
                f"ConvolutionConnector: its kernel has the shape {self.kernel.shape}; both numbers must be "
                "odd, as sPyNNaker 7.4.1 reads beyond the end of others"
            )
        self.strides, self.padding = _pair("strides", strides, 1), _pair("padding", padding, 0, least=0)
        self.pool_stride = _pair("pool_stride", pool_shape if pool_stride is None else pool_stride, 1)
        self.kernel = self.kernel / np.prod(_pair("pool_shape", pool_shape, 1))
        self.positive_receptor_type = positive_receptor_type
        self.negative_receptor_type = negative_receptor_type
        self.kernel_size = self.kernel.size
        self._sign = 1

    def negative(self) -> ConvolutionConnector | None:
        """Return the connector of the negative weights, if there are any."""
        if self._sign < 0 or not (self.kernel < 0).any():
            return None
        other = copy(self)
        other._sign = -1
        return other

    def get_post_shape(self, shape: Any) -> tuple[int, ...]:
        """Return the shape of the target's grid for that of the source, ``(width, height)`` both."""
        pooled = np.array(shape) // self.pool_stride
        inside = pooled - (np.array(self.kernel.shape) - 1) + 2 * self.padding
        return tuple(int(n) for n in np.maximum(inside // self.strides, 1))

    def _connect(self, projection: Any) -> None:
        owner = f"projection '{projection.label}'"
        source, target = (_grid_of(owner, end) for end in (projection.pre, projection.post))
        if target != self.get_post_shape(source):
            raise InvalidSynapseError(
                f"{owner}: with these parameters a ConvolutionConnector from a grid of {source} goes to one "
                f"of {self.get_post_shape(source)}, not {target}"
            )
        # in the software's words: the kernel's first number is the width, and its values lie row by row
        width, height = self.kernel.shape
        cells = np.arange(projection.pre.size)
        columns, rows = self._first(cells % source[0], 0, width), self._first(cells // source[0], 1, height)
        pre, row, column = np.meshgrid(cells, np.arange(height), np.arange(width), indexing="ij")
        x, y = columns[pre] + column - width // 2, rows[pre] + row - height // 2
        weight = self._sign * self.kernel.ravel()[row * width + column]
        chosen = (x >= 0) & (x < target[0]) & (y >= 0) & (y < target[1]) & (weight > 0)
        post = (y * target[0] + x)[chosen]
        self._connect_weights(projection, pre[chosen], post, {"weight": weight[chosen]})

    def _first(self, place: IntArray, axis: int, size: int) -> IntArray:
        """Return the coordinate at the middle of the targets of cells with this coordinate."""
        pooled = place // self.pool_stride[axis]
        return _divided(pooled - size // 2 + self.padding[axis], int(self.strides[axis]))


class KernelConnector(_KernelBase):
    """Each cell of a grid to those whose kernel it lies under, with weights and delays of the kernel.

    Shapes, steps and starts are ``(rows, columns)``.

    Args:
        shape_pre, shape_post, shape_kernel: shapes of the two grids and of the kernel.
        weight_kernel, delay_kernel: weights and delays, or None for those of the synapse type.
        shape_common: without effect, as in sPyNNaker 7.4.1.
        pre_sample_steps_in_post, post_sample_steps_in_pre: distances of the used cells.
        pre_start_coords_in_post, post_start_coords_in_pre: the first used cells.
        options: as in PyNN.
    """

    def __init__(
        self, shape_pre: Any, shape_post: Any, shape_kernel: Any, weight_kernel: Any = None,
        delay_kernel: Any = None, shape_common: Any = None, pre_sample_steps_in_post: Any = None,
        pre_start_coords_in_post: Any = None, post_sample_steps_in_pre: Any = None,
        post_start_coords_in_pre: Any = None, safe: bool = True, space: Any = None,
        verbose: bool = False, callback: Any = None, **options: Any,
    ) -> None:  # fmt: skip
        super().__init__(safe=safe, callback=callback, **options)
        self.shape_pre, self.shape_post = _pair("shape_pre", shape_pre), _pair("shape_post", shape_post)
        self.shape = _pair("shape_kernel", shape_kernel)
        self.pre_step = _pair("pre_sample_steps_in_post", pre_sample_steps_in_post, 1)
        self.post_step = _pair("post_sample_steps_in_pre", post_sample_steps_in_pre, 1)
        self.pre_start = _pair("pre_start_coords_in_post", pre_start_coords_in_post, 0, least=0)
        self.post_start = _pair("post_start_coords_in_pre", post_start_coords_in_pre, 0, least=0)
        given = {"weight": weight_kernel, "delay": delay_kernel}
        shape = tuple(self.shape.tolist())
        self.values = {
            name: _kernel("KernelConnector", values, shape)
            for name, values in given.items()
            if values is not None
        }
        self.column_names = tuple(self.values)
        self.kernel_size = min(int(np.prod(self.shape)), _MOST_IN_A_ROW)

    def _connect(self, projection: Any) -> None:
        for end, shape in ((projection.pre, self.shape_pre), (projection.post, self.shape_post)):
            if end.size > np.prod(shape):
                raise InvalidSynapseError(
                    f"projection '{projection.label}': '{end.label}' has {end.size} cells, more than the "
                    f"grid of {tuple(shape.tolist())} of its KernelConnector"
                )
        post, row, column = np.meshgrid(
            np.arange(projection.post.size), *map(np.arange, self.shape), indexing="ij"
        )
        places = np.divmod(post, self.shape_post[1])
        chosen, source = np.ones(post.shape, bool), []
        for axis, (place, k) in enumerate(zip(places, (row, column), strict=True)):
            common = self.post_start[axis] + place * self.post_step[axis] - self.pre_start[axis]
            at = (common - 1) // self.pre_step[axis] + 1 - self.shape[axis] // 2 + k
            on_step = (at - self.pre_start[axis]) % self.pre_step[axis] == 0
            chosen &= on_step & (at >= 0) & (at < self.shape_pre[axis])
            source.append(at)
        pre = source[0] * self.shape_pre[1] + source[1]
        chosen &= pre < projection.pre.size
        values = {name: kernel[row, column][chosen] for name, kernel in self.values.items()}
        self._connect_weights(projection, pre[chosen], post[chosen], values)


def _kernel(owner: str, values: Any, shape: Any) -> FloatArray:
    """Return a kernel as a matrix.

    Raises:
        InvalidValueError: it is not one.
    """
    wanted = None if shape is None else tuple(_pair("kernel_shape", shape).tolist())
    try:
        if isinstance(values, RandomDistribution):
            values = values.next(int(np.prod(wanted or ())))
        matrix = np.array(values, float)
        if matrix.ndim != 2 and wanted is not None:
            matrix = np.full(wanted, matrix) if matrix.ndim == 0 else matrix.reshape(wanted)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    if matrix.ndim != 2 or not matrix.size or not np.isfinite(matrix).all():
        raise InvalidValueError(
            f"{owner}: its kernel is {values!r}; it must be a matrix, or have a kernel_shape"
        )
    if wanted is not None and matrix.shape != wanted:
        raise InvalidValueError(f"{owner}: its kernel has the shape {matrix.shape}, not {wanted}")
    return matrix


def _pair(name: str, given: Any, default: int = 1, *, least: int = 1) -> IntArray:
    """Return two whole numbers, given as two, as one, or omitted."""
    if given is None:
        given = default
    numbers = [given, given] if np.isscalar(given) else [*given, *([1] if len(given) == 1 else [])]
    if len(numbers) != 2 or not all(isinstance(n, (int, np.integer)) and n >= least for n in numbers):
        raise InvalidValueError(f"{name} is {given!r}; it must be one or two whole numbers from {least} on")
    return np.array(numbers, np.int64)


def _grid_of(owner: str, cells: Any) -> tuple[int, int]:
    structure = getattr(cells, "structure", None)
    if not isinstance(structure, space.Grid2D):
        raise InvalidSynapseError(
            f"{owner}: a ConvolutionConnector joins grids of cells; give '{cells.label}' a size of two "
            "numbers, or structure=sim.Grid2D(width / height)"
        )
    width, height = structure.calculate_size(cells.size)
    return int(width), int(height)


def _divided(values: IntArray, divisor: int) -> IntArray:
    """Divide as the released software does, which treats negative numbers as large ones.

    With a divisor of 1 they stay; with another one no target is at the result.
    """
    return values if divisor == 1 else np.where(values < 0, np.iinfo(np.int16).max, values // divisor)


# mypy: disable-error-code="misc"


class OneToOneOffsetConnector(Connector, connectors.MapConnector):
    """Each cell to the one whose index is larger by an offset.

    Args:
        offset: the difference of the indices.
        wrap: whether the target's cells form a ring; else cells beyond its ends are ignored.
    """

    parameter_names = ("offset", "wrap")

    def __init__(self, offset: int, wrap: bool = False, **options: Any) -> None:
        super().__init__(**options)
        if not isinstance(offset, (int, np.integer)):
            raise WrongKindError(f"OneToOneOffsetConnector: offset is {offset!r}; it must be a whole number")
        self.offset, self.wrap = int(offset), bool(wrap)

    def _connect(self, projection: Any) -> None:
        pre = np.arange(projection.pre.size)
        post = pre + self.offset
        if self.wrap:
            post %= projection.post.size
        inside = (post >= 0) & (post < projection.post.size)
        self._connect_pairs(projection, pre[inside], post[inside])


class AllButMeConnector(Connector, connectors.MapConnector):
    """Each cell to all others of its group, for groups of which one cell wins.

    Args:
        n_neurons_per_group: the number of cells of a group, by default all.
        weights: not supported.
    """

    parameter_names = ("n_neurons_per_group",)

    def __init__(
        self, n_neurons_per_group: int | None = None, weights: Any = None, safe: bool = True,
        verbose: bool = False, callback: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(safe=safe, callback=callback)
        if weights is not None:
            raise CapabilityError(
                "AllButMeConnector: weights are not supported: their order is known to the machine alone; "
                "FromListConnector takes synapses one by one"
            )
        n = n_neurons_per_group
        if n is not None and not (isinstance(n, (int, np.integer)) and n > 0):
            raise WrongKindError(
                f"AllButMeConnector: n_neurons_per_group is {n!r}; it must be a whole number from 1 on"
            )
        self.n_neurons_per_group = n

    def _connect(self, projection: Any) -> None:
        size, n = projection.pre.size, self.n_neurons_per_group or projection.pre.size
        if projection.post.size != size or size % n:
            raise InvalidSynapseError(
                f"projection '{projection.label}': AllButMeConnector joins populations of one size, a "
                f"multiple of n_neurons_per_group, not {size} and {projection.post.size} in groups of {n}"
            )
        post, other = np.divmod(np.arange(size * n), n)
        pre = post // n * n + other
        self._connect_pairs(projection, pre[pre != post], post[pre != post])


_NEARLY: Final = 1e-3
"""How near to a whole number a number of synapses must be."""


def of_fixed_number(connector: Any) -> type:
    """Return PyNN's connector with a fixed number of synapses, with the rules of sPyNNaker for the number.

    It may be a whole number as a float, and without replacement it is not above the number of partners.
    """
    name, pre, post = connector.__name__, "FixedNumberPreConnector", "FixedNumberPostConnector"

    def begin(self: Any, n: Any, *arguments: Any, **named: Any) -> None:
        is_whole = isinstance(n, (float, np.floating)) and abs(n - np.round(n)) < _NEARLY
        connector.__init__(self, int(np.round(n)) if is_whole else n, *arguments, **named)

    def connect(self: Any, projection: Any) -> None:
        ends = {pre: projection.pre, post: projection.post}
        most = ends[name].size if name in ends else np.inf
        most -= not self.allow_self_connections and projection.pre is projection.post
        if isinstance(self.n, int) and not self.with_replacement and self.n > most:
            raise InvalidSynapseError(
                f"projection '{projection.label}': {name} draws {self.n} of {most} cells without replacement"
            )
        connector._connect(self, projection)

    return type(name, (connector,), {"__init__": begin, "_connect": connect, "__doc__": connector.__doc__})


class _Formula(IndexBasedExpression):
    """The probability of a synapse as a text, with the indices ``i`` and ``j`` and NumPy's functions."""

    def __init__(self, text: str) -> None:
        self._probability = eval(f"lambda i, j: {text}", dict(vars(np)))

    def __call__(self, i: Any, j: Any) -> Any:
        return np.broadcast_to(self._probability(i, j), np.broadcast_shapes(np.shape(i), np.shape(j)))


def index_based(connector: Any) -> type:
    """Return PyNN's connector with probabilities by indices, whose expression may be a text."""

    def begin(self: Any, index_expression: Any, *arguments: Any, **named: Any) -> None:
        is_text = isinstance(index_expression, str)
        expression = _Formula(index_expression) if is_text else index_expression
        connector.__init__(self, expression, *arguments, **named)

    return type(connector.__name__, (connector,), {"__init__": begin, "__doc__": connector.__doc__})
