"""Indices of cells take little memory and show as arrays of 32-bit integers."""

import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.network import indices
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.indices import Indices

SIZES = st.lists(st.integers(0, 9), min_size=1, max_size=30)


@contextmanager
def few_are_many() -> Iterator[None]:
    """Let a few indices be kept as many are."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(indices, "_FEW", 8)
        patch.setattr(indices, "_PART", 5)
        yield


@given(st.lists(st.integers(-3, 70_000), max_size=60), st.booleans())
def test_indices_show_what_was_kept(values: list[int], ascending: bool) -> None:
    given_values = np.array(sorted(values) if ascending else values, np.int32)
    with few_are_many():
        check(Indices.of(given_values), given_values)


@given(SIZES)
def test_ascending_indices_show_the_kept_items(counts: list[int]) -> None:
    each = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    with few_are_many():
        check(Indices.repeated(np.arange(len(counts)), counts), each)
        check(Indices.of(np.repeat(each, 20)), np.repeat(each, 20))


def check(kept: Indices, expected: np.ndarray) -> None:
    np.testing.assert_array_equal(kept.whole(), expected)
    np.testing.assert_array_equal(np.concatenate([np.empty(0, np.int32), *kept.parts()]), expected)
    assert kept.whole().dtype == np.int32
    assert len(kept) == len(expected)
    assert kept.bounds() == ((int(expected.min()), int(expected.max())) if len(expected) else (0, -1))
    for k in range(0, len(expected), 7):
        assert kept.part(k, k + 1).tolist() == [expected[k]]


def test_a_projection_keeps_two_bytes_a_synapse() -> None:
    n, in_degree = 1000, 300
    sources = np.random.default_rng(1).integers(0, n, n * in_degree).astype(np.int32)
    weight = np.broadcast_to(np.float64(0.1), n * in_degree)
    tracemalloc.start()
    projection = Projection(
        "p",
        "a",
        "a",
        "excitatory",
        sources,
        np.repeat(np.arange(n, dtype=np.int32), in_degree),
        weight,
        weight,
    )
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 2.2 * projection.size
    np.testing.assert_array_equal(projection.pre_index, sources)


def test_the_digest_does_not_depend_on_how_indices_are_kept() -> None:
    def digest(dtype: type) -> str:
        pre, post = np.arange(40, dtype=dtype) % 7, np.repeat(np.arange(4, dtype=dtype), 10)
        ones = np.ones(40)
        population = Population("a", 7, "IF_curr_exp", {"cm": np.ones(7)})
        return Network(
            {"a": population}, (Projection("p", "a", "a", "excitatory", pre, post, ones, ones),)
        ).digest

    with few_are_many():
        narrow = digest(np.uint16)
    assert narrow == digest(np.int32) == digest(np.int64)
