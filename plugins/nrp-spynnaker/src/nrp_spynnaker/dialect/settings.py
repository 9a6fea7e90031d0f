"""The settings of a population that only sPyNNaker has: which become hints, and which mean nothing here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from nrp_core.brain.pynn.invalid import InvalidValueError
from nrp_core.errors import NetworkError, did_you_mean

SUMMED: Final = "max_expected_summed_weight"
_SUMMED_WEIGHTS: Final = ("max_summed_weight_exc", "max_summed_weight_inh")
_HINTS: Final = {
    "neurons_per_core": "neurons_per_core",
    "n_synapse_cores": "synapse_cores",
    "spikes_per_second": "spikes_per_second",
    "ring_buffer_sigma": "ring_buffer_sigma",
}
_WITHOUT_EFFECT: Final = {
    "incoming_spike_buffer_size": "no spike is lost here",
    "drop_late_spikes": "no spike is late here",
    "n_colour_bits": "no packet is late here",
    "allow_delay_extensions": "delays of any length are extended",
    "seed": "random numbers follow the seed of setup",
    "max_rate": "a rate may have any value",
    "n_data_specs": "nothing is loaded onto a machine",
    "port": "only a SpikeInjector receives spikes",
    "virtual_key": "only a SpikeInjector receives spikes",
    "reserve_reverse_ip_tag": "nothing is loaded onto a machine",
    "splitter": "",
    "splitter_object": "",
}
"""The settings that change nothing, and why; none for those that are treated elsewhere."""


class Splitter:
    """How sPyNNaker divides a population among cores.

    Args:
        n_synapse_vertices: the number of synapse-only cores for each core of neurons, if it has any.
    """

    def __init__(self, n_synapse_vertices: Any = None, *_: Any, **__: Any) -> None:
        self.hints: dict[str, float] = {}
        if isinstance(n_synapse_vertices, (int, np.integer)):
            self.hints = {"synapse_cores": float(n_synapse_vertices)}


def cells_per_core(owner: str, given: Any) -> float:
    """Return the number of cells on a core, given as a number or, for a grid of cells, one for each axis.

    Parts of a cell are left out, as in sPyNNaker.

    Raises:
        InvalidValueError: it is not a whole number of 1 or more.
    """
    numbers = given if isinstance(given, (tuple, list)) else [given]
    if not numbers or not all(isinstance(n, (int, float, np.number)) and 1 <= n < np.inf for n in numbers):
        raise InvalidValueError(
            f"{owner}: neurons_per_core is {given!r}; it must be a whole number of 1 or more, or one for "
            "each axis of a grid"
        )
    return float(np.prod([int(n) for n in numbers]))


def hints_of(owner: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Return the hints in ``additional_parameters``.

    Raises:
        NetworkError: there is no such setting, or its value is impossible.
    """
    hints: dict[str, float] = {}
    for name, value in given.items():
        if name in _WITHOUT_EFFECT:
            hints |= getattr(value, "hints", {})
        elif value is None:
            continue
        elif name == SUMMED:
            hints |= zip(_SUMMED_WEIGHTS, _numbers(owner, value), strict=True)
        elif name == "neurons_per_core":
            hints[name] = cells_per_core(owner, value)
        elif name in _HINTS:
            hints[_HINTS[name]] = _numbers(owner, [value], name)[0]
        else:
            valid = [*_HINTS, SUMMED, *_WITHOUT_EFFECT]
            raise NetworkError(f"{owner} has no additional parameter '{name}'{did_you_mean(name, valid)}")
    return hints


def remarks_on(owner: str, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each setting that has no effect."""
    for name, value in given.items():
        if value is not None and _WITHOUT_EFFECT.get(name):
            yield f"{owner}: its additional parameter {name} has no effect: {_WITHOUT_EFFECT[name]}"


def _numbers(owner: str, values: Any, name: str = SUMMED) -> list[float]:
    each = list(values) if isinstance(values, (Sequence, np.ndarray)) else []
    if (name == SUMMED and len(each) != 2) or not all(isinstance(v, (int, float, np.number)) for v in each):
        expected = "two numbers, for excitation and inhibition" if name == SUMMED else "a number"
        raise InvalidValueError(f"{owner}: {name} is {values!r}; it must be {expected}")
    if any(not np.isfinite(v) or v < 0 for v in each):
        raise InvalidValueError(f"{owner}: {name} is {values!r}; it must be 0 or more, and finite")
    return [float(v) for v in each]
