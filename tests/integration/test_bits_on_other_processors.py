"""Bodies move with the same bits on every processor, although BLAS rounds in other ways on each."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nrp_core._support.small_matrices import length, principal_axes, product
from nrp_core.world.engine_kit.elimination import solve

MOVED = """
import hashlib, sys
from nrp_core import open_world
for experiment in ("braitenberg_husky", "reaching_arm", "stepping_legs"):
    with open_world(experiment, ["world.backend=" + sys.argv[1]]) as world:
        topics = [world.subscribe(name) for name, topic in sorted(world.topics.items())
                  if topic.type.__name__ in {"ModelStates", "JointState", "Odometry", "LaserScan"}]
        found = hashlib.sha256()
        for step in range(1, 21):
            world.run_until(step * 20_000_000)
            found.update(repr([topic.latest for topic in topics]).encode())
        print(experiment, found.hexdigest())
"""


def digests(engine: str, processor: str) -> str:
    environment = {**os.environ, "OPENBLAS_CORETYPE": processor}
    command = [sys.executable, "-c", MOVED, engine]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


@pytest.mark.one_of(3)
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_messages_about_bodies_have_the_same_bits(engine: str) -> None:
    known = digests(engine, "Haswell")
    assert known.count("\n") == 3
    assert digests(engine, "Prescott") == known


NUMBERS = st.floats(-1e3, 1e3, allow_subnormal=False)


@given(arrays(float, (4, 4), elements=NUMBERS))
def test_principal_axes_are_those_of_numpy(matrix: np.ndarray) -> None:
    symmetric = matrix + matrix.T
    values, axes = principal_axes(symmetric)
    scale = max(abs(symmetric).max(), 1e-6)
    np.testing.assert_allclose(values, np.linalg.eigvalsh(symmetric), atol=1e-12 * scale)
    np.testing.assert_allclose(axes @ np.diag(values) @ axes.T, symmetric, atol=1e-12 * scale)


@given(arrays(float, (5, 5), elements=NUMBERS), arrays(float, (5, 2), elements=NUMBERS))
def test_a_system_is_solved_as_numpy_solves_it(matrix: np.ndarray, right: np.ndarray) -> None:
    regular = matrix @ matrix.T + 1e6 * np.eye(5)
    np.testing.assert_allclose(solve(regular, right), np.linalg.solve(regular, right), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("a", "b"),
    [((3,), (3,)), ((3,), (3, 4)), ((2, 3), (3,)), ((2, 3), (3, 2)), ((5, 3, 3),) * 2, ((4, 5, 3), (3,))],
)
def test_products_and_lengths_are_those_of_numpy(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    rng = np.random.default_rng(1)
    left, right = rng.normal(size=a), rng.normal(size=b)
    np.testing.assert_allclose(product(left, right), left @ right)
    assert length(left.ravel()) == pytest.approx(np.linalg.norm(left))
