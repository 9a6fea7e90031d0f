"""Systems of a few linear equations, with the same bits on every processor."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import jit
from nrp_core._support.small_matrices import product


@jit
def solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return ``x`` of ``matrix @ x = right``, by Gauss-Jordan elimination with partial pivoting.

    NumPy's own function calls a library that rounds in other ways on other processors. A singular matrix
    gives infinite or undefined numbers.

    Args:
        matrix: shape ``(n, n)``.
        right: shape ``(n, m)``.
    """
    n = len(matrix)
    rows = np.concatenate((matrix, right), axis=1)
    for k in range(n):
        pivot = k + np.argmax(np.abs(rows[k:, k]))
        for j in range(k, rows.shape[1]):
            rows[k, j], rows[pivot, j] = rows[pivot, j], rows[k, j]
        for i in range(n):
            factor = rows[i, k] / rows[k, k] if i != k else 0.0
            for j in range(k, rows.shape[1]):
                rows[i, j] -= factor * rows[k, j]
    for i in range(n):
        rows[i, n:] /= rows[i, i]
    return rows[:, n:].copy()


def remove_first(n: int, inertia: FloatArray, efforts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return inertia and efforts of all coordinates but the first ``n``, which accelerate freely."""
    if not n:
        return inertia, efforts
    moved = solve(inertia[:n, :n], np.column_stack((inertia[:n, n:], efforts[:n])))
    left = inertia[n:, n:] - product(inertia[n:, :n], moved[:, :-1])
    return left, efforts[n:] - product(inertia[n:, :n], moved[:, -1])
