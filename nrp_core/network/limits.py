"""Checks of the values of cells and synapses, the same for networks from any source."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import NetworkError
from nrp_core.network.cells import CELLS, PEAK_MV
from nrp_core.network.drawing import Drawn, extremes, whole
from nrp_core.network.parameters import FINITE, Limit, limits_of
from nrp_core.network.synapses import EVERY_SYNAPSE, LAWS

OF_CELLS: Final = limits_of(
    [*(cell.parameters for cell in CELLS.values()), *(cell.state for cell in CELLS.values())]
)
OF_EVERY_SYNAPSE: Final = limits_of([EVERY_SYNAPSE])
OF_SYNAPSES: Final = limits_of([EVERY_SYNAPSE, *(law.parameters for law in LAWS.values())])


def limits_of_cells(equations: object | None) -> Mapping[str, Limit]:
    """Return the limits of the values of cells; in equations names have other meanings than in PyNN."""
    return OF_CELLS if equations is None else {}


def limits_of_synapses(equations: object | None) -> Mapping[str, Limit]:
    """Return the limits of the values of synapses; in equations names have other meanings than in PyNN."""
    return OF_SYNAPSES if equations is None else OF_EVERY_SYNAPSE


def describing(ends: Callable[[int], tuple[int, int]]) -> Callable[[int], str]:
    """Return a function that describes the synapse at an index, by the cells that it connects."""

    def item(synapse: int) -> str:
        pre, post = ends(synapse)
        return f"synapse {synapse} ({pre} -> {post})"

    return item


def check_values(
    owner: str,
    values: Mapping[str, FloatArray],
    item: Callable[[int], str] = "cell {}".format,
    *,
    limits: Mapping[str, Limit] = OF_CELLS,
) -> None:
    """Check that values are numbers, and physically valid in sign and size.

    Args:
        owner: the object with these values, for the message, e.g. ``population 'exc'``.
        values: one-dimensional arrays by PyNN parameter name, in PyNN's units.
        item: returns the description of the item at an index.
        limits: the valid values by name; a name without one has finite values.

    Raises:
        NetworkError: a value is invalid; the message names owner, item, parameter and value.
    """
    for name, array in values.items():
        limit = limits.get(name, FINITE)
        _require(limit.allows(distinct(array)), owner, item, name, array, limit.rule)


def check_cells(owner: str, values: Mapping[str, FloatArray]) -> None:
    """Check that a reset voltage is below the spike voltage, and that a refractory period can end.

    Args:
        owner: the object with these values, for the message.
        values: every parameter of the cells by PyNN name, shape ``(n,)``.

    Raises:
        NetworkError: a cell would spike again at once.
    """
    if {"rate", "tau_refrac"} <= values.keys():
        _check_dead_time(owner, values["rate"], values["tau_refrac"])
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


def _check_dead_time(owner: str, rate_hz: FloatArray, dead_ms: FloatArray) -> None:
    busy = np.flatnonzero(rate_hz * dead_ms >= 1000.0)
    if busy.size:
        cell = int(busy[0])
        raise NetworkError(
            f"{owner}: the rate of cell {cell} is {rate_hz[cell]:g} Hz; with a tau_refrac of "
            f"{dead_ms[cell]:g} ms it must be less than {1000.0 / dead_ms[cell]:g} Hz"
        )


def check_synapses(
    owner: str, ends: Callable[[int], tuple[int, int]], values: Mapping[str, FloatArray],
    *, receptor: str, conductance_based: bool, signed: bool, limits: Mapping[str, Limit] = OF_SYNAPSES,
) -> None:  # fmt: skip
    """Check the values of synapses as :func:`check_values` does, their limits and the sign of their weights.

    A conductance is never negative, on either receptor; a current is positive on the
    excitatory receptor and negative on the inhibitory one.

    Args:
        owner: the object with these values, for the message.
        ends: returns the indices of the two cells that a synapse connects, for the message.
        values: ``weight`` and other parameters, shape ``(n_synapses,)``.
        receptor: ``excitatory`` or ``inhibitory``.
        conductance_based: whether weights are conductances.
        signed: whether to check the sign.
        limits: the valid values by name.

    Raises:
        NetworkError: a value is invalid, exceeds its limit, or has the wrong sign.
    """
    try:  # the extremes of values that are drawn again say whether all are valid, but not which is not
        seen = {name: extremes(array) for name, array in values.items()}
        _check_synapses(owner, describing(ends), seen, receptor, conductance_based, signed, limits)
    except NetworkError:
        if not any(isinstance(array, Drawn) for array in values.values()):
            raise
        every = {name: whole(array) for name, array in values.items()}
        _check_synapses(owner, describing(ends), every, receptor, conductance_based, signed, limits)


def _check_synapses(
    owner: str, item: Callable[[int], str], values: Mapping[str, FloatArray],
    receptor: str, conductance_based: bool, signed: bool, limits: Mapping[str, Limit],
) -> None:  # fmt: skip
    check_values(owner, values, item, limits=limits)
    if {"w_min", "w_max"} <= values.keys() & limits.keys():
        least, most = (np.abs(values[name]) for name in ("w_min", "w_max"))  # limits are magnitudes
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
        below, above = int((weight < 0).sum()), int((weight > 0).sum())
        if below and above:
            rule += f" ({below} of the weights below 0, {above} above: make a projection for each receptor)"
        _require(weight <= 0 if negative else weight >= 0, owner, item, "weight", weight, rule)


def check_positions(owner: str, positions_um: FloatArray, size: int) -> None:
    """Check positions of cells.

    Raises:
        NetworkError: they have another shape than ``(size, 3)``, or one is not finite.
    """
    if np.shape(positions_um) != (size, 3):
        raise NetworkError(f"{owner}: positions have shape {np.shape(positions_um)}, not ({size}, 3)")
    wrong = ~np.isfinite(positions_um).all(axis=1)
    if wrong.any():
        cell = int(np.argmax(wrong))
        shown = ", ".join(f"{value:g}" for value in positions_um[cell])
        raise NetworkError(f"{owner}: the position of cell {cell} is ({shown}); it must be finite")


def check_spike_times(owner: str, trains: Sequence[FloatArray]) -> None:
    """Check that spike trains (ms, one for each cell) ascend from 0 on.

    Raises:
        NetworkError: a spike train does not ascend from 0.
    """
    for cell, times in enumerate(trains):
        if len(times) and not (times[0] >= 0 and times[-1] < np.inf and (np.diff(times) >= 0).all()):
            raise NetworkError(
                f"{owner}: the spike times of cell {cell} must ascend from 0 ms or later, not {times}"
            )


def distinct(array: FloatArray) -> FloatArray:
    """Return an array; one that was broadcast from a single value becomes an array of one element."""
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
