"""The kernels that only some networks need, each compiled when the first network needs it.

Compiled with the loop that all networks run, they would take half of the time of its first use.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np

from nrp_brain_event.addresses import address_of
from nrp_brain_event.grid.curved import set_curved_current, update_curved
from nrp_brain_event.grid.equations.advance import update_blocks
from nrp_brain_event.grid.noise import add_noise, hear_noise
from nrp_brain_event.grid.probes import take_samples
from nrp_brain_event.grid.records import (
    ADD_NOISE,
    CURVED,
    DELIVER,
    DELIVER_LATE,
    HEAR_NOISE,
    N_ON_DEMAND,
    PLASTIC,
    SET_CURVED_CURRENT,
    SHORT_TERM,
    STORE_FOR_PLASTIC,
    TAKE_SAMPLES,
    UPDATE_BLOCKS,
    UPDATE_CURVED,
    Grid,
)
from nrp_brain_event.grid.synapses import (
    deliver_every,
    deliver_late,
    deliver_plastic,
    deliver_short_term,
    deliver_static,
    store_for_plastic,
)
from nrp_brain_event.records import Array

Kernel = Callable[..., int]

_KERNELS: Final[dict[int, tuple[Kernel, tuple[str, ...]]]] = {
    UPDATE_BLOCKS: (update_blocks, ("int64", "int64")),
    UPDATE_CURVED: (update_curved, ("int64", "int64")),
    SET_CURVED_CURRENT: (set_curved_current, ("int64", "float64")),
    ADD_NOISE: (add_noise, ("int64",)),
    HEAR_NOISE: (hear_noise, ("int64",)),
    TAKE_SAMPLES: (take_samples, ("int64",)),
    DELIVER_LATE: (deliver_late, ("int64", "int64")),
    STORE_FOR_PLASTIC: (store_for_plastic, ("int64", "int64")),
}
"""Each with the types of its arguments after the ``places``."""
_DELIVER: Final = {
    (False, False): deliver_static,
    (True, False): deliver_short_term,
    (False, True): deliver_plastic,
    (True, True): deliver_every,
}
"""By whether there are synapses with short-term plasticity, and plastic ones."""


def codes_for(grid: Grid) -> Array:
    """Return the ``codes`` with which a grid begins."""
    is_plastic, needed = bool((grid.tables["dynamic"] == PLASTIC).any()), []
    if (grid.runs["kind"] == CURVED).any():
        needed += [UPDATE_CURVED, SET_CURVED_CURRENT]
    if len(grid.blocks):
        needed += [UPDATE_BLOCKS]
    if len(grid.noise):
        needed += [ADD_NOISE, HEAR_NOISE]
    if is_plastic:
        needed += [STORE_FOR_PLASTIC]
    codes = with_kernels(np.zeros(N_ON_DEMAND, np.int64), *needed)
    is_released = bool((grid.tables["dynamic"] == SHORT_TERM).any())
    codes[DELIVER] = _code_of(_DELIVER[is_released, is_plastic], ("int64",))
    return codes


def with_kernels(codes: Array, *kernels: int) -> Array:
    """Return codes with further kernels."""
    codes = codes.copy()
    for kernel in kernels:
        codes[kernel] = _code_of(*_KERNELS[kernel])
    return codes


@cache
def _code_of(kernel: Kernel, arguments: tuple[str, ...]) -> int:
    return address_of(kernel, ("*int64", *arguments))
