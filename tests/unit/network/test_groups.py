"""Several networks form one; each is a group with names of its own."""

from dataclasses import replace

import numpy as np
import pytest

from nrp_core.dsl.selection import BrainRoot, brain, evaluate, select
from nrp_core.network.currents import InjectedCurrent
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.groups import join_networks
from nrp_core.network.rewiring import Rewiring


def network(size: int, timestep_ms: float | None = None) -> Network:
    cells = Population("cells", size, "IF_curr_exp", {"tau_m": np.full(size, 20.0)})
    ends = np.arange(size, dtype=np.int32)
    loop = Projection("loop", "cells", "cells", "excitatory", ends, ends[::-1], np.ones(size), np.ones(size))
    current = InjectedCurrent(np.array([1]), np.array([0.0]), np.array([0.5]))
    return Network(
        {"cells": cells}, (loop,), {"eyes": np.array([0])}, timestep_ms,
        remarks=("a remark",), currents=(current,),
    )  # fmt: skip


@pytest.fixture
def joined() -> Network:
    return join_networks({"red": network(2, 0.1), "blue": network(3, 1.0)})


def test_every_name_begins_with_that_of_its_group(joined: Network) -> None:
    assert list(joined.populations) == ["red.cells", "blue.cells"]
    assert [(one.label, one.pre, one.post) for one in joined.projections] == [
        ("red.loop", "red.cells", "red.cells"), ("blue.loop", "blue.cells", "blue.cells"),
    ]  # fmt: skip
    assert joined.remarks == ("red: a remark", "blue: a remark")
    assert joined.timestep_ms == 0.1


def test_global_ids_follow_the_order_of_the_groups(joined: Network) -> None:
    assert {name: ids.tolist() for name, ids in joined.views.items()} == {"red.eyes": [0], "blue.eyes": [2]}
    assert [current.neurons.tolist() for current in joined.currents] == [[1], [3]]


def test_a_group_has_its_populations_as_attributes(joined: Network) -> None:
    root = BrainRoot(joined)
    assert select(brain.blue.eyes, root).ids.tolist() == [2]
    assert select(brain.red.cells[1], root).ids.tolist() == [1]
    assert select(brain.red.group["cells"], root).ids.tolist() == [0, 1]
    assert evaluate(brain.blue.projection("loop"), root).label == "blue.loop"


def test_streams_of_rewiring_belong_to_their_group() -> None:
    whole = network(2)
    shared = replace(whole.projections[0], rewiring=Rewiring(seed=1, stream="cells"))
    joined = join_networks({"red": replace(whole, projections=(shared,))})
    rewiring = joined.projections[0].rewiring
    assert rewiring is not None
    assert rewiring.stream == "red.cells"
