"""Which numbers cells and synapses can have; one check for networks from any source."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.cells.izhikevich import PEAK_MV
from nrp_core.brain.network.cells.types import CELLS
from nrp_core.brain.network.parameters import FINITE, limits_of
from nrp_core.brain.network.synapses.law import EVERY_SYNAPSE
from nrp_core.brain.network.synapses.laws import LAWS
from nrp_core.errors import NetworkError

_LIMITS: Final = limits_of(
    [
        EVERY_SYNAPSE,
        *(law.parameters for law in LAWS.values()),
        *(cell.parameters for cell in CELLS.values()),
        *(cell.state for cell in CELLS.values()),
    ]
)


def check_values(
    owner: str, values: Mapping[str, FloatArray], item: Callable[[int], str] = "cell {}".format
) -> None:
    """Check that values are numbers, and of a sign and size that physics allows.

    Args:
        owner: whose they are, for the message, e.g. ``population 'exc'``.
        values: by PyNN's parameter name, in PyNN's units, one-dimensional.
        item: describes the owner of the value at an index.

    Raises:
        NetworkError: a value is impossible; the message names owner, item, parameter and value.
    """
    for name, array in values.items():
        limit = _LIMITS.get(name, FINITE)
        _require(limit.allows(distinct(array)), owner, item, name, array, limit.rule)


def check_cells(owner: str, values: Mapping[str, FloatArray]) -> None:
    """Check that no cell is reset to where it spikes again at once.

    Args:
        owner: whose they are, for the message.
        values: every parameter of the cells, by PyNN's name, shape ``(n,)``.

    Raises:
        NetworkError: one is.
    """
    name = "c" if "c" in values else "v_reset"
    if name not in values:
        return
    limit = "v_spike" if "v_spike" in values else "v_thresh"
    highest = values.get(limit, np.full(len(values[name]), PEAK_MV))
    endless = np.flatnonzero(values[name] >= highest)
    if endless.size:
        cell = int(endless[0])
        whose = f"its {limit}, {highest[cell]:g} mV" if limit in values else f"{highest[cell]:g} mV"
        raise NetworkError(
            f"{owner}: {name} of cell {cell} is {values[name][cell]:g} mV; it must be less than {whose}, "
            "where it spikes"
        )


def check_synapses(
    owner: str, ends: Callable[[int], tuple[int, int]], values: Mapping[str, FloatArray],
    *, receptor: str, conductance_based: bool, signed: bool,
) -> None:  # fmt: skip
    """Check the values of synapses as :func:`check_values` does, their limits and the sign of their weights.

    A conductance is never negative, the receptor says what it does; a current is positive on the
    excitatory receptor and negative on the inhibitory one.

    Args:
        owner: whose they are, for the message.
        ends: returns the indices of the two cells that a synapse connects, for the message.
        values: ``weight`` and other parameters, shape ``(n_synapses,)``.
        receptor: ``excitatory`` or ``inhibitory``.
        conductance_based: whether weights are conductances.
        signed: whether to check the sign.

    Raises:
        NetworkError: a value is impossible, beyond another, or has the wrong sign.
    """

    def item(synapse: int) -> str:
        pre, post = ends(synapse)
        return f"synapse {synapse} ({pre} -> {post})"

    check_values(owner, values, item)
    if {"w_min", "w_max"} <= values.keys():
        least, most = (np.abs(values[name]) for name in ("w_min", "w_max"))  # limits are sizes
        wrong = np.flatnonzero(least > most)
        if wrong.size:
            first = int(wrong[0])
            raise NetworkError(
                f"{owner}: w_min of {item(first)} is {least[first]:g}; it must be at most its w_max, "
                f"{most[first]:g}"
            )
    if signed:
        weight = distinct(values["weight"])
        negative = receptor == "inhibitory" and not conductance_based
        kind = "conductance-based" if conductance_based else "current-based"
        rule = f"0 or {'less' if negative else 'more'} on the {receptor} receptor of {kind} cells"
        _require(weight <= 0 if negative else weight >= 0, owner, item, "weight", weight, rule)


def check_spike_times(owner: str, trains: Sequence[FloatArray]) -> None:
    """Check that spike trains (ms, one a cell) ascend from 0 on.

    Raises:
        NetworkError: one does not.
    """
    for cell, times in enumerate(trains):
        if len(times) and not (times[0] >= 0 and times[-1] < np.inf and (np.diff(times) >= 0).all()):
            raise NetworkError(
                f"{owner}: the spike times of cell {cell} must ascend from 0 ms or later, not {times}"
            )


def distinct(array: FloatArray) -> FloatArray:
    """Return an array without the repetitions of one that was broadcast from a single value."""
    return array[:1] if array.strides == (0,) else array


def _require(
    allowed: npt.NDArray[np.bool_],
    owner: str,
    item: Callable[[int], str],
    name: str,
    array: FloatArray,
    rule: str,
) -> None:
    if not allowed.all():
        first = int(np.argmin(allowed))
        raise NetworkError(f"{owner}: {name} of {item(first)} is {array[first]:g}; it must be {rule}")
