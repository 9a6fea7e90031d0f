"""Impossible numbers are refused where they enter a network, by name."""

from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import NetworkError
from nrp_core.network.limits import (
    OF_CELLS,
    OF_SYNAPSES,
    check_spike_times,
    check_synapses,
    check_values,
)


def ends(synapse: int) -> tuple[int, int]:
    return synapse + 4, synapse + 6


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("cm", -0.1, "more than 0, and finite"),
        ("tau_m", 0.0, "more than 0, and finite"),
        ("tau_syn_E", np.nan, "more than 0, and finite"),
        ("tau_refrac", -1.0, "0 or more, and finite"),
        ("duration", -1.0, "0 or more"),
        ("gsyn_exc", -0.1, "0 or more, and finite"),
        ("m", 1.5, "between 0 and 1"),
        ("i_offset", np.inf, "finite"),
        ("rate", -5.0, "from 0 to 1e+07 Hz"),
        ("rate", 1e9, "from 0 to 1e+07 Hz"),
        ("U", 1.5, "between 0 and 1"),
        ("v_rest", np.nan, "finite"),
        ("v_thresh", np.nan, "a number"),
        ("weight", np.inf, "finite"),
        ("delay", -0.5, "0 ms or more, and finite"),
    ],
)
def test_the_message_names_owner_cell_parameter_value_and_rule(
    name: str, value: float, rule: str, golden: Golden
) -> None:
    limits = OF_SYNAPSES if name in OF_SYNAPSES else OF_CELLS
    with pytest.raises(NetworkError) as caught:
        check_values("population 'exc'", {name: np.array([1.0, value])}, limits=limits)
    golden(str(caught.value))


@given(st.lists(st.floats(-1.0, 1.0), min_size=1))
def test_a_time_constant_is_accepted_exactly_if_all_are_positive(values: list[float]) -> None:
    try:
        check_values("p", {"tau_m": np.array(values)})
    except NetworkError:
        assert min(values) <= 0
    else:
        assert min(values) > 0


def test_an_infinite_threshold_is_a_number() -> None:
    check_values("p", {"v_thresh": np.array([np.inf])})


@pytest.mark.parametrize(
    ("conductance_based", "receptor", "right", "wrong"),
    [
        (True, "excitatory", 0.1, -0.1),
        (True, "inhibitory", 0.1, -0.1),
        (False, "excitatory", 0.1, -0.1),
        (False, "inhibitory", -0.1, 0.1),
    ],
)
def test_the_sign_of_a_weight_follows_from_receptor_and_kind_of_cell(
    conductance_based: bool, receptor: str, right: float, wrong: float, golden: Golden
) -> None:
    options: dict[str, Any] = {"conductance_based": conductance_based, "receptor": receptor, "signed": True}
    check_synapses("projection 'a'", ends, {"weight": np.array([right, 0.0])}, **options)
    with golden.raises(NetworkError, match=rf"'a'.*1 \(5 -> 7\).*{wrong:g}"):
        check_synapses("projection 'a'", ends, {"weight": np.array([right, wrong])}, **options)


def test_one_wrong_weight_for_all_synapses_is_found_without_spreading_it_out(golden: Golden) -> None:
    n = 10**9
    everywhere = np.broadcast_to(np.float64(-1.0), (n,))
    with golden.raises(NetworkError, match=r"0 \(4 -> 6\).*-1"):
        check_synapses(
            "p", ends, {"weight": everywhere},
            conductance_based=True, receptor="excitatory", signed=True,
        )  # fmt: skip


@pytest.mark.parametrize("times", [[2.0, 1.0], [-1.0, 1.0], [1.0, np.inf], [1.0, np.nan, 2.0]])
def test_spike_times_ascend_from_zero(times: list[float], golden: Golden) -> None:
    with golden.raises(NetworkError):
        check_spike_times("population 's'", [np.empty(0), np.array(times)])
