"""Rays meet the same triangles of a mesh through its tree as one by one."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nrp_core.world.raycast.collisions import LEAF, MAX_DEPTH, first_crossing, mesh_trees


def crossings(triangles: np.ndarray, origin: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """Return the distance to each triangle's plane where the ray is within it, by barycentric coordinates."""
    found = []
    for a, b, c in triangles:
        try:
            u, v, t = np.linalg.solve(np.column_stack([b - a, c - a, -ray]), origin - a)
        except np.linalg.LinAlgError:
            continue
        found.append(t if min(u, v, 1 - u - v) >= 0 else inf)
    return np.array([*found, inf])


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 40), st.integers(0, 2**32 - 1), st.floats(0.01, 2.0))
def test_the_first_crossing_is_the_nearest_of_all(count, seed, size):
    rng = np.random.default_rng(seed)
    meshes = [
        rng.uniform(-3, 3, (each, 1, 3)) + rng.uniform(-size, size, (each, 3, 3)) for each in (count, 7)
    ]
    trees = mesh_trees(meshes)
    origin, ray = rng.uniform(-4, 4, 3), rng.normal(size=3)
    ray /= np.linalg.norm(ray)
    for mesh, (first, end, root, leaves) in zip(meshes, trees.places, strict=True):
        own, boxes = trees.triangles[first:end], trees.boxes[root:]
        waiting = np.empty(MAX_DEPTH, np.int64)
        t = first_crossing(own, boxes, leaves, origin, ray, 0.5, 6.0, waiting)
        all_of_them = crossings(mesh, origin, ray)
        expected = all_of_them[(all_of_them >= 0.5)].min(initial=inf)
        assert (t if t <= 6.0 else inf) == pytest.approx(expected if expected <= 6.0 else inf, rel=1e-6)


def test_flat_meshes_are_met_along_their_axes_and_distances_are_those_of_leaves():
    square = np.array([[(0, 0, 1), (1, 0, 1), (1, 1, 1)], [(0, 0, 1), (1, 1, 1), (0, 1, 1)]], float)
    rows = np.concatenate([square + np.array([x, y, 0]) for x in range(9) for y in range(9)])
    trees = mesh_trees([rows])
    assert len(rows) > 8 * LEAF
    waiting = np.empty(MAX_DEPTH, np.int64)
    for x, y in np.random.default_rng(1).integers(0, 10, (20, 2)):
        origin = np.array([x, y, 3.0])  # above a corner or an edge
        t = first_crossing(
            trees.triangles, trees.boxes, trees.places[0, 3], origin, np.array([0, 0, -1.0]), 0, 9, waiting
        )
        assert t == pytest.approx(2.0)
    assert trees.distance(0, (4.5, 4.5, 1.0)) == pytest.approx(0.0, abs=1e-6)
    assert trees.distance(0, (4.5, 4.5, 0.0)) == pytest.approx(1.0, abs=1e-6)
    assert trees.distance(0, (12.0, 4.5, 1.0)) == pytest.approx(3.0, abs=1e-6)
