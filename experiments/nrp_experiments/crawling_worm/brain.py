"""The motor circuit of a crawling *C. elegans*: bistable neurons that stretch of the body switches.

It is the circuit of J. H. Boyle, S. Berri and N. Cohen, Front. Comput. Neurosci. 6:10 (2012), section 2.2, in
graded cells, which the worm has: their voltage, not spikes, releases transmitter. The command neurons AVB
drive twelve units along the body. In each, a dorsal and a ventral motoneuron of class B (``DB``, ``VB``)
excite the muscles of their side; motoneurons of class D (``DD``, ``VD``) inhibit those of the other side, and
``VD`` also inhibits ``VB``. B neurons excite themselves, by which they are on or off: one switches on where
its input exceeds 0.75 nA and off where it is below 0.25 nA. Their receptors of stretch, which ``crawl.py``
adds, feel the half of the body behind them. Nothing in the circuit oscillates without a body.

With ``cord`` the motoneurons and their synapses are those of the adult hermaphrodite, in
:mod:`nrp_experiments.worm`: 7 DB, 11 VB, 6 DD and 13 VD. The input of a cell from a class is a mean, weighted
by numbers of sections. Synapses of B neurons on D neurons of their own side are left out: with them, the worm
does not crawl. Muscles of the head, which other neurons move, follow the first of the trunk.

1 nA depolarises a cell by 10 mV. Units are PyNN's: mV, ms, nF, nA.
"""

import numpy as np

import nrp_core.pynn as sim
from nrp_experiments.worm import synapses

SEGMENTS, UNITS = 24, 12
COMMAND, SELF = 0.675, 0.5
REST, STEEP = -60.0, 0.1
ON, HALF = 0.75, 0.5  # inputs at which a B neuron switches on, and at which other cells release

cord = sim.parameter("cord", False, doc="whether the synapses are those of the connectome")

sim.setup(timestep=0.5)


def cells(size, label, tau_m=2.0, offset=0.0, start=REST):
    """Return cells that do not spike, with 10 MOhm each."""
    kind = sim.IF_curr_exp(cm=tau_m / 10.0, tau_m=tau_m, v_rest=REST, v_thresh=1000.0, i_offset=offset)
    return sim.Population(size, kind, label=label, initial_values={"v": start})


def connect(pre, post, weights, threshold, sign=1):
    """Connect cells by a matrix of weights, nA; a source releases where its input exceeds a threshold, nA."""
    release = sim.GradedSynapse(v_th=REST + 10.0 * threshold, slope=STEEP, tau_s=0.0)
    rows = [(int(a), int(b), sign * float(weights[a, b])) for a, b in zip(*weights.nonzero(), strict=True)]
    return sim.Projection(
        pre, post, sim.FromListConnector(rows, ["weight"]), release,
        receptor_type="excitatory" if sign > 0 else "inhibitory", label=f"{pre.label} to {post.label}",
    )  # fmt: skip


def means(weights):
    """Return weights whose sum is 1 for each target."""
    return weights / np.maximum(weights.sum(axis=0), 1e-9)


def onto_muscles(neurons, side):
    """Return the shares of neurons in the input of each muscle of a side."""
    if not cord:
        return np.repeat(np.eye(UNITS), SEGMENTS // UNITS, axis=1)
    both = [synapses(neurons, [f"M{side}{half}{row:02}" for row in range(1, SEGMENTS + 1)]) for half in "LR"]
    shares = means(sum(both))
    reached = np.flatnonzero(shares.any(axis=0))
    nearest = reached[np.abs(np.subtract.outer(reached, np.arange(SEGMENTS))).argmin(axis=0)]
    return shares[:, nearest]


def between(sources, targets):
    """Return the shares of sources in the input of each target."""
    return means(synapses(sources, targets)) if cord else np.eye(UNITS)


def named(kind, number):
    """Return the names of the neurons of a class."""
    return [f"{kind}{n + 1}" for n in range(number if cord else UNITS)]


NAMES = {kind: named(kind, number) for kind, number in (("DB", 7), ("VB", 11), ("DD", 6), ("VD", 13))}
AVB = cells(2, "AVB", offset=1.0)
DB = cells(len(NAMES["DB"]), "DB", start=REST + 10.0)  # all dorsal ones begin on
VB = cells(len(NAMES["VB"]), "VB", offset=0.5)
DD, VD = (cells(len(NAMES[kind]), kind) for kind in ("DD", "VD"))
dorsal, ventral = (cells(SEGMENTS, side, tau_m=100.0) for side in ("dorsal", "ventral"))

efficacy = 0.7 * (1 - 0.6 * np.arange(SEGMENTS) / SEGMENTS)
efficacy[0] /= 1.5  # the head bends less


def wire(excites, inhibits, muscles, others):
    """Connect the motoneurons of one side of the body."""
    ours, theirs = NAMES[excites.label], NAMES[inhibits.label]
    connect(AVB, excites, np.full((2, len(ours)), COMMAND / 2), HALF)
    connect(excites, excites, SELF * np.eye(len(ours)), ON)
    connect(excites, inhibits, between(ours, theirs), ON)
    connect(excites, muscles, efficacy * onto_muscles(ours, muscles.label[0].upper()), ON)
    connect(inhibits, others, efficacy * onto_muscles(theirs, others.label[0].upper()), HALF, sign=-1)


wire(DB, VD, dorsal, ventral)
wire(VB, DD, ventral, dorsal)
connect(VD, VB, between(NAMES["VD"], NAMES["VB"]), HALF, sign=-1)
