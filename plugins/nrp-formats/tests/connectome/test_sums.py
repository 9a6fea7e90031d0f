"""Edges of a connectome add up to the same network in any order, and in memory for the pairs alone."""

from collections import Counter
from pathlib import Path
from random import Random

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_formats.connectome import wiring
from nrp_formats.connectome.network import read_connectome
from nrp_formats.connectome.wiring import Places, Sums
from pyarrow import csv, feather

ROOT = 720575940600000000
N = 7
ROWS = st.lists(
    st.tuples(st.integers(0, N - 1), st.integers(0, N - 1), st.integers(-9, 9)), min_size=1, max_size=60
)


@settings(max_examples=50, deadline=None)
@given(rows=ROWS, part=st.integers(1, 9), at_once=st.integers(1, 20))
def test_edges_are_the_sums_of_their_pairs_for_parts_of_any_size(
    rows: list[tuple[int, int, int]], part: int, at_once: int
) -> None:
    expected: Counter[tuple[int, int]] = Counter()
    edges = Sums(N)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(wiring, "PART", part)
        for first in range(0, len(rows), at_once):
            pre, post, weight = np.array(rows[first : first + at_once]).T
            edges.add(pre * N + post, np.abs(weight).astype(float))
    for pre, post, weight in rows:
        expected[pre, post] += abs(weight)
    pairs = sorted(expected)
    assert np.repeat(np.arange(N), edges.degrees).tolist() == [pre for pre, _ in pairs]
    assert edges.post.tolist() == [post for _, post in pairs]
    assert edges.count.tolist() == [expected[pair] for pair in pairs]
    assert edges.post.itemsize + edges.count.itemsize == 8


@settings(max_examples=20, deadline=None)
@given(rows=ROWS, at_once=st.integers(1, 30), order=st.randoms())
def test_the_digest_is_that_of_the_merged_table_for_rows_in_any_order_and_number_at_once(
    rows: list[tuple[int, int, int]], at_once: int, order: Random,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:  # fmt: skip
    """The table with one row for each pair and sign, sorted, is what the neuropils' table adds up to."""
    rows = [*rows, (0, 1, 1)]
    merged: Counter[tuple[int, int, bool]] = Counter()
    for pre, post, weight in rows:
        if weight:
            merged[pre, post, weight > 0] += weight
    alone = [(pre, post, weight) for (pre, post, _), weight in sorted(merged.items())]
    shuffled = [*rows]
    order.shuffle(shuffled)
    folder = tmp_path_factory.mktemp("tables")
    neurons = folder / "neurons.csv"
    csv.write_csv(pa.table({"id": [ROOT + i for i in range(N)]}), str(neurons))
    digests = set()
    for name, table in (("alone", alone), ("shuffled", shuffled)):
        sources, targets, weights = (list(column) for column in zip(*table, strict=True))
        columns = {"pre": [ROOT + i for i in sources], "post": [ROOT + i for i in targets], "weight": weights}
        path = folder / f"{name}.feather"
        feather.write_feather(pa.table(columns), str(path), chunksize=3)
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(wiring, "FEWEST", at_once)
            digests.add(read_connectome(path, neurons, unknown="excite").network.digest)
    assert len(digests) == 1


def test_a_table_with_a_row_for_each_synapse_is_counted(tmp_path: Path) -> None:
    """In the columns of FlyWire's table of synapses, in which an edge is as many rows."""
    ends = {
        "pre_pt_root_id": [ROOT, ROOT, ROOT + 1, ROOT],
        "post_pt_root_id": [ROOT + 1, *[ROOT] * 2, ROOT + 1],
    }
    path = tmp_path / "synapses.feather"
    feather.write_feather(pa.table({"id": [1, 2, 3, 4], **ends, "cleft_score": [50.0] * 4}), str(path))
    made = read_connectome(path, unit_mv=0.5, unknown="excite")
    (edges,) = made.network.projections
    pairs = [*zip(edges.pre_index.tolist(), edges.post_index.tolist(), edges.weight.tolist(), strict=True)]
    assert pairs == [(0, 0, 0.5), (0, 1, 1.0), (1, 0, 0.5)]


def test_places_are_those_of_a_search() -> None:
    rng = np.random.default_rng(1)
    for ids in (rng.permutation(5000) * 3, np.array([7]), np.empty(0, np.int64)):
        asked = np.arange(-1, 15_000)
        places, found = Places(ids).of(asked)
        assert (found == np.isin(asked, ids)).all()
        assert (ids[places[found]] == asked[found]).all()
