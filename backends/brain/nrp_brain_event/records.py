"""The data of the compiled code: one record per neuron, event and spike, and arrays of them.

Times are in ms since reset; a time of infinity means never. An index of -1 means none.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Final, NamedTuple, cast, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from nrp_brain_event.synapse_laws import SHARES, rule_fields, share_fields

Array = npt.NDArray[Any]
Fields = list[tuple[str, str]]


def constant(value: int) -> int:
    """Return an integer of a type for which Numba does not compile a second specialisation."""
    return cast("int", np.int64(value))


# Kinds of membranes, between events.
LINEAR: Final = 0
CONDUCTANCE: Final = 1
ADAPTIVE_EXPONENTIAL: Final = 2
IZHIKEVICH: Final = 3
HODGKIN_HUXLEY: Final = 4
EQUATIONS: Final = 5
"""Given as equations; on a grid only."""

# Kinds of synapses, for an arriving spike.
EXPONENTIAL: Final = 0
ALPHA: Final = 1
JUMP: Final = 2
FROZEN: Final = 3
"""As ``EXPONENTIAL``, with weights in mV; reset by spikes, and deaf in the refractory period."""

# Reasons for a scheduled update of a neuron.
START: Final = 0
SEARCH: Final = 1
FIRE: Final = 2
STEP: Final = 3

# Results of a run that may stop early.
DONE: Final = 0
FULL: Final = 1
DIVERGED: Final = 2
PAUSED: Final = 3


Short = Annotated[int, np.int32]
"""An integer of 32 bits in a :class:`Record`."""


class Record:
    """Declares the fields of a structured array: floats, integers, small arrays with their shape.

    It has no instances: the elements of an array with this :meth:`dtype` have these attributes.
    """

    @classmethod
    @cache
    def dtype(cls) -> np.dtype[Any]:
        """Return the type of an array of such records."""
        fields: list[Any] = []
        for name, hint in get_type_hints(cls, include_extras=True).items():
            if hint == Short:
                fields.append((name, "i4"))
            elif get_origin(hint) is Annotated:
                fields.append((name, "f8", hint.__metadata__[0]))
            else:
                fields.append((name, "i8" if hint is int else "f8"))
        return np.dtype((np.record, [*fields, *cls.more_fields()]))

    @classmethod
    def more_fields(cls) -> Fields:
        """Return the fields that a table decides, after those of the class."""
        return []


class CellParameters(Record):
    """The parameters of a neuron by PyNN's names, and derived values."""

    v_reset: float
    v_thresh: float
    tau_refrac: float
    e_rev_E: float
    e_rev_I: float
    v_spike: float
    a: float
    b: float
    delta_T: float
    tau_w: float
    c: float
    d: float
    gbar_Na: float
    gbar_K: float
    g_leak: float
    v_offset: float
    e_rev_Na: float
    e_rev_K: float
    e_rev_leak: float
    cm: float
    tau_syn: Annotated[Array, (2,)]
    """tau_syn_E and tau_syn_I."""
    tolerance: float
    """Local error allowed to an integration step, mV."""
    scale: float
    """The same error in the other state variables, per mV."""
    quadrature: int
    """Whether its voltage is an integral where it stays below the threshold."""
    longest_step: float
    shortest_step: float
    """Minimum step, ms; a shorter one means that the equations cannot be integrated."""

    membrane: int
    synapse: int
    v_rest: float
    i_offset: float
    tau_m: float
    threshold: float
    """Voltage at which it fires, mV."""
    leak: float
    """1 / tau_m."""
    fading: Annotated[Array, (2,)]
    """1 / tau_syn."""
    per_cm: float
    """1 / cm."""
    resistance: float
    """tau_m / cm, MOhm."""


class Cell(CellParameters):
    """A neuron: its parameters, its state at the time ``t`` of its last event, and its schedule.

    The fields that every event needs are contiguous, from ``membrane`` to the voltage.
    """

    t: float
    free_at: float
    """End of the refractory time."""
    armed: int
    """Whether it has been below threshold since its last spike."""
    current: float
    """External current, nA."""
    x: Annotated[Array, (2,)]
    s: Annotated[Array, (2,)]
    """State of each synapse, ``(x + s dt) exp(-dt / tau_syn)``, uS or nA."""
    wake: float
    on_wake: int
    listed: float
    """Latest time of its entry in the calendar."""
    path: Annotated[Array, (4, 5)]
    """The state variables as polynomials in the fraction of the step; the first is the voltage."""

    id: int
    """Global id."""
    step: float
    next_step: float
    n_fired: int
    first_stored: int
    last_stored: int
    n_stored: int
    """The list of its spikes, stored as events, that its plastic synapses may still have to process."""


class Modes(Record):
    """The state of a neuron that is a sum of exponentials (:mod:`nrp_brain_event.linear`); a cache line."""

    x_e: float
    x_i: float
    """Coefficients of the synapses, nA."""
    membrane: float
    """Coefficient of the membrane, mV; not a number in the refractory period."""
    settled: float
    """Steady-state voltage for the constant currents alone, mV."""
    t: float
    wake: float
    listed: float
    """As of a :class:`Cell`, whose fields are out of date; so is ``on_wake``."""
    kind: Short
    """-1: another neuron, of which the :class:`Cell` is everything."""
    on_wake: Short


class Kind(Record):
    """Neurons with equal parameters, and the factors that they share at the time ``t``."""

    tau_m: float
    threshold: float
    resistance: float
    epoch: float
    """Length of an epoch, ms: a power of two."""
    rate_m: float
    rate_e: float
    rate_i: float
    """Inverse time constants."""
    reach_e: float
    reach_i: float
    """Voltage that belongs to a current which decays, mV per nA; 0 if spikes change the voltage itself."""
    t: float
    begin: float
    """Beginning of the epoch at ``t``."""
    left_m: float
    left_e: float
    left_i: float
    """Remaining shares since then."""
    grown_e: float
    grown_i: float
    """Their inverses."""
    step_e: float
    step_i: float
    """Decrease of the coefficient of the membrane by a weight of 1 nA (or of 1 mV for jumps), mV."""


HOT: Final = int(Cell.dtype().fields["membrane"][1])  # type: ignore[index]
COLD: Final = int(Cell.dtype().fields["path"][1]) + 8  # type: ignore[index]
"""Offset in the record of a neuron of the part that every event needs, bytes."""


class Event(Record):
    """A spike in transit.

    A target is twice the row of a cell, plus one for the inhibitory receptor; or ``~p`` for the target of
    plastic synapse p, which then determines the weight. If ``n`` is not zero, the spike arrives at n
    synapses, and the target is the first of these. The weight is then the time at which the spike was sent:
    if more synapses follow, their event is made when this one is about to arrive, and the weight becomes
    negative infinity.
    """

    time: float
    weight: float
    target: int
    n: int
    after: int


class Link(Record):
    """The place of a neuron in the calendar: the window, and its neighbours in the list.

    It is separate from the neuron, so that the links of all neurons fit into the faster caches.
    """

    window: int
    before: int
    after: int


class Spike(Record):
    """A spike of a neuron, by global id."""

    time: float
    id: int


class ShortTerm(Record):
    """A synapse that transmits a share of its weight; see :mod:`nrp_brain_event.synapse_laws`."""

    @classmethod
    def more_fields(cls) -> Fields:
        return share_fields(SHARES)


class Plastic(Record):
    """A plastic synapse, with the state that most laws have; see :mod:`nrp_brain_event.synapse_kernels`.

    Networks have millions of them, so a record is no longer than needed: what few laws use is in ``Slow``,
    and the time of the last processed spike of the target is that of ``last_seen``.
    """

    weight: float
    """The absolute value of the weight."""
    dendritic_delay: float
    pre_t: float
    """The time of the last processed spike of the source; of either side in a law given as equations."""
    pre_trace: float
    post_trace: float
    rule: Short
    target: Short
    """The target, as of an event."""
    last_seen: Short
    """The last processed spike of the target, an event."""
    unused: Short
    """Keeps the numbers aligned."""


class Slow(Record):
    """More state of a plastic synapse: slow traces, and variables of laws given as equations."""

    pre_slow: float
    post_slow: float
    own: float


class Rule(Record):
    """The common parameters of plastic synapses by PyNN's names; limits are absolute values."""

    law: int
    """The kernel, as its place in the table of rules."""
    sign: int
    """The sign of the weights."""
    frozen: int
    """Whether weights do not change."""

    @classmethod
    def more_fields(cls) -> Fields:
        return rule_fields()


class Clock(Record):
    """The position of the engine in time."""

    now: float
    slot: int
    """The current window, counted from time 0."""
    width: float
    per_width: float
    """Length of a window: a power of two, at most the shortest delay; and its inverse."""
    free: int
    n_free: int
    """Head and length of the list of free events."""
    arriving: int
    arrived: int
    """The first event still to arrive in the current window, and the number of synapses it has reached."""
    n_spikes: int
    failed: int
    """The neuron whose integration failed."""


class Work(Record):
    """Work space for intermediate results."""

    stages: Annotated[Array, (7, 4)]
    """Slopes at the stages of an integration step."""
    y: Annotated[Array, (4,)]
    """State at a stage."""
    conductances: Annotated[Array, (7, 2)]
    """Conductances of both synapses at the stages."""
    function: Annotated[Array, (10,)]
    zeros: Annotated[Array, (8,)]
    """Coefficients and zeros in the search for a threshold crossing."""


class EngineArrays(NamedTuple):
    """All arrays that the compiled code reads and writes.

    Args:
        cells: ``Cell``, the neurons that are not sources.
        modes: ``Modes``, of the same neurons.
        kinds: ``Kind``.
        row_of: row in ``cells`` by global id, -1 for sources.
        first, target, weight, delay, dynamics: the synapses of neuron ``i`` are those from
            ``first[i]`` to ``first[i + 1]``; ``dynamics`` is a row of ``short_term`` or -1, and empty if no
            synapse has one.
        bundle: at the first of the static synapses with the same neuron and delay, their number, else 0;
            it is negative if more static synapses of the neuron follow.
        short_term: ``ShortTerm``.
        plastic: ``Plastic``, in the order of the cells they end on.
        slow: ``Slow``, of the plastic synapses if a law of the network needs it, else a single one.
        first_plastic: the plastic synapses onto the cell in row ``i`` are those from ``first_plastic[i]``
            to ``first_plastic[i + 1]``; empty where there are none at all.
        rules: ``Rule``.
        clock: ``Clock``, shape ``(1,)``.
        events: ``Event``, a pool; events in transit and free ones form linked lists.
        event_slots, cell_slots: first event and first scheduled cell in each window of the calendar;
            the last entry is for events beyond the last window.
        links: ``Link``, of the neurons.
        sorting: first events of sorted lists of 1, 2, 4, ... events during a merge sort.
        spikes: ``Spike``, those not yet taken.
        work: ``Work``, shape ``(1,)``.
    """

    cells: Annotated[Array, Cell]
    modes: Annotated[Array, Modes]
    kinds: Annotated[Array, Kind]
    row_of: Annotated[Array, np.int64]
    first: Annotated[Array, np.int64]
    target: Annotated[Array, np.int32]
    weight: Annotated[Array, np.float64]
    delay: Annotated[Array, np.float64]
    dynamics: Annotated[Array, np.int32]
    bundle: Annotated[Array, np.int32]
    short_term: Annotated[Array, ShortTerm]
    plastic: Annotated[Array, Plastic]
    slow: Annotated[Array, Slow]
    first_plastic: Annotated[Array, np.int64]
    rules: Annotated[Array, Rule]
    clock: Annotated[Array, Clock]
    events: Annotated[Array, Event]
    event_slots: Annotated[Array, np.int64]
    cell_slots: Annotated[Array, np.int64]
    links: Annotated[Array, Link]
    sorting: Annotated[Array, np.int64]
    spikes: Annotated[Array, Spike]
    work: Annotated[Array, Work]


CONSTANT: Final = frozenset(
    {"row_of", "first", "target", "weight", "delay", "dynamics", "bundle", "first_plastic", "rules"}
)
"""The parts of the engine that do not change by running."""
