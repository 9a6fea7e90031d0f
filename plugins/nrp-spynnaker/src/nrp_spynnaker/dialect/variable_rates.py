"""Poisson sources whose rates change at given times, as source cells with drawn spikes.

Scripts give rates once for all cells or a list for each. A rate holds for its duration, but no longer than
until the next one starts.
"""

# mypy: disable-error-code="misc"

from __future__ import annotations

from typing import Any

import numpy as np
from pyNN.parameters import Sequence

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.pynn.invalid import InvalidValueError
from nrp_core.clock import MS_PER_S
from nrp_core.errors import CapabilityError

_NAME = "SpikeSourcePoissonVariable"


def variable_poisson(array: Any) -> type:
    """Return sPyNNaker's type of these sources.

    Args:
        array: the class of PyNN's ``SpikeSourceArray``.
    """

    def begin(self: Any, rates: Any, starts: Any, durations: Any = None) -> None:
        array.__init__(self, spike_times=Sequence([]))
        self.variable = VariableRates(rates, starts, durations)

    doc = "Poisson sources whose rates change at given times."
    return type(_NAME, (array,), {"__init__": begin, "__doc__": doc, "cell_type": "SpikeSourceArray"})


class VariableRates:
    """The rates of a population.

    Args:
        rates, starts, durations: Hz and ms; a list for all cells, or one for each.

    Raises:
        CapabilityError: a duration is missing, so that there is no last spike to draw.
    """

    def __init__(self, rates: Any, starts: Any, durations: Any = None) -> None:
        if durations is None:
            raise CapabilityError(
                f"{_NAME}: its durations are missing; spikes are drawn before the run, and need an end"
            )
        self._given = {"rates": rates, "starts": starts, "durations": durations}

    def trains(self, n: int, random: np.random.RandomState, step_ms: float) -> list[Any]:
        """Return the drawn spike times of ``n`` cells, which are at time steps.

        Raises:
            InvalidValueError: the lists do not fit together.
        """
        each = {name: self._of_cells(name, n) for name in self._given}
        drawn = (_train([each[name][cell] for name in each], random) for cell in range(n))
        return [Sequence(np.ceil(times / step_ms) * step_ms) for times in drawn]

    def _of_cells(self, name: str, n: int) -> list[FloatArray]:
        given = self._given[name]
        shared = not np.iterable(given[0]) if len(given) else True
        rows = [given] * n if shared else list(given)
        if len(rows) != n:
            raise InvalidValueError(f"{_NAME}: {name} has {len(rows)} lists for {n} cells")
        found = [np.asarray(row, float) for row in rows]
        if not all(np.isfinite(row).all() and (row >= 0).all() for row in found):
            raise InvalidValueError(f"{_NAME}: {name} has a value that is not a number of 0 or more")
        return found


def _train(phases: list[FloatArray], random: np.random.RandomState) -> FloatArray:
    rates, starts, durations = phases
    if not len(rates) == len(starts) == len(durations) or (np.diff(starts) < 0).any():
        raise InvalidValueError(
            f"{_NAME}: rates, starts and durations of a cell must be of one length, and starts must ascend"
        )
    ends = np.minimum(starts + durations, np.append(starts[1:], np.inf))
    counts = random.poisson(rates * (ends - starts) / MS_PER_S)
    parts = [random.uniform(a, b, n) for a, b, n in zip(starts, ends, counts, strict=True)]
    return np.sort(np.concatenate([np.empty(0), *parts]))
