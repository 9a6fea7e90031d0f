"""Convolutions and pooling as sparse matrices."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import prod
from typing import Any

import numpy as np
from scipy import sparse

from nrp_core._support.arrays import FloatArray, IntArray


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
