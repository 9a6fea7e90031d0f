"""Handles: one argument that stands for many arrays."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event.handles import handle, opened
from nrp_brain_event.records import Array, Link

from nrp_core._support.jit import jit


class Three(NamedTuple):
    """Arrays of several types and shapes."""

    links: Annotated[Array, Link]
    table: Annotated[Array, np.float64, 2]
    flags: Annotated[Array, np.bool_]


def three() -> Three:
    return Three(np.zeros(4, Link.dtype()), np.arange(12.0).reshape(3, 4), np.array([True, False]))


@jit
def work(places: Array, row: int) -> float:
    arrays = opened(Three, places)
    arrays.links[row].window = len(arrays.links) + len(arrays.flags)
    arrays.table[row] += 1.0
    arrays.flags[1] = not arrays.flags[1]
    return float(arrays.table[row, 1] + 100.0 * arrays.table.shape[0] + 1000.0 * arrays.table[:, 3].sum())


def test_compiled_code_reads_and_writes_the_arrays_themselves() -> None:
    arrays, places = handle(three())
    assert work(places, 2) == 10.0 + 300.0 + 1000.0 * (3.0 + 7.0 + 12.0)
    assert arrays.links["window"].tolist() == [0, 0, 6, 0]
    assert arrays.table[2].tolist() == [9.0, 10.0, 11.0, 12.0]
    assert arrays.flags.tolist() == [True, True]


@pytest.mark.parametrize(
    ("wrong", "found"),
    [
        (np.zeros((3, 4), np.float32), "float32 with 2 dimensions"),
        (np.zeros(4), "float64 with 1 dimensions"),
        (np.zeros((3, 8))[:, ::2], r"strides \(64, 16\)"),
    ],
)
def test_an_array_that_is_not_what_is_declared_is_refused(wrong: Array, found: str, golden: Golden) -> None:
    with golden.raises(TypeError, match=rf"Three\.table.*{found}.*float64"):
        handle(three()._replace(table=wrong))
