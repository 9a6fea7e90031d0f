"""Device groups behave as an array of devices."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.dsl.devices import DeviceGroup, SpikeGenerator
from nrp_core.dsl.selection import Selection
from nrp_core.dsl.testing import MockBrain

rates = st.floats(0, 1e6)


def group_of(size: int) -> DeviceGroup:
    brain = MockBrain({"cells": size})

    def device(i: int) -> SpikeGenerator:
        port = brain.add_source(PoissonSource(), [i], name=str(i))
        return SpikeGenerator(
            f"red[{i}]", port, Selection(np.array([i]), "cells"), partial(brain.remove, port)
        )

    return DeviceGroup([device(i) for i in range(size)])


def test_numbers_lists_elements_and_slices_are_set_as_documented() -> None:
    group = group_of(3)
    assert group.rate == [0, 0, 0]
    group.rate = [3, 4, 5]
    assert group.rate == [3, 4, 5]
    group.rate = 2
    assert group.rate == [2, 2, 2]
    group[1].rate = 3
    assert group.rate == [2, 3, 2]
    group[0:2].rate = 5
    assert group.rate == [5, 5, 2]


@given(values=st.lists(rates, min_size=1, max_size=6))
def test_a_set_rate_can_be_read_back(values: list[float]) -> None:
    group = group_of(len(values))
    group.rate = np.array(values)
    assert group.rate == values
    assert [device.rate for device in group] == values


@given(
    values=st.lists(rates, min_size=1, max_size=6),
    index=st.one_of(st.slices(6), st.lists(st.integers(0, 5), min_size=1), st.integers(0, 5)),
)
def test_an_index_of_a_group_is_that_of_an_array(values: list[float], index: object) -> None:
    group = group_of(len(values))
    group.rate = values
    try:
        wanted = np.array(values)[index]  # type: ignore[call-overload]
    except IndexError:
        with pytest.raises(IndexError):
            group[index]
    else:
        chosen = group[index]
        assert np.all(chosen.rate == wanted)


def test_a_subgroup_holds_the_same_devices() -> None:
    group = group_of(4)
    group[[3, 1]].rate = [30, 10]
    assert group.rate == [0, 10, 0, 30]


@pytest.mark.parametrize("values", [[1, 2], [1, 2, 3, 4], []])
def test_another_number_of_values_is_refused_and_nothing_is_set(values: list[float], golden: Golden) -> None:
    group = group_of(3)
    with golden.raises(ValueError):
        group.rate = values
    assert group.rate == [0, 0, 0]


def test_an_attribute_that_the_devices_lack_is_refused(golden: Golden) -> None:
    group = group_of(2)
    with golden.raises(AttributeError, match=r"red\[0\].*'rate'"):
        group.rates = 5
    with golden.raises(AttributeError, match="'rate'"):
        _ = group.rat


def test_a_group_is_active_when_all_its_devices_are() -> None:
    group = group_of(2)
    assert group.active
    group[0].active = False
    assert not group.active
    group.set_active(True)
    assert group.active
