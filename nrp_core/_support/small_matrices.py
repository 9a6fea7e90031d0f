"""Products, lengths and principal axes with the same bits on every processor.

NumPy's ``@``, ``dot`` and ``linalg`` call a BLAS library that has other code, with other rounding, for each
generation of processors. What moves a body does not use them. ``einsum`` has one loop for all.
"""

from __future__ import annotations

from math import hypot
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray

_SUBSCRIPTS = {(1, 1): "i,i->", (1, 2): "i,ij->j", (2, 1): "ij,j->i", (2, 2): "ij,jk->ik"}
_SWEEPS = 50  # four to six are enough for any matrix that is not a mistake


def product(a: npt.ArrayLike, b: npt.ArrayLike) -> Any:
    """Return ``a @ b`` of vectors, matrices and stacks of matrices."""
    a, b = np.asarray(a), np.asarray(b)
    stacked = "...ij,j->...i" if b.ndim == 1 else "...ij,...jk->...ik"
    return np.einsum(_SUBSCRIPTS.get((a.ndim, b.ndim), stacked), a, b)


def length(vector: npt.ArrayLike) -> float:
    """Return the Euclidean norm of a vector of a few numbers."""
    return hypot(*np.asarray(vector).tolist())


def principal_axes(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the eigenvalues, ascending, and the eigenvectors of a symmetric matrix, as columns.

    By Jacobi's rotations (Golub and Van Loan, Matrix Computations, 4th edition, section 8.5).

    Args:
        matrix: shape ``(n, n)``.
    """
    size = len(matrix)
    rest, axes = np.array(matrix, float), np.eye(size)
    pairs = [(p, q) for p in range(size) for q in range(p + 1, size)]
    for _ in range(_SWEEPS):
        diagonal = np.diag(rest)
        open_pairs = [(p, q) for p, q in pairs if rest[p, q] ** 2 > 1e-34 * abs(diagonal[p] * diagonal[q])]
        for p, q in open_pairs:
            if rest[p, q] == 0.0:  # since the last rotation
                continue
            ratio = (rest[q, q] - rest[p, p]) / (2 * rest[p, q])
            tangent = (1.0 if ratio >= 0 else -1.0) / (abs(ratio) + hypot(1.0, ratio))
            cosine = 1 / hypot(1.0, tangent)
            turn = np.eye(size)
            turn[p, p] = turn[q, q] = cosine
            turn[p, q], turn[q, p] = tangent * cosine, -tangent * cosine
            rest, axes = product(product(turn.T, rest), turn), product(axes, turn)
            rest[p, q] = rest[q, p] = 0.0
        if not open_pairs:
            break
    order = np.argsort(np.diag(rest), kind="stable")
    return np.diag(rest)[order], axes[:, order]
