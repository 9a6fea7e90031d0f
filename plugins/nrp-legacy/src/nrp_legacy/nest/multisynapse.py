"""Cells of NEST with receptors of several time constants, as cells with two.

A current decays with the time constant of its receptor. If all positive weights onto a cell go to receptors
with one time constant, and all negative ones too, the cell is one with an excitatory and an inhibitory
receptor.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import NetworkError
from nrp_legacy.nest.kernel import Group, Kernel

PLAIN: Final = {"iaf_psc_exp_multisynapse": "iaf_psc_exp", "iaf_psc_alpha_multisynapse": "iaf_psc_alpha"}
"""The models with several receptors, and those with two that are otherwise equal."""
RECEPTOR: Final = "receptor_type"
_TIMES: Final = (2.0,)
_SIGNS: Final = (("tau_syn_ex", "positive", 1.0), ("tau_syn_in", "negative", -1.0))


def settled(group: Group, kernel: Kernel) -> Group:
    """Return a group whose cells have two receptors; others are returned as they are.

    Raises:
        NetworkError: a synapse names no receptor of its target, or weights of one sign have several time
            constants.
    """
    if group.base not in PLAIN:
        return group
    values = {name: column for name, column in group.values.items() if name != "tau_syn"}
    places, weights, times = _incoming(group, kernel)
    for name, sign, factor in _SIGNS:
        chosen = weights * factor > 0
        values[name] = _one_each(group, sign, places[chosen], times[chosen])
    defaults = {name: value for name, value in group.defaults.items() if name != "tau_syn"}
    return replace(group, base=PLAIN[group.base], values=values, defaults=defaults)


def _incoming(group: Group, kernel: Kernel) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the place of the target in the group, weight and time constant of each synapse onto it."""
    parts = list(_parts(group, kernel))
    if not parts:
        return np.empty(0, np.int64), np.empty(0), np.empty(0)
    places, weights, receptors = (np.concatenate(part) for part in zip(*parts, strict=True))
    times_of = [np.atleast_1d(one) for one in _times(group)]
    times = np.empty(len(places))
    for i, (place, receptor) in enumerate(zip(places.tolist(), receptors.tolist(), strict=True)):
        known = times_of[place]
        if not 1 <= receptor <= len(known):
            named = f"receptor {receptor:g}" if receptor else "no receptor"
            raise NetworkError(
                f"nest: a synapse onto '{group.model}' names {named}; receptor_type must be 1 to {len(known)}"
            )
        times[i] = known[int(receptor) - 1]
    return places, weights, times


def _parts(group: Group, kernel: Kernel) -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
    for block in kernel.blocks:
        chosen = (block.post >= group.first) & (block.post < group.first + group.size)
        receptors = block.values.get(RECEPTOR, np.zeros(len(block.post)))
        yield block.post[chosen] - group.first, block.values["weight"][chosen], receptors[chosen]


def _times(group: Group) -> list[Any]:
    """Return the time constants of the receptors of each cell, ms."""
    given = group.values.get("tau_syn", [np.nan] * group.size)
    default = group.defaults.get("tau_syn", _TIMES)
    return [default if np.ndim(one) == 0 and np.isnan(one) else one for one in given]


def _one_each(group: Group, sign: str, places: IntArray, times: FloatArray) -> list[float]:
    """Return the time constant of the weights of one sign for each cell, ms."""
    found = np.array([float(np.atleast_1d(one)[0]) for one in _times(group)])
    found[places] = times
    other = np.flatnonzero(found[places] != times)
    if other.size:
        place = places[other[0]]
        listed = " and ".join(f"{one:g}" for one in np.unique(times[places == place]))
        raise NetworkError(
            f"nest: {sign} weights onto '{group.model}' go to receptors with time constants of {listed} "
            "ms; cells have one for positive and one for negative weights"
        )
    return list(map(float, found))
