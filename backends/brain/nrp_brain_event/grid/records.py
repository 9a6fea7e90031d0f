"""The data of the compiled code of the grid mode.

Time is counted in steps since reset: step k ends at grid point k. A *row* is a simulated neuron, in the order
of :func:`nrp_brain_event.cells.load_cells`.
"""

from __future__ import annotations

from typing import Annotated, Final, NamedTuple

import numpy as np

from nrp_brain_event.records import (
    Array,
    Cell,
    Event,
    Plastic,
    Record,
    Rule,
    Short,
    ShortTerm,
    Slow,
    Spike,
    Work,
)

# Rows of the state.
V: Final = 0
"""Voltage above rest, mV; not a number while a neuron is refractory."""
X: Final = 1
"""Current (nA) or conductance (uS) of both synapses; for jump and curved membranes, the present input."""
S: Final = 3
"""Growth of the same for alpha synapses: x follows ``(x + s e t / tau) exp(-t / tau)``."""
N_STATE: Final = 5

# How the neurons of a run advance.
CURRENT: Final = 0
CONDUCTANCE: Final = 1
JUMP: Final = 2
CURVED: Final = 3
"""Without a closed form: integrated one by one."""
EQUATIONS: Final = 4
"""Given as equations, with a kernel of their own."""


class Run(Record):
    """Neurons in consecutive rows with equal parameters: the coefficients of their update by a step."""

    first: int
    last: int
    kind: int
    alpha: int
    """Whether synapses are alpha-shaped."""
    frozen: int
    """Whether spikes reset the synapses, which are in mV and deaf in the refractory period."""
    refractory: int
    """Steps."""
    v_rest: float
    reset: float
    threshold: float
    """Above rest, mV."""
    leak: float
    """``exp(-h / tau_m)``; for conductances ``h / tau_m``."""
    gain: float
    """Change of voltage by 1 nA; for conductances ``h / cm``."""
    reversal: Annotated[Array, (2,)]
    """Above rest, mV."""
    kept: Annotated[Array, (2,)]
    """``exp(-h / tau_syn)``."""
    grown: Annotated[Array, (2,)]
    """``e h / tau_syn``."""
    x_effect: Annotated[Array, (2,)]
    s_effect: Annotated[Array, (2,)]
    """Change of voltage by a unit of x and s; for conductances the mean in the step times ``h / cm``."""
    x_moment: Annotated[Array, (2,)]
    s_moment: Annotated[Array, (2,)]
    """For conductances: the first moment in the step about its middle, in steps, times ``h / cm``."""
    head: int
    n_waiting: int
    """Start of the queue of refractory neurons in ``queue[first:last]``, and its length."""


class Block(Record):
    """A population whose cells are given as equations; see :mod:`nrp_brain_event.grid.equations`."""

    code: int
    """Its kernel, see :func:`~nrp_brain_event.handles.call`."""
    first: int
    last: int
    """Its rows."""
    value: int
    constant: int
    """The first of its ``values`` and of its ``constants``."""


class Segment(Record):
    """Synapses of one neuron and one table with equal delays: a run of ``targets``."""

    start: int
    length: Short
    gap: Short
    """How many steps later it arrives than the segment before it."""
    table: Short
    last: Short
    """Whether it is the last of its neuron."""


class Table(Record):
    """Synapses of one kind onto at most 65536 neurons.

    ``targets`` hold the distance from ``line`` in the flattened state. Equal weights are kept once.
    """

    line: int
    weight: float
    own: int
    """Whether each synapse has its own weight, and the offset from the synapse to it."""
    weights: int
    dynamic: int
    """Dynamics of the synapses, ``SHORT_TERM`` or ``PLASTIC``, or 0."""
    dynamics: int
    """Offset from the synapse to its place in ``short_term`` or ``plastic_rows``."""


SHORT_TERM: Final = 1
PLASTIC: Final = 2

# Kernels that only some networks need, see grid/on_demand.py: their place in ``codes``.
UPDATE_CURVED: Final = 0
ADD_NOISE: Final = 1
HEAR_NOISE: Final = 2
TAKE_SAMPLES: Final = 3
SET_CURVED_CURRENT: Final = 4
DELIVER: Final = 5
DELIVER_LATE: Final = 6
STORE_FOR_PLASTIC: Final = 7
UPDATE_BLOCKS: Final = 8
COUPLE: Final = 9
FOLLOW: Final = 10
LOOK_AT_BLOCKS: Final = 11
ADVANCE_ROW: Final = 12
N_ON_DEMAND: Final = 13


class Memory(Record):
    """The spikes of a neuron that its plastic synapses may still have to process; see ``Cell``."""

    wake: float
    """Time of its last spike, ms."""
    n_fired: int
    first_stored: int
    last_stored: int
    n_stored: int


class Pool(Record):
    """The list of free places for stored spikes."""

    free: int
    n_free: int


class Noise(Record):
    """Poisson cells of equal rate, each with one synapse; numbers in ``noise_lines`` and ``noise_ids``."""

    key: int
    origin: int
    n_words: int
    """The first cell of their population, and the number of random words for it in a step."""
    first: int
    last: int
    """The cells that are drawn in this part."""
    guide: int
    """Row of the tables of counts."""
    weight: float
    delay: int
    begin: int
    end: int
    """Spikes are emitted in the steps after ``begin`` up to ``end``."""
    heard: int
    """Whether the spikes are recorded."""
    consecutive: int
    """Whether the numbers in ``noise_lines`` follow each other."""


class Probe(Record):
    """A state variable that is recorded while the grid runs; see :mod:`nrp_brain_event.grid.readout`."""

    variable: int
    """Index in ``READABLE``."""
    step: int
    n_steps: int
    taken: int
    """First of its steps in ``probe_steps``, their number, and how many of them have passed."""
    row: int
    n_rows: int
    """First of its rows in ``probe_rows``, and their number."""
    sample: int
    """First of its samples in ``samples``: all rows at the first step, then at the next."""
    plain: int
    """Whether the state of the grid holds them as voltages of consecutive rows."""


# What acts on a cell by the voltage of another one.
GAP: Final = 0
SIGMOID: Final = 1
RECTIFIED: Final = 2


class Coupled(Record):
    """A cell at an end of a coupling, see :mod:`nrp_brain_event.grid.couplings`; in mV and nA."""

    row: int
    place: int
    """Of its voltage among ``values``, or -1."""
    rest: float
    reset: float
    """Its voltage in the refractory period, if the state holds none then."""
    response: float
    """Change of its voltage in a step by 1 nA."""
    jumps: int
    """Whether a spike resets its voltage."""
    first: int
    last: int
    """The ``couplings`` onto it."""
    steady: float
    """The current into it that is not due to them."""
    current: float
    """The mean current that is due to them, in the present step."""
    v: float
    own: float
    """Its voltage at the grid point, and how much other causes changed it in the last step."""
    middle: float
    """Its voltage in the middle of the step."""


class Coupling(Record):
    """What acts on a cell by the voltage of another one."""

    source: int
    target: int
    """Indices in ``coupled``."""
    law: int
    """``GAP``, ``SIGMOID`` or ``RECTIFIED``."""
    receptor: int
    """0 and 1 for a conductance onto the excitatory and the inhibitory receptor, -1 for a current."""
    reversal: float
    """Of a conductance by graded release, mV."""
    weight: float
    """uS or nA."""
    v_th: float
    slope: float
    """mV."""
    kept: float
    """Of the difference between ``s`` and its function of the voltage, after half a step."""
    s: float
    """The share of the weight that acts at the grid point."""


class Input(Record):
    """What is not in the calendar: the spike of a source cell, or the event of a device or in transit."""

    step: int
    target: int
    """Global id of the source cell that fires, or flat index into the state."""
    synapse: int
    """Plastic synapse that determines the weight, or -1."""
    weight: float


class GridClock(Record):
    """The position of the grid in time."""

    step: int
    free: int
    n_free: int
    """Head and length of the list of free calendar entries."""
    n_fired: int
    n_spikes: int
    n_sources: int
    source: int
    n_arrivals: int
    arrival: int
    """Number of ``sources`` and ``arrivals``, and the next one of each."""
    is_mixed: int
    """Whether these are not in order yet."""
    n_out: int
    window: int
    """Spikes in ``outbox``; steps after which they are sent, at most the shortest delay of any neuron."""
    failed: int
    h: float
    """Length of a step, ms."""
    step_ns: int


class Grid(NamedTuple):
    """All arrays that the compiled code reads and writes.

    Args:
        clock: ``GridClock``, shape ``(1,)``.
        runs: ``Run``.
        state: shape ``(N_STATE, n_rows)``.
        drive: constant current into each row, nA.
        ids: global id of each row.
        queue: rows that are refractory, a ring for each run.
        release: step before which a row's refractory period ends.
        cells, cell_rows: ``Cell`` of the curved neurons; index among them, or -1.
        work: ``Work``, shape ``(1,)``.
        blocks: ``Block``; not kept in snapshots, since addresses belong to a process.
        values: variables of each block in SI units, concatenated, with one value per row.
        constants: parameters and propagators of each block, in the same order.
        codes: what :func:`~nrp_brain_event.handles.call` needs to call the kernels that only some networks
            need; not kept in snapshots, since addresses belong to a process.
        scratch: shape ``(4, BLOCK)``.
        fired: rows that fire in the current step.
        row_first: first segment of each global id, shape ``(network.size + 1,)``.
        segments: ``Segment``, in the order in which the spikes of each neuron pass them.
        tables: ``Table``.
        targets: uint16, all synapses.
        weights: float32, weights of the synapses that have their own.
        short_term: ``ShortTerm``.
        plastic, slow, first_plastic, rules: as in :class:`~nrp_brain_event.records.EngineArrays`.
        plastic_rows: row in ``plastic`` of each plastic synapse, in the order of ``targets``.
        memories: ``Memory``, one a row; none without plastic synapses.
        stored: ``Event``, the stored spikes.
        pool: ``Pool``, shape ``(1,)``.
        slots: head of the list of segments that arrive in a step, a ring.
        entry_segment, entry_after: the entries of the lists.
        sources: ``Input``, spikes of source cells.
        arrivals: ``Input``, events outside the calendar; both in order once they are arranged.
        lines: flat index into the state on which devices act, by receptor and global id.
        outbox: spikes to be sent at the end of the window: twice the step, and one more where the neuron
            advances after the arrivals; row. Ascending, shape ``(2, room)``.
        spikes: ``Spike``, not yet taken.
        noise: ``Noise``.
        noise_lines, noise_ids: index into the flattened state on which each Poisson cell acts (unsigned, so
            that it is not checked for a sign), and its global id.
        noise_guides, noise_bounds: see :mod:`nrp_brain_event.grid.poisson`.
        coupled: ``Coupled``, in the order of their rows.
        couplings: ``Coupling``, in the order of their targets.
        coupled_rows: index in ``coupled`` of each row, or -1; none without couplings.
        probes: ``Probe``.
        probe_steps, probe_rows: steps and rows of the samples of each probe.
        probe_values: place of each of these in ``values``, or -1, and the size of its unit; shape ``(2, n)``.
        probe_rest: voltages of these rows at rest and, as reported, while refractory; mV, shape ``(2, n)``.
        samples: the samples, filled while the grid runs.
    """

    clock: Annotated[Array, GridClock]
    runs: Annotated[Array, Run]
    state: Annotated[Array, np.float64, 2]
    drive: Annotated[Array, np.float64]
    ids: Annotated[Array, np.int64]
    queue: Annotated[Array, np.int32]
    release: Annotated[Array, np.int64]
    cells: Annotated[Array, Cell]
    cell_rows: Annotated[Array, np.int64]
    work: Annotated[Array, Work]
    blocks: Annotated[Array, Block]
    values: Annotated[Array, np.float64]
    constants: Annotated[Array, np.float64]
    codes: Annotated[Array, np.int64]
    scratch: Annotated[Array, np.float64, 2]
    fired: Annotated[Array, np.int32]
    row_first: Annotated[Array, np.int64]
    segments: Annotated[Array, Segment]
    tables: Annotated[Array, Table]
    targets: Annotated[Array, np.uint16]
    weights: Annotated[Array, np.float32]
    short_term: Annotated[Array, ShortTerm]
    plastic: Annotated[Array, Plastic]
    slow: Annotated[Array, Slow]
    first_plastic: Annotated[Array, np.int64]
    rules: Annotated[Array, Rule]
    plastic_rows: Annotated[Array, np.int32]
    memories: Annotated[Array, Memory]
    stored: Annotated[Array, Event]
    pool: Annotated[Array, Pool]
    slots: Annotated[Array, np.int32]
    entry_segment: Annotated[Array, np.int32]
    entry_after: Annotated[Array, np.int32]
    sources: Annotated[Array, Input]
    arrivals: Annotated[Array, Input]
    lines: Annotated[Array, np.int64, 2]
    outbox: Annotated[Array, np.int64, 2]
    spikes: Annotated[Array, Spike]
    noise: Annotated[Array, Noise]
    noise_lines: Annotated[Array, np.uint32]
    noise_ids: Annotated[Array, np.int32]
    noise_guides: Annotated[Array, np.int32, 2]
    noise_bounds: Annotated[Array, np.uint64, 2]
    coupled: Annotated[Array, Coupled]
    couplings: Annotated[Array, Coupling]
    coupled_rows: Annotated[Array, np.int64]
    probes: Annotated[Array, Probe]
    probe_steps: Annotated[Array, np.int64]
    probe_rows: Annotated[Array, np.int64]
    probe_values: Annotated[Array, np.float64, 2]
    probe_rest: Annotated[Array, np.float64, 2]
    samples: Annotated[Array, np.float64]


CHANGING: Final = (
    "clock", "runs", "state", "drive", "queue", "release", "cells", "values", "constants", "short_term",
    "plastic", "slow", "memories", "stored", "pool", "slots", "entry_segment", "entry_after", "outbox",
    "spikes", "noise", "coupled", "couplings",
)  # fmt: skip
"""The parts of the grid that change while running, apart from ``sources`` and ``arrivals``."""
WITHOUT_COPY: Final = frozenset({"plastic", "slow"})
"""The parts that change and of which the initial state is not kept, since they can be large."""
BLOCK: Final = 512
"""Number of neurons that are advanced together, so that their data stay in the level-1 cache."""
