"""The spinal circuits of four muscles: a flexor and an extensor at the shoulder and at the elbow.

Of each muscle, Ia fibres excite its motoneurons (monosynaptic reflex) and, through inhibitory interneurons,
silence those of its antagonist (reciprocal inhibition), whose interneurons they inhibit too. Renshaw cells
limit the rates of motoneurons, and interneurons of Ib fibres reduce large tensions. A constant current, in
place of commands from the brain, keeps the smallest motoneurons active. Connections are those of J. C. Eccles
and others, see E. Pierrot-Deseilligny and D. Burke, The Circuitry of the Human Spinal Cord (2005).

Units are PyNN's: mV, ms, nF, nA.
"""

from nrp_core import pynn as sim
from nrp_core.brain import MotoneuronPool

MUSCLES = ("shoulder_flexor", "shoulder_extensor", "elbow_flexor", "elbow_extensor")
ANTAGONIST = (1, 0, 3, 2)
FIBRES, MOTONEURONS, INTERNEURONS, RENSHAW, IB = 40, 60, 20, 20, 15

reflex = sim.parameter("reflex", 0.28, unit="nA", low=0, high=2, doc="weight of Ia fibres on motoneurons")
reciprocal = sim.parameter(
    "reciprocal", 0.2, unit="nA", low=-2, high=2,
    doc="weight of the inhibition of antagonists; a negative one excites them",
)  # fmt: skip

sim.setup(timestep=0.5)

cell = {"cm": 0.2, "tau_m": 10.0, "tau_refrac": 2.0, "tau_syn_E": 2.0, "tau_syn_I": 2.0, "v_thresh": -50.0}
tonic = sim.RandomDistribution("uniform", (0.25, 0.35))
pool = MotoneuronPool(MOTONEURONS, recruitment=5.0)


def population(size, label, **more):
    """Return a population of one kind for all muscles, muscle by muscle."""
    return sim.Population(len(MUSCLES) * size, sim.IF_curr_exp(**{**cell, **more}), label=label)


units = pool.parameters()
units["cm"] = units["cm"] * len(MUSCLES)
ia = population(FIBRES, "ia")
motoneurons = sim.Population(
    len(MUSCLES) * MOTONEURONS, sim.IF_curr_exp(i_offset=tonic, **units), label="motoneurons"
)
reciprocals = population(INTERNEURONS, "reciprocals")
renshaw = population(RENSHAW, "renshaw")
ib = population(IB, "ib")


def of(cells, size, muscle):
    """Return the cells of a muscle."""
    return cells[size * muscle : size * (muscle + 1)]


def connect(source, target, weight, share, delay=1.0):
    """Connect cells with a probability; negative weights inhibit."""
    sim.Projection(
        source,
        target,
        sim.FixedProbabilityConnector(share),
        sim.StaticSynapse(weight=weight, delay=delay),
        receptor_type="excitatory" if weight >= 0 else "inhibitory",
    )


for muscle, other in enumerate(ANTAGONIST):
    own, fibres = of(motoneurons, MOTONEURONS, muscle), of(ia, FIBRES, muscle)
    inhibitors = of(reciprocals, INTERNEURONS, muscle)
    connect(fibres, own, reflex, 0.9)
    connect(fibres, inhibitors, 0.4, 0.5)
    connect(inhibitors, of(motoneurons, MOTONEURONS, other), -reciprocal, 0.5)
    connect(inhibitors, of(reciprocals, INTERNEURONS, other), -0.1, 0.5)
    connect(own, of(renshaw, RENSHAW, muscle), 1.2, 0.3)
    connect(of(renshaw, RENSHAW, muscle), own, -0.1, 0.3)
    connect(of(renshaw, RENSHAW, muscle), inhibitors, -0.05, 0.3)
    connect(of(ib, IB, muscle), own, -0.05, 0.3)
