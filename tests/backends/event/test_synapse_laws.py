"""Several synapse laws side by side: one record for all, one kernel that chooses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from nrp_brain_event.synapse_kernels import one_of
from nrp_brain_event.synapse_laws import share_fields

from nrp_core._support.jit import jit
from nrp_core.network.synapses import LAWS, STDP, TSODYKS_MARKRAM


@jit
def _half(_synapse: Any, _t: float) -> float:
    return 0.5


@jit
def _time(synapse: Any, t: float) -> float:
    synapse.t = t
    return t


@jit
def _state(synapse: Any, _t: float) -> float:
    return float(synapse.u)


@jit
def _shares(table: Any, share: Any, t: float) -> Any:
    shares = np.empty(len(table))
    for k in range(len(table)):
        shares[k] = share(table[k], t)
    return shares


def test_each_synapse_runs_the_kernel_of_its_law() -> None:
    table = np.zeros(4, np.dtype((np.record, [("t", "f8"), ("u", "f8"), ("law", "i8")])))
    table["law"], table["u"] = [2, 0, 1, 2], 0.25
    assert _shares(table, one_of([_half, _time, _state]), 3.0).tolist() == [0.25, 0.5, 3.0, 0.25]
    assert table["t"].tolist() == [0.0, 0.0, 3.0, 0.0]


def test_a_kernel_alone_is_called_without_a_choice() -> None:
    assert one_of([_half]) is _half


@pytest.mark.parametrize(("laws", "numbered"), [((TSODYKS_MARKRAM,), False), ((TSODYKS_MARKRAM, STDP), True)])
def test_the_record_holds_what_any_of_the_laws_can_use(laws: tuple[str, ...], numbered: bool) -> None:
    fields = [name for name, _ in share_fields(dict.fromkeys(laws))]
    assert len(fields) == len(set(fields))
    assert {name for law in laws for name in (*LAWS[law].parameters, *LAWS[law].state)} <= set(fields)
    assert {"tau_psc", "t"} <= set(fields)
    assert ("law" in fields) is numbered
