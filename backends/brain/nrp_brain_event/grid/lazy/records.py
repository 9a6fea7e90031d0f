"""The data of the lazy grid; connections, calendar and spikes are those of the :class:`Grid`."""

from __future__ import annotations

from typing import Annotated, Final, NamedTuple

import numpy as np

from nrp_brain_event.records import Array, Record, Short

# Columns of the course of a neuron over some steps.
LEAK: Final = 0
KEPT: Final = 1
X_EFFECT: Final = 2
S_EFFECT: Final = 3
SECOND: Final = 3
"""Distance to the columns of the inhibitory receptor."""
N_COURSE: Final = 7
DEPTH: Final = 1024
"""Number of steps for which courses are tabulated; longer ones are put together."""


class Neuron(Record):
    """A neuron at its last event: 64 bytes, of which an arrival needs the first 48."""

    v: float
    """Voltage above rest, mV."""
    step: int
    """The step at which this held."""
    free: int
    """The last step of its refractory period."""
    kind: Short
    listed: Short
    """Whether it is in a list of those that may reach the threshold."""
    x: Annotated[Array, (2,)]
    """Input of both receptors as in the grid, one if they decay alike; for jumps, the input of this step."""
    s: Annotated[Array, (2,)]


class Kind(Record):
    """Neurons with equal parameters, see :class:`~nrp_brain_event.grid.records.Run`."""

    jump: int
    alpha: int
    frozen: int
    single: int
    """Whether the inputs of both receptors decay alike and are one."""
    simple: int
    """Whether the input is one, and exponential."""
    refractory: int
    reset: float
    threshold: float
    resistance: float
    """MOhm."""
    grown: Annotated[Array, (2,)]
    x_peak: Annotated[Array, (2,)]
    s_peak: Annotated[Array, (2,)]
    """The highest voltage to which a unit of x or s alone leads."""
    course: int
    """First row of its courses."""


class LazyClock(Record):
    """Counts of the lazy grid."""

    n_early: int
    n_late: int
    """Neurons in the lists of those that may reach the threshold."""
    driven: int
    """Whether any neuron has a constant current."""
    n_arrived: int
    n_checked: int
    """Arrivals, and steps of single neurons, since the last judgement of the costs."""
    costly: int
    """How many judgements in succession found the plain grid cheaper."""


class Lazy(NamedTuple):
    """All arrays of the lazy grid.

    Args:
        clock: ``LazyClock``, shape ``(1,)``.
        kinds: ``Kind``.
        neurons: ``Neuron`` in each row.
        courses: factors of the state of a kind after 0, 1, ... steps, ``DEPTH`` rows a kind.
        early, late: rows that may reach the threshold: those that advance before the arrivals of a step, and
            those on which they act at once.
    """

    clock: Annotated[Array, LazyClock]
    kinds: Annotated[Array, Kind]
    neurons: Annotated[Array, Neuron]
    courses: Annotated[Array, np.float64, 2]
    early: Annotated[Array, np.int32]
    late: Annotated[Array, np.int32]


CHANGING: Final = ("clock", "neurons", "early", "late")
"""The parts that change while running."""
