"""A network in parts gives the spikes of the whole network, to the last bit."""

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_networks import LABELS, network, parts, spikes_of

from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

CUTS = st.sets(st.sampled_from(LABELS), max_size=2)
STOPS = st.sets(st.integers(1, 149), max_size=4).map(lambda stops: (*sorted(stops), 150))


@pytest.mark.parametrize(
    ("backend", "options", "step_ms", "laws"),
    [
        ("event", {}, 0.05, (STATIC,)),
        ("event", {}, 0.05, (STATIC, STDP, TSODYKS_MARKRAM)),
        ("event", {"resolution": "0.1 ms"}, 0.1, (STATIC,)),
        ("event", {"resolution": "0.1 ms"}, 0.1, (STATIC, STDP, TSODYKS_MARKRAM)),
        ("spinnaker", {}, 1.0, (STATIC,)),
    ],
    ids=["exact", "exact_plastic", "grid", "grid_plastic", "spinnaker"],
)
@settings(max_examples=12)
@given(seed=st.integers(0, 2**32), cut=CUTS, stops_ms=STOPS)
def test_two_parts_give_the_spikes_of_the_whole(
    backend: str, options: dict[str, Any], step_ms: float, laws: tuple[str, ...], seed: int, cut: set[str],
    stops_ms: tuple[int, ...],
) -> None:  # fmt: skip
    whole = network(seed, step_ms, laws)
    expected = spikes_of(backend, whole, options, (150,))
    found = spikes_of("composite", whole, parts(backend, options, cut), stops_ms)
    assert found.neurons.tolist() == expected.neurons.tolist()
    assert found.times_ms.tolist() == expected.times_ms.tolist()
