"""NEST beside another simulator in one brain gives the spikes of NEST alone."""

from typing import Any, ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_conformance import BrainBackendTests
from nrp_conformance.brain import BrainContractTests
from nrp_core.network.synapses import STATIC, TSODYKS_MARKRAM
from random_networks import LABELS, network, spikes_of

NEST = {"backend": "nest"}
GRID = {"backend": "event", "options": {"resolution": "0.1 ms"}}
SHARED: dict[str, Any] = {"parts": {"grid": GRID, "nest": NEST}}


@pytest.mark.parametrize("laws", [(STATIC,), (STATIC, TSODYKS_MARKRAM)], ids=["static", "short-term"])
@settings(max_examples=5, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32),
    cut=st.sets(st.sampled_from(LABELS), min_size=1, max_size=2),
    stops_ms=st.sets(st.integers(1, 149), max_size=4).map(lambda stops: (*sorted(stops), 150)),
)
def test_cells_on_two_simulators_fire_as_all_do_on_nest(
    laws: tuple[str, ...], seed: int, cut: set[str], stops_ms: tuple[int, ...]
) -> None:
    whole = network(seed, 0.1, laws, shortest=3)
    expected = spikes_of("nest", whole, {}, (150,))
    options = {"parts": {"grid": {**GRID, "populations": sorted(cut)}, "rest": NEST}}
    found = spikes_of("composite", whole, options, stops_ms)
    assert found.neurons.tolist() == expected.neurons.tolist()
    assert found.times_ms.tolist() == expected.times_ms.tolist()


class TestContractOfEventAndNest(BrainContractTests):
    """Both on one grid against the contract of the kit."""

    backend_name = "composite"
    options: ClassVar[dict[str, Any]] = SHARED


@pytest.mark.heavy
class TestEventAndNest(BrainBackendTests):
    """The same against all that the kit requires."""

    backend_name = "composite"
    options: ClassVar[dict[str, Any]] = SHARED
