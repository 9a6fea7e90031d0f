"""The kernels of all synapse laws, compiled into one for each purpose; the record selects its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nrp_brain_event.synapse_laws import RULES, SHARES, Share
from nrp_core._support.jit import jit

Kernel = Callable[..., Any]


def one_of(kernels: Sequence[Kernel]) -> Kernel:
    """Return a kernel that calls the one selected by ``law`` of its first argument; a single one itself."""
    *others, chosen = kernels
    for number, kernel in reversed(list(enumerate(others))):
        chosen = _either(number, kernel, chosen)
    return chosen


def _either(number: int, kernel: Kernel, other: Kernel) -> Kernel:
    def either(selecting: Any, *arguments: Any) -> Any:
        if selecting.law == number:
            return kernel(selecting, *arguments)
        return other(selecting, *arguments)

    return jit(either)


_rules = [load() for load in RULES.values()]

released_share: Share = one_of([load() for load in SHARES.values()])
on_source = one_of([rule.on_source for rule in _rules])
on_target = one_of([rule.on_target for rule in _rules])
