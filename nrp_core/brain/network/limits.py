"""Which numbers cells and synapses can have; one check for networks from any source."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from nrp_core.errors import NetworkError

_POSITIVE = frozenset({"cm", "tau_m", "tau_syn_E", "tau_syn_I", "tau_w", "tau_rec", "tau_plus", "tau_minus"})
_NOT_NEGATIVE = frozenset(
    {"tau_refrac", "delta_T", "g_leak", "gbar_Na", "gbar_K", "duration", "tau_facil", "gsyn_exc", "gsyn_inh"}
)
_FRACTIONS = frozenset({"U", "dendritic_delay_fraction", "m", "h", "n"})
_MAY_BE_INFINITE = frozenset({"v_thresh", "v_spike", "start", "duration", "tau_facil", "w_min", "w_max"})
_IZHIKEVICH_PEAK_MV = 30.0
MAX_RATE_HZ = 1e7
"""Spikes a second into one neuron: a hundred thousand afferents at 100 Hz. What is beyond is a mistake, and
would have the machine draw spikes for ever."""

Values = npt.NDArray[np.float64]


def check_values(
    owner: str, values: Mapping[str, Values], item: Callable[[int], str] = "cell {}".format
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
        allowed, rule = _allowed(name, distinct(array))
        _require(allowed, owner, item, name, array, rule)


def check_cells(owner: str, values: Mapping[str, Values]) -> None:
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
    highest = values.get(limit, np.full(len(values[name]), _IZHIKEVICH_PEAK_MV))
    endless = np.flatnonzero(values[name] >= highest)
    if endless.size:
        cell = int(endless[0])
        whose = f"its {limit}, {highest[cell]:g} mV" if limit in values else f"{highest[cell]:g} mV"
        raise NetworkError(
            f"{owner}: {name} of cell {cell} is {values[name][cell]:g} mV; it must be less than {whose}, "
            "where it spikes"
        )


def check_synapses(
    owner: str, ends: Callable[[int], tuple[int, int]], values: Mapping[str, Values],
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


def check_spike_times(owner: str, trains: Sequence[Values]) -> None:
    """Check that spike trains (ms, one a cell) ascend from 0 on.

    Raises:
        NetworkError: one does not.
    """
    for cell, times in enumerate(trains):
        if len(times) and not (times[0] >= 0 and times[-1] < np.inf and (np.diff(times) >= 0).all()):
            raise NetworkError(
                f"{owner}: the spike times of cell {cell} must ascend from 0 ms or later, not {times}"
            )


def distinct(array: Values) -> Values:
    """Return an array without the repetitions of one that was broadcast from a single value."""
    return array[:1] if array.strides == (0,) else array


def _require(
    allowed: npt.NDArray[np.bool_],
    owner: str,
    item: Callable[[int], str],
    name: str,
    array: Values,
    rule: str,
) -> None:
    if not allowed.all():
        first = int(np.argmin(allowed))
        raise NetworkError(f"{owner}: {name} of {item(first)} is {array[first]:g}; it must be {rule}")


def _allowed(name: str, array: Values) -> tuple[npt.NDArray[np.bool_], str]:
    if name in _POSITIVE:
        return (array > 0) & (array < np.inf), "more than 0, and finite"
    if name in _NOT_NEGATIVE:
        finite = name not in _MAY_BE_INFINITE
        return (array >= 0) & ((array < np.inf) | (not finite)), "0 or more" + ", and finite" * finite
    if name in _FRACTIONS:
        return (array >= 0) & (array <= 1), "between 0 and 1"
    if name == "rate":
        return (array >= 0) & (array <= MAX_RATE_HZ), f"from 0 to {MAX_RATE_HZ:g} Hz"
    if name == "delay":
        return (array >= 0) & (array < np.inf), "0 ms or more, and finite"
    if name in _MAY_BE_INFINITE:
        return ~np.isnan(array), "a number"
    return np.isfinite(array), "finite"
