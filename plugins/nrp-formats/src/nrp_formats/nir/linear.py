"""The linear nodes between neurons, combined into one matrix from each population to each other one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod
from typing import Any, Final

import numpy as np
from scipy import sparse

from nrp_core.brain import FloatArray, IntArray
from nrp_formats.nir.graph import Graph


def convolution(
    weight: FloatArray, shape: Sequence[int], stride: Any, padding: Any, dilation: Any, groups: int = 1
) -> tuple[Any, tuple[int, ...]]:
    """Return the matrix of a convolution in one or two dimensions, and the shape of its result.

    Args:
        weight: shape ``(n_out, n_in / groups, *kernel)``.
        shape: channels and extent of the input.
        stride: one number, or one for each dimension, as the next two.
        padding: or a pair for each dimension, before and after, or ``same`` or ``valid``.
        dilation: distance of the kernel's elements.
        groups: number of groups of channels.

    Raises:
        ValueError: the shapes do not fit.
    """
    kernel, extent = weight.shape[2:], tuple(int(n) for n in shape[1:])
    n_out, n_each = weight.shape[:2]
    if len(extent) != len(kernel) or shape[0] != n_each * groups:
        raise ValueError(f"its kernel of shape {weight.shape} does not fit an input of shape {tuple(shape)}")
    stride, dilation = _each(stride, kernel), _each(dilation, kernel)
    before, after = _padding(padding, kernel, dilation, stride)
    result = tuple(
        (n + a + b - d * (k - 1) - 1) // s + 1
        for n, a, b, d, k, s in zip(extent, before, after, dilation, kernel, stride, strict=True)
    )
    if min(result) < 1:
        raise ValueError(f"an input of {extent} is smaller than its kernel")
    where = np.indices(result).reshape(len(result), -1)
    outputs = np.arange(n_out)
    inputs = (outputs // (n_out // groups) * n_each)[:, None] + np.arange(n_each)
    parts = []
    for offset in product(*map(range, kernel)):
        reached = where * _column(stride) + _column(np.multiply(offset, dilation)) - _column(before)
        inside = np.flatnonzero(((reached >= 0) & (reached < _column(extent))).all(axis=0))
        column = np.ravel_multi_index(tuple(reached[:, inside]), extent)
        rows = outputs[:, None, None] * prod(result) + inside
        columns = inputs[:, :, None] * prod(extent) + column
        values = weight.reshape(n_out, n_each, -1)[:, :, int(np.ravel_multi_index(offset, kernel)), None]
        full = np.broadcast_shapes(rows.shape, columns.shape)
        parts.append([np.broadcast_to(part, full).ravel() for part in (values, rows, columns)])
    values, rows, columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    size = n_out * prod(result), prod(int(n) for n in shape)
    return sparse.csr_matrix((values, (rows, columns)), size), (n_out, *result)


def pooling(node: Any, shape: Sequence[int], share: bool) -> tuple[Any, tuple[int, ...]]:
    """Return the matrix of sums over windows of each channel, or of means, and the result's shape."""
    kernel = tuple(int(n) for n in np.broadcast_to(node.kernel_size, 2))
    each = np.full((int(shape[0]), 1, *kernel), 1.0 / prod(kernel) if share else 1.0)
    return convolution(each, shape, node.stride, node.padding, 1, int(shape[0]))


def _each(value: Any, kernel: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(int(n) for n in np.broadcast_to(value, len(kernel)))


def _column(values: Any) -> IntArray:
    return np.reshape(values, (-1, 1))


def _padding(
    padding: Any, kernel: tuple[int, ...], dilation: tuple[int, ...], stride: tuple[int, ...]
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the padding before and after each dimension."""
    text = padding.decode() if isinstance(padding, bytes) else padding
    if not isinstance(text, str):
        given = np.asarray(padding)
        if given.shape == (len(kernel), 2):
            return _each(given[:, 0], kernel), _each(given[:, 1], kernel)
        same = _each(padding, kernel)
        return same, same
    if text == "valid":
        return _each(0, kernel), _each(0, kernel)
    if text != "same" or set(stride) != {1}:
        raise ValueError(f"its padding is '{text}' with stride {stride}; 'same' needs stride 1")
    total = [d * (k - 1) for d, k in zip(dilation, kernel, strict=True)]
    return tuple(n // 2 for n in total), tuple(n - n // 2 for n in total)


NEURONS: Final = frozenset({"LIF", "CubaLIF", "IF", "LI", "CubaLI", "I", "Threshold"})
Shape = tuple[int, ...]


@dataclass(frozen=True)
class Signal:
    """The values at a place of the graph as a linear function of spikes.

    Args:
        shape: shape of the values.
        parts: by name of the emitting node and delay (s), a matrix from its cells to the values.
        bias: the constant part, flat.
    """

    shape: Shape
    parts: dict[tuple[str, float], Any] = field(default_factory=dict)
    bias: FloatArray | float = 0.0

    def through(self, matrix: Any, shape: Shape, bias: FloatArray | float = 0.0) -> Signal:
        """Return the signal after a linear map."""
        own = np.broadcast_to(self.bias, prod(self.shape))
        return Signal(shape, {key: matrix @ part for key, part in self.parts.items()}, matrix @ own + bias)

    def delayed(self, delays_s: FloatArray) -> Signal:
        """Return the signal after a delay of each value."""
        parts: dict[tuple[str, float], Any] = {}
        for (name, delay), part in self.parts.items():
            for more in np.unique(delays_s):
                chosen = sparse.diags_array((delays_s == more).astype(float)).tocsr()
                parts[name, delay + float(more)] = chosen @ part
        return Signal(self.shape, parts, self.bias)

    def plus(self, other: Signal) -> Signal:
        """Return the sum of two signals."""
        parts = dict(self.parts)
        for key, part in other.parts.items():
            parts[key] = parts[key] + part if key in parts else part
        return Signal(self.shape, parts, self.bias + np.asarray(other.bias))


class Signals:
    """The signals at the inputs of nodes.

    Args:
        graph: the graph.
        sizes: shapes of the nodes that emit spikes.
    """

    def __init__(self, graph: Graph, sizes: dict[str, Shape]) -> None:
        self._graph, self._sizes = graph, sizes
        self._known: dict[str, Signal] = {}

    def into(self, name: str) -> Signal:
        """Return the sum of the signals that reach a node.

        Raises:
            NetworkError: nothing reaches it, or shapes do not fit.
        """
        arriving = [self._out_of(start, (name,)) for start in self._graph.before[name]]
        return self._sum(name, arriving)

    def _sum(self, name: str, arriving: list[Signal]) -> Signal:
        if not arriving:
            kinds = {type(node).__name__ for node in self._graph.nodes.values()}
            why = "" if "Input" in kinds else ", and the file has no node Input, where spikes would come in"
            raise self._graph.error(name, f"no edge leads to it{why}")
        whole = arriving[0]
        for other in arriving[1:]:
            if prod(other.shape) != prod(whole.shape):
                raise self._graph.error(name, f"its inputs have shapes {whole.shape} and {other.shape}")
            whole = whole.plus(other)
        return whole

    def _out_of(self, name: str, after: tuple[str, ...]) -> Signal:
        if name in self._sizes:
            shape = self._sizes[name]
            return Signal(shape, {(name, 0.0): sparse.eye_array(prod(shape)).tocsr()})
        if name in after:
            raise self._graph.error(name, "it is part of a loop without neurons")
        if name not in self._known:
            starts = self._graph.before[name]
            signal = self._sum(name, [self._out_of(start, (*after, name)) for start in starts])
            try:
                self._known[name] = _transformed(self._graph.nodes[name], signal)
            except (ValueError, KeyError) as error:
                raise self._graph.error(name, str(error)) from error
        return self._known[name]


def _transformed(node: Any, signal: Signal) -> Signal:
    """Return the signal after a node without state.

    Raises:
        ValueError: the shapes do not fit, or the node does not exist.
    """
    kind = type(node).__name__
    if kind not in _MAPS:
        raise ValueError("such a node is not supported")
    return _MAPS[kind](node, signal)


def _dense(node: Any, signal: Signal) -> Signal:
    weight = np.asarray(node.weight, dtype=float)
    *apart, n_out, n_in = weight.shape if weight.ndim > 1 else (0, 0)
    if prod(apart) * n_in != prod(signal.shape):
        raise ValueError(f"its weights of shape {weight.shape} do not fit an input of shape {signal.shape}")
    shape = (*apart, n_out)
    bias = np.broadcast_to(np.asarray(getattr(node, "bias", 0.0), dtype=float), shape).ravel()
    matrix = sparse.block_diag(
        [sparse.csr_array(one) for one in weight.reshape(-1, n_out, n_in)], format="csr"
    )
    return signal.through(matrix, shape, bias)


def _scaled(node: Any, signal: Signal) -> Signal:
    scale = np.broadcast_to(np.asarray(node.scale, dtype=float), signal.shape).ravel()
    return signal.through(sparse.diags_array(scale).tocsr(), signal.shape)


def _convolved(node: Any, signal: Signal) -> Signal:
    weight = np.asarray(node.weight, dtype=float)
    matrix, shape = convolution(
        weight, signal.shape, node.stride, node.padding, node.dilation, int(node.groups)
    )
    bias = np.repeat(np.broadcast_to(np.asarray(node.bias, dtype=float), shape[0]), prod(shape[1:]))
    return signal.through(matrix, shape, bias)


def _pooled(node: Any, signal: Signal) -> Signal:
    matrix, shape = pooling(node, signal.shape, type(node).__name__ == "AvgPool2d")
    return signal.through(matrix, shape)


def _flattened(node: Any, signal: Signal) -> Signal:
    first = min(max(int(node.start_dim), 0), len(signal.shape) - 1)
    last = int(node.end_dim) % len(signal.shape)
    shape = (*signal.shape[:first], prod(signal.shape[first : last + 1]), *signal.shape[last + 1 :])
    return Signal(shape, signal.parts, signal.bias)


def _delayed(node: Any, signal: Signal) -> Signal:
    delays = np.broadcast_to(np.asarray(node.delay, dtype=float), signal.shape).ravel()
    if not (delays >= 0).all():
        raise ValueError(f"a delay is {delays.min():g} s; it must be 0 or more")
    return signal.delayed(delays)


def _same(_node: Any, signal: Signal) -> Signal:
    return signal


_MAPS: Final[dict[str, Callable[[Any, Signal], Signal]]] = {
    "Affine": _dense, "Linear": _dense, "Scale": _scaled, "Conv1d": _convolved, "Conv2d": _convolved,
    "SumPool2d": _pooled, "AvgPool2d": _pooled, "Flatten": _flattened, "Delay": _delayed,
    "Input": _same, "Output": _same, "Identity": _same,
}  # fmt: skip


def emitting(graph: Graph, names: set[str]) -> dict[str, Shape]:
    """Return the shapes of the nodes that emit spikes; parameters of one value hold for each cell of a node.

    Raises:
        NetworkError: a shape cannot be known.
    """
    found: dict[str, Shape] = {}
    for name in names:
        shape = _shape(graph, name, ())
        if shape is None:
            raise graph.error(name, "its size is known neither from its parameters nor from what leads to it")
        found[name] = shape
    return found


def _shape(graph: Graph, name: str, after: tuple[str, ...]) -> Shape | None:
    """Return the shape of a node's output, or None where a loop leads back to it."""
    node = graph.nodes[name]
    kind = type(node).__name__
    own = None
    if kind == "Input":
        own = tuple(int(n) for n in np.ravel(node.input_type["input"]))
    elif kind in {"Affine", "Linear"}:
        own = np.shape(node.weight)[:-1]
    elif kind in NEURONS:
        own = np.broadcast_shapes(*(np.shape(value) for value in parameters_of(node).values()))
    if own is not None and (kind not in NEURONS or (prod(own) > 1 and 1 not in own)):
        return own
    for start in graph.before[name] if name not in after else ():
        shape = _shape(graph, start, (*after, name))
        if shape is not None:
            try:
                return _spread(own, shape) if own is not None else _transformed(node, Signal(shape)).shape
            except (ValueError, KeyError) as error:
                raise graph.error(name, str(error)) from error
    return own or None


def _spread(own: Shape, arriving: Shape) -> Shape:
    """Return the shape of cells whose parameters may hold for all cells, or for all of a channel."""
    if prod(own) in {1, prod(arriving)}:
        return arriving if prod(own) == 1 else own
    try:
        return np.broadcast_shapes(own, arriving)
    except ValueError:
        raise ValueError(f"parameters of shape {own} do not fit an input of shape {arriving}") from None


def parameters_of(node: Any) -> dict[str, FloatArray]:
    """Return the parameters of a node of neurons, as arrays."""
    names = [name for name in vars(node) if name not in {"input_type", "output_type", "metadata"}]
    return {name: np.asarray(getattr(node, name), dtype=float) for name in names}
